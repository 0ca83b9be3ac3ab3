// Unions in one pass: the markings that meet some of many conditions, or none; those after a firing of any of many
// events. One walk over a diagram serves them all, instead of one walk for each.
//
// What is asked of a node is a set of suffixes, what is left of the conditions or events that have begun above it,
// and all of those that begin at a level or below (the declared ones, by their first level).
#include "diagrams/store.hpp"

#include <algorithm>
#include <bit>

namespace mcpn {

namespace {

constexpr std::size_t kMostPending = 1u << 15;  // sets that one operation may add

struct TooManySets {};

}  // namespace

// The number of a set of suffixes. Those of earlier operations are remembered, until they are many.
std::uint32_t Store::pending(std::vector<std::uint32_t>& suffixes) {
  std::sort(suffixes.begin(), suffixes.end());
  suffixes.erase(std::unique(suffixes.begin(), suffixes.end()), suffixes.end());
  const auto [found, added] = pending_index_.try_emplace(suffixes, std::uint32_t(pending_.size()));
  if (added) {
    if (pending_.size() >= most_pending_) {
      pending_index_.erase(found);
      throw TooManySets();
    }
    Pending set{suffixes, levels};
    for (const std::uint32_t suffix : suffixes) set.least = std::min(set.least, suffixes_[suffix].level);
    pending_bytes_ += 2 * suffixes.size() * sizeof(suffixes[0]) + 160;
    pending_.push_back(std::move(set));
    require(0);
  }
  return found->second;
}

void Store::begin_pending() {
  if (pending_.size() > kMostPending || pending_bytes_ > memory_limit_ / 16) {
    for (Line& line : cache_)
      for (Cached& entry : line.ways)
        if (entry.tag >> 28 == op_meeting || entry.tag >> 28 == op_images) entry = {};
    pending_.clear();
    pending_index_.clear();
    pending_bytes_ = 0;
  }
  most_pending_ = pending_.size() + kMostPending;
  std::vector<std::uint32_t> none;
  pending(none);
}

// What is left of a set, and of what begins at a level, for the markings without that level and for those with it.
// True in place of a set: something is met, and nothing is left to ask.
Store::Asked Store::ask(std::uint32_t set, Level at) {
  std::vector<std::uint32_t> sides[2];
  bool met[2] = {false, false};
  const auto advance = [&](std::uint32_t suffix) {
    const Suffix head = suffixes_[suffix];
    const bool side = head.touch != Touch::zero;
    sides[side].push_back(head.next);
    met[side] |= head.next == 0;
  };
  for (const std::uint32_t suffix : pending_[set].suffixes)
    if (suffixes_[suffix].level == at) {
      for (std::uint32_t way = suffix; way; way = suffixes_[way].more) advance(way);
    } else {
      sides[0].push_back(suffix);
      sides[1].push_back(suffix);
    }
  const Program& program = programs_[program_];
  for (std::uint32_t i = program.begin[at]; i < program.begin[at + 1]; ++i) advance(program.events[i]);
  Asked asked{{0, 0}, {met[0], met[1]}};
  for (const int side : {0, 1})
    if (!met[side]) asked.sets[side] = pending(sides[side]);
  return asked;
}

// The markings that meet none of what is pending and of what begins at `from` or below.
Node Store::meeting_none(Node a, Level from, std::uint32_t set) {
  if (a == 0) return 0;
  Level at;
  for (;; from = at + 1) {  // levels that the diagram skips are unmarked
    const Program& program = programs_[program_];
    at = std::min({level(a), program.wakes[from], pending_[set].least});
    if (at == level(a)) break;
    const Asked asked = ask(set, at);
    if (asked.met[0]) return 0;
    set = asked.sets[0];
  }
  if (a == 1 || (pending_[set].suffixes.empty() && programs_[program_].begin[at] == programs_[program_].events.size()))
    return a;
  Node result;
  if (recall(tag(op_meeting, at, program_), set, a, 0, result)) return result;
  const Asked asked = ask(set, at);
  const Held low(*this, asked.met[0] ? 0 : meeting_none(lo(a), at + 1, asked.sets[0]));
  const Node high = asked.met[1] ? 0 : meeting_none(hi(a), at + 1, asked.sets[1]);
  result = make(at, low, high);
  remember(tag(op_meeting, at, program_), set, a, 0, result);
  return result;
}

Node Store::without(Node a, const std::vector<std::uint32_t>& conditions) {
  const std::vector<bool> marked = support(a);
  std::vector<std::uint32_t> wanted;
  for (const std::uint32_t condition : conditions) {
    if (condition == 0) return 0;
    if (possible(condition, marked)) wanted.push_back(condition);
  }
  if (wanted.empty()) return a;
  if (wanted.size() > 1) {
    try {
      begin_pending();
      declare(wanted);
      return meeting_none(a, 0, 0);
    } catch (const TooManySets&) {  // one after the other
    }
  }
  Held left(*this, a);
  for (const std::uint32_t condition : wanted) {
    const Held met(*this, filter(left, condition));
    left = minus(left, met);
  }
  return left;
}

// The union of what is left of some events, those that begin at `from` or below among them where `more` says so.
Node Store::images_from(Node a, Level from, std::uint32_t set, bool more, Node within) {
  if (a == 0 || within == 0) return 0;
  more = more && programs_[program_].begin[from] < programs_[program_].events.size();
  const std::size_t count = pending_[set].suffixes.size();
  if (!more && count == 0) return 0;
  if (!more && count == 1 && pending_[set].suffixes[0] == 0) return within == kAnything ? a : meet(a, within);
  if (!more && count == 1) return image(a, pending_[set].suffixes[0], within);
  const Level at = std::min({level(a), more ? programs_[program_].wakes[from] : levels, pending_[set].least});
  if (at == levels) {  // nothing but the empty marking, which every event that is left leaves alone
    return count && pending_[set].suffixes[0] == 0 ? (within == kAnything ? a : meet(a, within)) : 0;
  }
  within = below(within, at);
  const std::uint32_t key = tag(op_images, more ? at : 0, more ? program_ : 0);
  Node result;
  if (recall(key, set << 1 | more, a, within, result)) return result;
  std::vector<std::uint32_t> stay, after[4];
  for (const std::uint32_t suffix : pending_[set].suffixes)
    if (suffix && suffixes_[suffix].level == at)
      for (std::uint32_t way = suffix; way; way = suffixes_[way].more)
        after[int(suffixes_[way].touch)].push_back(suffixes_[way].next);
    else
      stay.push_back(suffix);
  if (more) {
    const Program& program = programs_[program_];
    for (std::uint32_t i = program.begin[at]; i < program.begin[at + 1]; ++i) {
      const Suffix head = suffixes_[program.events[i]];
      after[int(head.touch)].push_back(head.next);
    }
  }
  const Branches x = split(a, at), w = limits(within, at);
  const auto side = [&](bool marked) {
    const Touch still = marked ? Touch::read : Touch::zero, moved = marked ? Touch::produce : Touch::consume;
    std::vector<std::uint32_t> both = stay;
    both.insert(both.end(), after[int(still)].begin(), after[int(still)].end());
    const std::uint32_t kept = pending(both), moving = pending(after[int(moved)]);
    const Node inside = marked ? w.hi : w.lo;
    const Held same(*this, images_from(marked ? x.hi : x.lo, at + 1, kept, more, inside));
    const Held other(*this, images_from(marked ? x.lo : x.hi, at + 1, moving, false, inside));
    return join(same, other);
  };
  const Held low(*this, side(false));
  const Node high = side(true);
  result = make(at, low, high);
  remember(key, set << 1 | more, a, within, result);
  return result;
}

Node Store::images(Node a, const std::vector<std::uint32_t>& events, Node within) {
  const std::vector<bool> marked = support(a);
  std::vector<std::uint32_t> wanted;
  bool nothing = false;  // an event that does nothing
  for (const std::uint32_t event : events) {
    nothing |= event == 0;
    if (event && possible(event, marked)) wanted.push_back(event);
  }
  Held all(*this, nothing ? (within == kAnything ? a : meet(a, within)) : 0);
  if (wanted.size() > 1) {
    try {
      begin_pending();
      declare(wanted);
      const Held made(*this, images_from(a, 0, 0, true, within));
      return join(all, made);
    } catch (const TooManySets&) {  // one after the other
    }
  }
  for (const std::uint32_t event : wanted) {
    const Held after(*this, image(a, event, within));
    all = join(all, after);
  }
  return all;
}

Node Store::beyond(Node a, Node from, const std::vector<std::uint32_t>& events) {
  const Held made(*this, images(from, events, a));
  return minus(a, made);
}

std::vector<std::uint64_t> Store::keys_of(const std::uint64_t* rows, std::size_t count, std::size_t words,
                                          const std::vector<std::int64_t>& bits) {
  const std::size_t each = chunks();
  Scratch scratch(*this);
  scratch.take(count * each * sizeof(std::uint64_t));
  std::vector<std::uint64_t> keys(count * each);
  for (std::size_t row = 0; row < count; ++row) {
    count_step();
    for (Level at = 0; at < levels; ++at)
      if (bits[at] >= 0 && rows[row * words + std::size_t(bits[at]) / 64] >> bits[at] % 64 & 1)
        keys[row * each + at / kAtATime] |= std::uint64_t(1) << (kAtATime - 1 - at % kAtATime);
  }
  return keys;
}

// Rows are sorted by their next 64 levels at a time. Then those that share a node stand together, and where the first
// and the last of them differ first, the node branches.
Node Store::from_keys(const std::vector<std::uint64_t>& keys, std::size_t count) {
  struct Row { std::uint64_t key; std::uint32_t row; };
  const std::size_t each = chunks();
  Scratch scratch(*this);
  scratch.take(count * sizeof(Row));
  std::vector<Row> sorted(count);
  for (std::size_t i = 0; i < count; ++i) sorted[i].row = std::uint32_t(i);
  const auto sort = [&](Row* first, Row* last, Level from) {
    for (Row* at = first; at != last; ++at) {
      count_step();
      at->key = keys[at->row * each + from / kAtATime];
    }
    if (last - first > 1)
      std::sort(first, last, [](const Row& one, const Row& other) { return one.key < other.key; });
  };
  // Levels from `from` on of rows that are sorted by them, all alike in the bits above `left`.
  auto build = [&](auto&& self, Row* first, Row* last, Level from, unsigned left) -> Node {
    count_step();
    const std::uint64_t below = left == kAtATime ? ~std::uint64_t(0) : (std::uint64_t(1) << left) - 1;
    const std::uint64_t differs = (first->key ^ last[-1].key) & below;
    std::uint64_t shared = first->key & below;
    Node node;
    if (differs) {
      const auto bit = unsigned(std::bit_width(differs)) - 1;
      shared = shared >> bit >> 1 << bit << 1;
      Row* middle = std::partition_point(first, last, [&](const Row& row) { return !(row.key >> bit & 1); });
      const Held low(*this, self(self, first, middle, from, bit));
      node = make(from + kAtATime - 1 - bit, low, self(self, middle, last, from, bit));
    } else if (levels - from > kAtATime) {
      sort(first, last, from + kAtATime);
      node = self(self, first, last, from + kAtATime, kAtATime);
    } else {
      node = 1;
    }
    for (; shared; shared &= shared - 1) node = make(from + kAtATime - 1 - Level(std::countr_zero(shared)), 0, node);
    return node;
  };
  if (count == 0) return 0;
  if (levels == 0) return 1;
  sort(sorted.data(), sorted.data() + sorted.size(), 0);
  return build(build, sorted.data(), sorted.data() + sorted.size(), 0, kAtATime);
}

}  // namespace mcpn
