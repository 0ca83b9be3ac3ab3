// Zero-suppressed decision diagrams (Minato 1993): sets of markings, a marking being the set of its marked levels.
//
// A store owns nodes, their unique table and one bounded operation cache. Node 0 is the empty set, node 1 the set
// that holds the empty marking. A level that a diagram skips is unmarked in all its markings.
#pragma once

#include <atomic>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <vector>

namespace mcpn {

using Node = std::uint32_t;
using Level = std::uint32_t;

struct BudgetExceeded : std::runtime_error { using std::runtime_error::runtime_error; };
struct MemoryLimit : std::runtime_error { using std::runtime_error::runtime_error; };
struct Interrupted : std::runtime_error { Interrupted() : std::runtime_error("interrupted") {} };

enum class Touch : std::uint8_t { consume, produce, read, zero };  // 1 to 0, 0 to 1, 1 to 1, 0 to 0

// What an event does to a level, and to those below it. Suffixes that do the same are the same one.
struct Suffix {
  Level level;
  Touch touch;
  std::uint32_t next;  // 0: nothing more
};

class Store {
 public:
  Store(Level levels, std::uint64_t memory_limit);

  // --- sets ---
  Node make(Level level, Node lo, Node hi);
  Node join(Node a, Node b);
  Node meet(Node a, Node b);
  Node minus(Node a, Node b);
  Node filter(Node a, std::uint32_t literals);     // literals: a suffix of read (marked) and zero (unmarked)
  Node image(Node a, std::uint32_t event);         // one firing, without closure
  Node singleton(const std::vector<Level>& marked);

  // --- events ---
  std::uint32_t suffix(Level level, Touch touch, std::uint32_t next);
  void declare(const std::vector<std::uint32_t>& events);  // what saturate() closes under
  Node saturate(Node a);

  // --- counting: exact, numbers as little-endian limbs ---
  std::vector<std::vector<std::uint64_t>> counts(Node a, const std::vector<std::uint32_t>& conditions);
  bool holds(Node a, std::uint32_t literals);  // whether some marking satisfies them
  std::int64_t largest(Node a, const std::vector<std::int32_t>& weights);  // most weight in one marking
  std::uint64_t size(Node a);
  bool pick(Node a, std::vector<Level>& marking);

  // --- life ---
  void keep(Node a) { ++kept_[a]; }
  void drop(Node a) { if (--kept_.at(a) == 0) kept_.erase(a); }
  void collect();
  void begin(std::uint64_t budget);  // before each operation: budgets, garbage, the stop flag
  std::atomic<bool> stop{false};
  bool (*asked_to_stop)() = nullptr;  // looked at now and then, for operations that run on the calling thread

  const Level levels;
  Level level(Node a) const { return nodes_[a].level; }
  Node lo(Node a) const { return nodes_[a].lo; }
  Node hi(Node a) const { return nodes_[a].hi; }
  std::uint64_t live() const { return used_; }
  std::uint64_t peak() const { return peak_; }
  std::uint64_t collections() const { return collections_; }
  std::uint64_t bytes() const;

 private:
  struct Cell { Level level; Node lo, hi, next; };
  struct Cached { std::uint64_t a = ~0ull, b = 0; Node result = 0; };
  struct Branches { Node lo, hi; };
  enum Op : std::uint64_t { op_join = 1, op_meet, op_minus, op_filter, op_image, op_saturate, op_fire };

  Branches split(Node a, Level at) const {
    return level(a) == at ? Branches{lo(a), hi(a)} : Branches{a, 0};
  }
  bool recall(Op op, std::uint32_t x, std::uint32_t y, std::uint32_t z, Node& result);
  void remember(Op op, std::uint32_t x, std::uint32_t y, std::uint32_t z, Node result);
  void check();
  void grow_table();
  void grow_cache();
  std::uint64_t overwritten_ = 0;  // cache entries lost to others since it last grew
  void require(std::uint64_t bytes);

  // --- saturation ---
  Node saturate_from(Level from, Node a);
  Node fire(std::uint32_t event, Level from, Node a);
  Node close(Level at, Node lo, Node hi);

  std::vector<Cell> nodes_;
  std::vector<Node> buckets_;
  std::vector<Cached> cache_;
  Node free_ = 0;
  std::uint64_t used_ = 0, peak_ = 0, budget_ = 0, budget_end_ = 0, collect_at_ = 0, collections_ = 0, steps_ = 0;
  std::uint64_t memory_limit_;
  std::unordered_map<Node, std::uint32_t> kept_;
  std::vector<Suffix> suffixes_;
  std::unordered_map<std::uint64_t, std::uint32_t> suffix_index_;
  std::vector<std::vector<std::uint32_t>> tops_;  // declared events by their first level
  std::vector<Level> wakes_;  // from each level on, the first at which an event can fire on an unmarked place
};

}  // namespace mcpn
