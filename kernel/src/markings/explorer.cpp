#include "markings/explorer.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#include "diagrams/store.hpp"
#include "markings/state_table.hpp"
#include "words.hpp"

namespace mcpn {

namespace {

constexpr std::size_t kBatch = 256;  // firings whose results are looked up together, and states that they are of
constexpr std::uint32_t kBatchesFromLookToLook = 64;

template <class F> void each_bit(const std::vector<Word>& bits, F body) {
  for (std::uint32_t w = 0; w < bits.size(); ++w)
    for (Word left = bits[w]; left; left &= left - 1) body(w * 64 + std::uint32_t(std::countr_zero(left)));
}

}  // namespace

std::uint64_t Exploration::bytes() const {
  return room(markings) + room(parents) + room(via) + room(offsets) + room(targets) + room(labels);
}

SafeNet::SafeNet(std::uint32_t places, std::vector<Firing> firings, bool priorities)
    : places_(places), words_(std::max(1u, (places + 63) / 64)), firings_(std::move(firings)), priorities_(priorities) {
  internal_.keyed.resize(places);
  events_.keyed.resize(places);
  rank_end_.assign(firings_.size(), std::uint32_t(firings_.size()));
  for (std::uint32_t t = std::uint32_t(firings_.size()); priorities && t-- > 1;)
    rank_end_[t - 1] = firings_[t - 1].rank == firings_[t].rank ? rank_end_[t] : t;
  std::vector<std::uint32_t> users(places, 0);
  for (const Firing& firing : firings_)
    for (const std::uint32_t p : firing.need) ++users[p];
  std::vector<std::vector<std::uint32_t>> internal_users(places);
  for (std::uint32_t t = 0; t < firings_.size(); ++t) {
    const Firing& firing = firings_[t];
    std::vector<Part> parts;
    const auto part = [&](std::uint32_t p) -> Part& {
      for (Part& known : parts)
        if (known.word == p / 64) return known;
      return parts.emplace_back(Part{p / 64, 0, 0, 0});
    };
    for (const std::uint32_t p : firing.need) part(p).need |= Word(1) << p % 64;
    for (const std::uint32_t p : firing.take) part(p).take |= Word(1) << p % 64;
    for (const std::uint32_t p : firing.put) part(p).put |= Word(1) << p % 64;
    begin_.push_back(std::uint32_t(parts_.size()));
    parts_.insert(parts_.end(), parts.begin(), parts.end());
    Level& level = priorities && firing.rank == kEvents ? events_ : internal_;
    if (firing.need.empty()) {
      level.always.push_back(t);
    } else {  // looked at only where the least wanted of its places is marked
      const auto rarest = [&](std::uint32_t p, std::uint32_t q) { return users[p] < users[q]; };
      level.keyed[*std::min_element(firing.need.begin(), firing.need.end(), rarest)].push_back(t);
    }
    if (firing.rank != kEvents)
      for (const std::uint32_t p : firing.need) internal_users[p].push_back(t);
  }
  begin_.push_back(std::uint32_t(parts_.size()));
  if (!priorities) return;
  const auto gathered = [&](const std::vector<std::uint32_t>& over) {
    std::vector<std::uint32_t> found;
    for (const std::uint32_t p : over) found.insert(found.end(), internal_users[p].begin(), internal_users[p].end());
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
  };
  for (const Firing& firing : firings_) {
    winners_.push_back(gathered(firing.put));
    losers_.push_back(gathered(firing.take));
  }
}

std::vector<Word> SafeNet::marking_of(const std::vector<std::uint32_t>& places) const {
  std::vector<Word> marking(words_, 0);
  for (const std::uint32_t p : places) marking[p / 64] |= Word(1) << p % 64;
  return marking;
}

std::uint32_t SafeNet::rank_begin(std::uint32_t t) const {
  return std::uint32_t(std::lower_bound(rank_end_.begin(), rank_end_.end(), rank_end_[t]) - rank_end_.begin());
}

bool SafeNet::fire(Word* marking, std::uint32_t t) const {
  bool safe = !firings_[t].overflow;
  for (std::uint32_t i = begin_[t]; i < begin_[t + 1]; ++i) {
    const Part& part = parts_[i];
    const Word kept = marking[part.word] & ~part.take;
    safe &= (kept & part.put) == 0;
    marking[part.word] = kept | part.put;
  }
  return safe;
}

// Notes the internal transitions that may fire, those of the first rank of which any is covered; whether there are any.
bool SafeNet::collect_internal(const Word* marking, std::vector<Word>& enabled) const {
  if (!collect(marking, internal_, enabled)) return false;
  if (!priorities_) return true;
  std::size_t first = 0;
  while (!enabled[first]) ++first;
  const std::uint32_t end = rank_end_[first * 64 + std::uint32_t(std::countr_zero(enabled[first]))];
  for (std::size_t w = end / 64; w < enabled.size(); ++w)
    enabled[w] &= w == end / 64 ? (Word(1) << end % 64) - 1 : 0;
  return true;
}

// Notes the transitions, internal ones or events, that a marking covers; whether there are any.
bool SafeNet::collect(const Word* marking, const Level& level, std::vector<Word>& enabled) const {
  bool any = false;
  const auto look = [&](std::uint32_t t) {
    if (covers(marking, t)) {
      enabled[t / 64] |= Word(1) << t % 64;
      any = true;
    }
  };
  for (const std::uint32_t t : level.always) look(t);
  for (std::uint32_t w = 0; w < words_; ++w)
    for (Word left = marking[w]; left; left &= left - 1)
      for (const std::uint32_t t : level.keyed[w * 64 + std::uint32_t(std::countr_zero(left))]) look(t);
  return any;
}

Exploration SafeNet::explore(const std::vector<std::uint32_t>& initial, bool edges, const Limits& limits) const {
  Explorer explorer(*this, initial, edges ? Edges::kAll : Edges::kNone, limits);
  explorer.run();
  return explorer.take();
}

Explorer::Explorer(const SafeNet& net, const std::vector<std::uint32_t>& initial, Edges edges, Limits limits)
    : net_(net), edges_(edges), limits_(std::move(limits)), table_(std::make_unique<StateTable>(found_, limits_)),
      enabled_(net.firings_.size() / 64 + 1) {
  found_.words = net.words_;
  begin_ = net.marking_of(initial);
  if (edges == Edges::kNone && net.places_ < 64) table_->hold_markings();  // none is all ones, as free slots are
  prepare_enabling();
}

// Where most markings hold many tokens and there are few transitions, those that are enabled are sooner known from
// each byte of a marking than by looking at each transition of which a place is marked.
void Explorer::prepare_enabling() {
  constexpr std::size_t kValues = 256, kMost = 1u << 13;  // words: more would not stay in the nearest cache
  if (net_.priorities_) return;
  const std::size_t bytes = (net_.places_ + 7) / 8, words = enabled_.size();
  std::size_t looks = net_.internal_.always.size();
  for (std::uint32_t p = 0; p < net_.places_; ++p)
    if (begin_[p / 64] >> p % 64 & 1) looks += net_.internal_.keyed[p].size();
  if (bytes == 0 || bytes * kValues * words > kMost || bytes * words > looks) return;
  enabling_.assign(bytes * kValues * words, 0);
  for (std::uint32_t t = 0; t < net_.firings_.size(); ++t)
    for (std::size_t byte = 0; byte < bytes; ++byte) {
      Word need = 0;
      for (std::uint32_t i = net_.begin_[t]; i < net_.begin_[t + 1]; ++i)
        if (net_.parts_[i].word == byte / 8) need |= net_.parts_[i].need >> byte % 8 * 8 & 255;
      for (std::size_t value = 0; value < kValues; ++value)
        if ((value & need) == need) enabling_[(byte * kValues + value) * words + t / 64] |= Word(1) << t % 64;
    }
}

bool Explorer::look_up_enabled(const Word* marking) {
  const std::size_t bytes = (net_.places_ + 7) / 8, words = enabled_.size();
  const auto row = [&](std::size_t byte) {
    return enabling_.data() + (byte * 256 + (marking[byte / 8] >> byte % 8 * 8 & 255)) * words;
  };
  std::copy_n(row(0), words, enabled_.data());
  for (std::size_t byte = 1; byte < bytes; ++byte) {
    const Word* here = row(byte);
    for (std::size_t w = 0; w < words; ++w) enabled_[w] &= here[w];
  }
  return std::any_of(enabled_.begin(), enabled_.end(), [](Word word) { return word != 0; });
}

Explorer::~Explorer() = default;

std::uint64_t Explorer::bytes() const { return table_->bytes(); }

bool Explorer::run(std::uint64_t most_firings) {
  const std::uint64_t last = most_firings ? found_.edges + most_firings : 0;
  if (found_.states() == 0) {
    if (table_->holds_markings()) table_->note(begin_[0], table_->hash(begin_.data()), 0, 0);
    else table_->number(begin_.data(), 0, 0);
    if (edges_ != Edges::kNone) found_.offsets.push_back(0);
  }
  for (std::uint32_t batches = 0; next_ < found_.states() && !found_.trouble; ++batches) {
    if (last && found_.edges >= last) return false;
    if (batches % kBatchesFromLookToLook == 0 && !limits_.go_on(found_.states(), found_.edges)) throw Interrupted();
    switch (found_.words) {
      case 1: spread<1>(); break;
      case 2: spread<2>(); break;
      case 3: spread<3>(); break;
      case 4: spread<4>(); break;
      default: spread<0>();
    }
    number();
  }
  return true;
}

// Fires what the next states enable, as many of them as fill a batch; asks the memory for where the results stand.
template <unsigned kWords> void Explorer::spread() {
  const std::size_t words = kWords ? kWords : found_.words;
  fired_.clear();
  after_.clear();
  ends_.clear();
  const State first = next_;
  while (next_ < found_.states() && fired_.size() < kBatch && next_ - first < kBatch && !found_.trouble) {
    const Word* marking = found_.markings.data() + std::uint64_t(next_) * words;
    bool internal;
    if (enabling_.empty()) {
      std::fill(enabled_.begin(), enabled_.end(), 0);
      internal = net_.collect_internal(marking, enabled_);
    } else {
      internal = look_up_enabled(marking);
    }
    const bool any = internal || (net_.priorities_ && net_.collect(marking, net_.events_, enabled_));
    found_.dead += !any;
    found_.stable += !internal;
    std::uint64_t tokens = 0;
    for (std::size_t w = 0; w < words; ++w) tokens += std::uint64_t(std::popcount(marking[w]));
    found_.most_tokens = std::max(found_.most_tokens, tokens);
    each_bit(enabled_, [&](std::uint32_t t) {
      if (found_.trouble) return;
      const std::size_t at = after_.size();
      after_.resize(at + words);
      Word* after = after_.data() + at;
      std::copy_n(marking, words, after);
      if (!net_.fire(after, t)) {
        after_.resize(at);
        found_.trouble = {next_, {t}, "unsafe"};
        return;
      }
      const std::uint64_t hashed = hash_words(after, words);
      table_->fetch_slot(hashed);
      fired_.push_back({hashed, next_, t});
    });
    ends_.push_back(found_.edges + fired_.size());
    ++next_;
  }
}

// Numbers the results of a batch, in the order of their firings.
void Explorer::number() {
  if (table_->holds_markings()) {
    const Word* after = after_.data();
    for (const Fired& fired : fired_) table_->note(*after++, fired.hashed, fired.state, fired.transition);
    found_.edges += fired_.size();
    return;
  }
  for (const Fired& fired : fired_) table_->fetch_marking(fired.hashed);
  if (edges_ != Edges::kNone) {
    try {
      table_->grow(found_.targets, fired_.size());
      table_->grow(found_.offsets, ends_.size());
      if (edges_ == Edges::kIfRoom) table_->prepare(fired_.size());
    } catch (const MemoryLimit&) {
      if (edges_ == Edges::kAll) throw;
      edges_ = Edges::kNone;
      found_.targets = {};
      found_.offsets = {};
    }
  }
  const Word* after = after_.data();
  for (const Fired& fired : fired_) {
    const State target = table_->number(after, fired.hashed, fired.state, fired.transition);
    after += found_.words;
    ++found_.edges;
    if (edges_ != Edges::kNone) found_.targets.push_back(target);
  }
  if (edges_ != Edges::kNone) found_.offsets.insert(found_.offsets.end(), ends_.begin(), ends_.end());
}

std::vector<std::uint32_t> SafeNet::labels(const Word* markings, std::size_t states) const {
  std::vector<std::uint32_t> found;
  std::vector<Word> enabled(firings_.size() / 64 + 1);
  for (std::size_t s = 0; s < states; ++s, markings += words_) {
    std::fill(enabled.begin(), enabled.end(), 0);
    if (!collect_internal(markings, enabled) && priorities_) collect(markings, events_, enabled);
    each_bit(enabled, [&](std::uint32_t t) { found.push_back(t); });
  }
  return found;
}

// Depth first: a state is done when its successors are. One that is met again on the way to itself is on a cycle.
std::int64_t stable_ends(const std::int64_t* offsets, const std::int64_t* targets, const bool* transient,
                         std::size_t states, std::int64_t* ends) {
  struct Step { std::int64_t state, edge, end; bool open; };
  std::vector<Step> path;
  std::vector<bool> seen(states);
  for (std::size_t state = 0; state < states; ++state) ends[state] = transient[state] ? -1 : std::int64_t(state);
  for (std::size_t start = 0; start < states; ++start) {
    if (!transient[start] || seen[start]) continue;
    seen[start] = true;
    path.push_back({std::int64_t(start), offsets[start], -1, false});
    while (!path.empty()) {
      Step& at = path.back();
      if (at.edge == offsets[at.state + 1]) {
        if (!at.open) ends[at.state] = at.end;
        path.pop_back();
        continue;
      }
      const std::int64_t next = targets[at.edge];
      if (transient[next] && !seen[std::size_t(next)]) {  // this edge is looked at again when its target is done
        seen[std::size_t(next)] = true;
        path.push_back({next, offsets[next], -1, false});
        continue;
      }
      ++at.edge;
      if (ends[next] < 0) {
        at.open = true;
      } else {
        if (at.end >= 0 && at.end != ends[next]) return at.state;
        at.end = ends[next];
      }
    }
  }
  return -1;
}

}  // namespace mcpn
