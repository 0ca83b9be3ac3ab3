// In how many markings of a set conditions hold, and which of them holds in some.
//
// The nodes of the diagram stand in arrays, the deepest level first, so that children come before their parents: a
// condition is one pass over the nodes between its first and its last level, without looking anything up. Whether
// conditions hold anywhere is asked of 64 at a time, a bit for each.
#include "diagrams/store.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace mcpn {

// The nodes of a diagram in arrays: 0 and 1 are the terminals, the root comes last.
class Levelled {
 public:
  Levelled(Store& store, Node a, Scratch& scratch) : levels(store.levels) {
    std::vector<std::uint32_t> count(levels + 1, 0);
    std::uint64_t nodes = 2;
    store.walk(a, [&](Node n) { ++count[store.level(n)], ++nodes; });
    if (store.number_.size() < store.nodes_.size()) {
      store.require(store.nodes_.size() * sizeof(std::uint32_t));
      store.number_.resize(store.nodes_.size());
    }
    scratch.take((std::size_t(levels) + 2) * 2 * sizeof(std::uint32_t) + nodes * 3 * sizeof(std::uint32_t));
    from.assign(levels + 1, 2);
    for (Level at = levels; at-- > 0;) from[at] = from[at + 1] + count[at + 1];
    std::vector<std::uint32_t> next = from;
    lo.resize(nodes), hi.resize(nodes), level.assign(nodes, levels);
    store.walk(a, [&](Node n) { store.number_[n] = next[store.level(n)]++; });
    const auto number = [&](Node n) { return n < 2 ? n : store.number_[n]; };
    store.walk(a, [&](Node n) {
      const std::uint32_t i = number(n);
      lo[i] = number(store.lo(n)), hi[i] = number(store.hi(n)), level[i] = store.level(n);
    });
    root = number(a);
  }
  std::size_t size() const { return lo.size(); }
  // The first node of a level, and the one after the last of those that are at or below the next level up.
  std::uint32_t begin(Level at) const { return from[at]; }
  std::uint32_t end(std::int64_t above) const { return above < 0 ? std::uint32_t(size()) : from[std::size_t(above)]; }
  bool marks(Level at) const { return begin(at) != end(std::int64_t(at) - 1); }

  const Level levels;
  std::vector<std::uint32_t> lo, hi, from;
  std::vector<Level> level;
  std::uint32_t root;
};

