#include "diagrams/relation.hpp"

#include <algorithm>
#include <limits>
#include <unordered_map>

namespace mcpn {

namespace {

constexpr std::size_t kConsume = std::size_t(Touch::consume), kProduce = std::size_t(Touch::produce);
constexpr std::size_t kRead = std::size_t(Touch::read), kZero = std::size_t(Touch::zero);

}  // namespace

void Relations::Cache::put(Id a, Id b, Id result) {
  if (++used_ > entries_.size() && entries_.size() < kMost) {
    std::vector<Entry> before(entries_.size() * 4);
    before.swap(entries_);
    for (const Entry& entry : before)
      if (entry.a != kNever || entry.b != kNever) entries_[at(entry.a, entry.b)] = entry;
  }
  entries_[at(a, b)] = {a, b, result};
}

void Relations::clear(std::size_t most) {
  most_ = most;
  parts_.assign(2, {std::numeric_limits<Level>::max(), {kNever, kNever, kNever, kNever}});
  index_.assign(1u << 10, 0);
  then_.clear();
  either_.clear();
}

std::size_t Relations::slot(const Part& part) const {
  std::uint64_t hash = part.level;
  for (const Id id : part.next) hash = mix(hash ^ id) + 1;
  std::size_t at = hash & (index_.size() - 1);
  while (index_[at] && parts_[index_[at]] != part) at = (at + 1) & (index_.size() - 1);
  return at;
}

Relations::Id Relations::make(Level level, const std::array<Id, 4>& next) {
  if (next[kConsume] == kNever && next[kProduce] == kNever && next[kRead] == next[kZero]) return next[kRead];
  const Part part{level, next};
  const std::size_t at = slot(part);
  if (index_[at]) return index_[at];
  if (parts_.size() >= most_) throw Full();
  parts_.push_back(part);
  const Id made = index_[at] = Id(parts_.size() - 1);
  if (parts_.size() * 2 > index_.size()) {
    index_.assign(index_.size() * 4, 0);
    for (Id id = 2; id < parts_.size(); ++id) index_[slot(parts_[id])] = id;
  }
  return made;
}

Relations::Id Relations::way(std::span<const Touched> way) {
  Id made = kSame;
  for (auto at = way.rbegin(); at != way.rend(); ++at) {
    std::array<Id, 4> next{kNever, kNever, kNever, kNever};
    next[std::size_t(at->touch)] = made;
    made = make(at->level, next);
  }
  return made;
}

Relations::Id Relations::unless(std::span<const Touched> asked) {
  Id made = kNever;
  for (auto at = asked.rbegin(); at != asked.rend(); ++at) {
    std::array<Id, 4> next{kNever, kNever, kSame, kSame};
    next[std::size_t(at->asked())] = made;
    made = make(at->level, next);
  }
  return made;
}

Relations::Id Relations::then(Id first, Id second) {
  if (first == kSame || second == kNever) return second;
  if (second == kSame || first == kNever) return first;
  Id made;
  if (then_.find(first, second, made)) return made;
  const Level level = std::min(parts_[first].level, parts_[second].level);
  const std::array<Id, 4> a = at(first, level), b = at(second, level);
  const std::array<Id, 4> next{either(then(a[kConsume], b[kZero]), then(a[kRead], b[kConsume])),
                               either(then(a[kProduce], b[kRead]), then(a[kZero], b[kProduce])),
                               either(then(a[kRead], b[kRead]), then(a[kConsume], b[kProduce])),
                               either(then(a[kZero], b[kZero]), then(a[kProduce], b[kConsume]))};
  made = make(level, next);
  then_.put(first, second, made);
  return made;
}

Relations::Id Relations::either(Id one, Id other) {
  if (one == other || other == kNever) return one;
  if (one == kNever) return other;
  if (one == kSame || other == kSame) return kSame;  // what the other is of is left as it is
  if (one > other) std::swap(one, other);
  Id made;
  if (either_.find(one, other, made)) return made;
  const Level level = std::min(parts_[one].level, parts_[other].level);
  const std::array<Id, 4> a = at(one, level), b = at(other, level);
  std::array<Id, 4> next{};
  for (std::size_t touch = 0; touch < next.size(); ++touch) next[touch] = either(a[touch], b[touch]);
  made = make(level, next);
  either_.put(one, other, made);
  return made;
}

std::vector<std::uint32_t> Relations::table(Id of) const {
  std::vector<std::uint32_t> rows;
  std::unordered_map<Id, std::uint32_t> numbers{{kSame, 0}};
  std::vector<Id> stack{of};
  while (!stack.empty()) {
    const Id id = stack.back();
    if (numbers.contains(id)) {
      stack.pop_back();
      continue;
    }
    const Part& part = parts_[id];
    bool ready = true;
    for (const Id next : part.next)
      if (next != kNever && !numbers.contains(next)) {
        stack.push_back(next);
        ready = false;
      }
    if (!ready) continue;
    stack.pop_back();
    std::uint32_t more = 0;
    for (std::size_t touch = part.next.size(); touch-- > 0;) {  // as suffixes of a store have them: in their order
      if (part.next[touch] == kNever) continue;
      rows.insert(rows.end(), {part.level, std::uint32_t(touch), numbers.at(part.next[touch]), more});
      more = std::uint32_t(rows.size() / 4);
    }
    numbers.emplace(id, more);
  }
  return rows;
}

std::uint32_t Relations::suffix(Store& store, Id of) const {
  const std::vector<std::uint32_t> rows = table(of);
  std::vector<std::uint32_t> made{0};
  for (std::size_t at = 0; at < rows.size(); at += 4)
    made.push_back(store.suffix(rows[at], Touch(rows[at + 1]), made[rows[at + 2]], made[rows[at + 3]]));
  return made.back();
}

bool Relations::is_table(std::span<const std::uint32_t> rows, Level levels) {
  if (rows.size() % 4) return false;  // none: what leaves every marking as it is
  const auto level = [&](std::uint32_t number) { return rows[(std::size_t(number) - 1) * 4]; };
  for (std::uint32_t at = 1; at <= rows.size() / 4; ++at) {
    const std::uint32_t* row = &rows[(std::size_t(at) - 1) * 4];
    const std::uint32_t touch = row[1], next = row[2], more = row[3];
    if (level(at) >= levels || touch > std::uint32_t(Touch::zero) || next >= at || more >= at) return false;
    if ((next && level(next) <= level(at)) || (more && level(more) != level(at))) return false;
  }
  return true;
}

}  // namespace mcpn
