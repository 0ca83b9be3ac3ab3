// Partial functions of markings as decision diagrams over what they do to each level, made to be composed.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "diagrams/store.hpp"

namespace mcpn {

// A function holds for each way that a level may be touched a function of the levels below. A level that it skips stays
// as it is, whatever it is. Functions that do the same to the same levels are the same one.
class Relations {
 public:
  using Id = std::uint32_t;
  using Way = std::vector<Touched>;  // in the order of the levels

  static constexpr Id kSame = 0;   // leaves every marking as it is
  static constexpr Id kNever = 1;  // of no marking

  struct Full : std::runtime_error { Full() : std::runtime_error("too many functions") {} };

  explicit Relations(std::size_t most) { clear(most); }

  void clear(std::size_t most);
  void allow(std::size_t more) { most_ = parts_.size() + more; }  // beside those that there are
  std::size_t size() const { return parts_.size(); }

  Id way(std::span<const Touched> way);
  // Leaves a marking as it is that does not have some levels, which are touched to be read, as that way asks.
  Id unless(std::span<const Touched> asked);
  // One that looks at a level: what is done where it is unmarked, and where it is marked.
  Id looks(Level level, Id unmarked, Id marked) { return make(level, {kNever, kNever, marked, unmarked}); }
  // One function and then another one.
  Id then(Id first, Id second);
  // Either of two, which make the same of a marking that both are of.
  Id either(Id one, Id other);

  // Its parts, four numbers for each way to touch a level: the level, the touch, the part that comes next (0: none), and another way
  // to touch that level (0: none). Parts are numbered from 1 on, each behind those that it names; the last is the whole.
  std::vector<std::uint32_t> table(Id of) const;
  std::uint32_t suffix(Store& store, Id of) const;  // an event of a store that does what it does
  // The whole of a table, each way to touch a level changed to another one.
  template <class Change> Id from_table(std::span<const std::uint32_t> rows, Change change) {
    std::vector<Id> made{kSame};
    for (std::size_t at = 0; at < rows.size(); at += 4) {
      std::array<Id, 4> next{kNever, kNever, kNever, kNever};
      next[std::size_t(change(Touch(rows[at + 1])))] = made[rows[at + 2]];
      const Id one = make(rows[at], next), more = rows[at + 3] ? made[rows[at + 3]] : kNever;
      made.push_back(either(one, more));
    }
    return made.back();
  }
  // Whether a table is one, of so many levels.
  static bool is_table(std::span<const std::uint32_t> rows, Level levels);

 private:
  Id make(Level level, const std::array<Id, 4>& next);
  struct Part {
    Level level;
    std::array<Id, 4> next;  // by touch
    bool operator==(const Part&) const = default;
  };
  // Numbers by pairs of numbers, of which the last one given is kept where two meet.
  class Cache {
   public:
    void clear() { entries_.assign(kLeast, {}); used_ = 0; }
    bool find(Id a, Id b, Id& result) const {
      const Entry& entry = entries_[at(a, b)];
      if (entry.a != a || entry.b != b) return false;
      result = entry.result;
      return true;
    }
    void put(Id a, Id b, Id result);

   private:
    static constexpr std::size_t kLeast = 1u << 10, kMost = 1u << 22;
    struct Entry { Id a = kNever, b = kNever, result = kNever; };  // nothing is computed of two that are of no marking
    std::size_t at(Id a, Id b) const { return mix(std::uint64_t(a) << 32 | b) & (entries_.size() - 1); }
    std::vector<Entry> entries_;
    std::size_t used_ = 0;
  };
  static std::size_t mix(std::uint64_t x) {
    x *= 0x9E3779B97F4A7C15ull;
    return std::size_t(x ^ x >> 29);
  }
  std::size_t slot(const Part& part) const;

  // What it does below a level that it may skip.
  std::array<Id, 4> at(Id of, Level level) const {
    if (of > kNever && parts_[of].level == level) return parts_[of].next;
    return {kNever, kNever, of, of};
  }

  std::size_t most_ = 0;
  std::vector<Part> parts_;
  std::vector<Id> index_;  // by hash; 0: nothing
  Cache then_, either_;
};

}  // namespace mcpn