namespace {

using Word = std::uint64_t;

// Numbers of so many words, none of whose sums and products here is larger: no node has more markings than the whole.
template <std::size_t Fixed> struct Exact {
  std::size_t width;
  std::size_t words() const { return Fixed ? Fixed : width; }
  void add(Word* to, const Word* more) const {
    WideWord carry = 0;
    for (std::size_t i = 0; i < words(); ++i) {
      carry += WideWord(to[i]) + more[i];
      to[i] = Word(carry);
      carry >>= 64;
    }
  }
  void add_product(Word* to, const Word* a, const Word* b) const {
    for (std::size_t i = 0; i < words(); ++i) {
      if (a[i] == 0) continue;
      WideWord carry = 0;
      for (std::size_t j = 0; i + j < words(); ++j) {
        carry += WideWord(a[i]) * b[j] + to[i + j];
        to[i + j] = Word(carry);
        carry >>= 64;
      }
    }
  }
};

// Whether there is one at all.
struct Some {
  std::size_t words() const { return 1; }
  void add(Word* to, const Word* more) const { *to |= *more; }
  void add_product(Word* to, const Word* a, const Word* b) const { *to |= *a & *b; }
};

// Words that the number of markings surely fits.
std::size_t words_for(const Levelled& d) {
  std::vector<std::pair<double, int>> counts(d.size());  // mantissa and exponent
  counts[1] = {0.5, 1};
  for (std::size_t i = 2; i < d.size(); ++i) {
    std::pair<double, int> a = counts[d.lo[i]], b = counts[d.hi[i]];
    if (a.first == 0 || (b.first != 0 && a.second < b.second)) std::swap(a, b);
    int more = 0;
    const double sum = std::frexp(a.first + std::ldexp(b.first, std::max(b.second - a.second, -1000)), &more);
    counts[i] = {sum, a.second + more};
  }
  return std::size_t(counts[d.root].second + 1) / 64 + 1;
}

template <class Number> class Evaluation {
 public:
  Evaluation(const Levelled& diagram, const std::vector<Suffix>& suffixes, Number number, bool many, Scratch& scratch)
      : d_(diagram), suffixes_(suffixes), number_(number), words_(number.words()), none_(words_, 0), scratch_(scratch) {
    scratch_.take(d_.size() * words_ * sizeof(Word) * (many ? 2 : 1));
    plain_.assign(d_.size() * words_, 0);
    plain_[words_] = 1;
    for (std::uint32_t i = 2; i < d_.size(); ++i) {
      number_.add(&plain_[i * words_], &plain_[d_.lo[i] * words_]);
      number_.add(&plain_[i * words_], &plain_[d_.hi[i] * words_]);
    }
    if (!many) return;
    paths_.assign(d_.size() * words_, 0);
    paths_[d_.root * words_] = 1;
    for (std::uint32_t i = std::uint32_t(d_.size()); i-- > 2;)
      for (const std::uint32_t child : {d_.lo[i], d_.hi[i]}) number_.add(&paths_[child * words_], &paths_[i * words_]);
  }

  // The markings of the set that satisfy a condition.
  template <class Step> std::vector<Word> operator()(std::uint32_t condition, Step step) {
    std::vector<Word> total(words_, 0);
    if (condition == 0) return {&plain_[d_.root * words_], &plain_[(d_.root + 1) * words_]};
    const Suffix head = suffixes_[condition];
    // A condition that begins with a marked level is counted from that level's nodes on, each as often as paths lead
    // to it.
    const bool inside = !paths_.empty() && head.touch == Touch::read && !head.more;
    parts_.clear();
    gather(condition, inside ? std::int64_t(head.level) - 1 : -1);
    std::sort(parts_.begin(), parts_.end(),
              [&](const Part& a, const Part& b) { return suffixes_[a.suffix].level > suffixes_[b.suffix].level; });
    std::size_t used = 0;
    for (Part& part : parts_) {
      const Suffix literal = suffixes_[part.suffix];
      part.begin = d_.begin(literal.level);
      const std::uint32_t end = std::max(part.begin, d_.end(part.above));
      part.offset = used;
      used += (end - part.begin) * words_;
      if (values_.size() < used) {
        scratch_.take((used - values_.size()) * sizeof(Word));
        values_.resize(used);
      }
      std::fill(values_.begin() + std::ptrdiff_t(part.offset), values_.begin() + std::ptrdiff_t(used), 0);
      for (std::uint32_t i = part.begin; i < end; ++i) {
        Word* to = &values_[part.offset + (i - part.begin) * words_];
        if (i % 64 == 0) step();
        if (d_.level[i] == literal.level) {
          number_.add(to, value(literal.touch == Touch::zero ? d_.lo[i] : d_.hi[i], literal.next));
          if (literal.more) number_.add(to, value(d_.lo[i], suffixes_[literal.more].next));
        } else {
          number_.add(to, value(d_.lo[i], part.suffix));
          number_.add(to, value(d_.hi[i], part.suffix));
        }
      }
      step();
    }
    if (!inside) {
      number_.add(total.data(), value(d_.root, condition));
      return total;
    }
    const Part& top = part_of(condition);
    for (std::uint32_t i = top.begin; i < d_.end(top.above); ++i)
      number_.add_product(total.data(), &paths_[i * words_], &values_[top.offset + (i - top.begin) * words_]);
    return total;
  }

 private:
  struct Part { std::uint32_t suffix; std::int64_t above; std::uint32_t begin; std::size_t offset; };

  // What is asked behind a condition's first levels: each of its suffixes, for nodes below the level before it.
  void gather(std::uint32_t suffix, std::int64_t above) {
    if (suffix == 0) return;
    for (Part& part : parts_)
      if (part.suffix == suffix) {
        part.above = std::min(part.above, above);
        return;
      }
    parts_.push_back({suffix, above, 0, 0});
    const Suffix literal = suffixes_[suffix];
    gather(literal.next, literal.level);
    if (literal.more) gather(suffixes_[literal.more].next, literal.level);
  }

  const Part& part_of(std::uint32_t suffix) const {
    return *std::find_if(parts_.begin(), parts_.end(), [&](const Part& part) { return part.suffix == suffix; });
  }

  const Word* value(std::uint32_t node, std::uint32_t suffix) const {
    if (node == 0) return none_.data();
    while (suffix && suffixes_[suffix].level < d_.level[node]) {  // skipped: unmarked, the way that stands last
      if (suffixes_[suffix].more) suffix = suffixes_[suffix].more;
      if (suffixes_[suffix].touch != Touch::zero) return none_.data();
      suffix = suffixes_[suffix].next;
    }
    if (suffix == 0) return &plain_[node * words_];
    const Part& part = part_of(suffix);
    return &values_[part.offset + (node - part.begin) * words_];
  }

  const Levelled& d_;
  const std::vector<Suffix>& suffixes_;
  Number number_;
  std::size_t words_;
  std::vector<Word> none_, plain_, paths_, values_;
  std::vector<Part> parts_;
  Scratch& scratch_;
};

// Up to 64 conditions without alternatives at once: which of them some marking satisfies, a bit for each.
class Together {
 public:
  Together(const Levelled& diagram, Scratch& scratch) : d_(diagram), found_(diagram.size()), reads_(d_.levels + 1), zeros_(d_.levels + 1) {
    for (std::size_t span = 1; span <= d_.levels; span *= 2) any_.emplace_back(d_.levels + 1);
    scratch.take((d_.size() + (any_.size() + 2) * (d_.levels + 1)) * sizeof(Word));
  }

  template <class Step> Word operator()(const std::vector<Suffix>& suffixes, const std::uint32_t* conditions,
                                        std::size_t count, Step step) {
    std::fill(reads_.begin(), reads_.end(), 0);
    std::fill(zeros_.begin(), zeros_.end(), 0);
    for (std::size_t bit = 0; bit < count; ++bit)
      for (std::uint32_t s = conditions[bit]; s; s = suffixes[s].next)
        (suffixes[s].touch == Touch::zero ? zeros_ : reads_)[suffixes[s].level] |= Word(1) << bit;
    if (!any_.empty()) any_[0] = reads_;
    for (std::size_t k = 1, span = 1; k < any_.size(); ++k, span *= 2)
      for (std::size_t at = 0; at + 2 * span <= d_.levels; ++at) any_[k][at] = any_[k - 1][at] | any_[k - 1][at + span];
    found_[0] = 0;
    found_[1] = ~Word(0);
    for (std::uint32_t i = 2; i < d_.size(); ++i) {
      if (i % 64 == 0) step();
      const Level at = d_.level[i];
      found_[i] = (below(d_.lo[i], at + 1) & ~reads_[at]) | (below(d_.hi[i], at + 1) & ~zeros_[at]);
    }
    return below(d_.root, 0) & (count == 64 ? ~Word(0) : (Word(1) << count) - 1);
  }

 private:
  // What holds below a node whose levels from `at` on are skipped.
  Word below(std::uint32_t node, Level at) const {
    const Level to = d_.level[node];
    if (to == at || found_[node] == 0) return found_[node];
    const std::size_t k = std::size_t(std::bit_width(to - at)) - 1;
    return found_[node] & ~(any_[k][at] | any_[k][to - (Level(1) << k)]);
  }

  const Levelled& d_;
  std::vector<Word> found_, reads_, zeros_;
  std::vector<std::vector<Word>> any_;  // of reads: from each level on, so many levels together, a power of two
};

}  // namespace

std::vector<std::vector<std::uint64_t>> Store::counts(Node a, const std::vector<std::uint32_t>& conditions) {
  Scratch scratch(*this);
  const Levelled diagram(*this, a, scratch);
  std::vector<bool> marked(levels);
  for (Level at = 0; at < levels; ++at) marked[at] = diagram.marks(at);
  const auto counted = [&](auto number) {
    Evaluation evaluate(diagram, suffixes_, number, conditions.size() > 1, scratch);
    std::vector<std::vector<std::uint64_t>> results;
    results.reserve(conditions.size());
    for (const std::uint32_t condition : conditions)
      results.push_back(possible(condition, marked) ? evaluate(condition, [&] { count_step(); }) : std::vector<std::uint64_t>{});
    return results;
  };
  const std::size_t words = words_for(diagram);
  return words == 1 ? counted(Exact<1>{1}) : words == 2 ? counted(Exact<2>{2}) : counted(Exact<0>{words});
}

std::int64_t Store::first(Node a, const std::vector<std::uint32_t>& conditions) {
  constexpr std::size_t kFew = 3;  // conditions up to which each is asked alone
  if (a == 0) return -1;
  Scratch scratch(*this);
  const Levelled diagram(*this, a, scratch);
  std::vector<bool> marked(levels);
  for (Level at = 0; at < levels; ++at) marked[at] = diagram.marks(at);
  std::vector<std::uint32_t> batch;
  std::vector<std::size_t> places;  // where those of a batch stand
  std::optional<Together> together;
  std::optional<Evaluation<Some>> alone;
  const auto step = [&] { count_step(); };
  const auto holds = [&](std::uint32_t condition) {
    if (!alone) alone.emplace(diagram, suffixes_, Some{}, true, scratch);
    return alone->operator()(condition, step).front() != 0;
  };
  const auto ask = [&]() -> std::int64_t {
    if (batch.size() <= kFew) {
      for (std::size_t i = 0; i < batch.size(); ++i)
        if (holds(batch[i])) return std::int64_t(places[i]);
      return -1;
    }
    if (!together) together.emplace(diagram, scratch);
    const std::uint64_t found = (*together)(suffixes_, batch.data(), batch.size(), step);
    return found ? std::int64_t(places[std::size_t(std::countr_zero(found))]) : -1;
  };
  const auto branches = [&](std::uint32_t condition) {
    for (; condition; condition = suffixes_[condition].next)
      if (suffixes_[condition].more) return true;
    return false;
  };
  for (std::size_t i = 0; i <= conditions.size(); ++i) {
    const bool last = i == conditions.size();
    if (!last && !possible(conditions[i], marked)) continue;
    const bool apart = !last && branches(conditions[i]);
    if (last || apart || batch.size() == 64) {
      if (const std::int64_t found = ask(); found >= 0) return found;
      batch.clear(), places.clear();
    }
    if (last) break;
    if (!apart) {
      batch.push_back(conditions[i]), places.push_back(i);
    } else if (holds(conditions[i])) {
      return std::int64_t(i);
    }
  }
  return -1;
}

}  // namespace mcpn
