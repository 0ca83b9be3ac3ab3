// Zero-suppressed decision diagrams (Minato 1993): sets of markings, a marking being the set of its marked levels.
//
// A store owns nodes, their unique table and one bounded operation cache. Node 0 is the empty set, node 1 the set
// that holds the empty marking. A level that a diagram skips is unmarked in all its markings.
//
// Garbage may be collected whenever a node is made. What an operation still needs is reachable from handles, from
// the arguments of its callers, or held (class Held).
//
// A step is a result that the operation cache did not hold: the clock of budgets, and of looking for signals.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <vector>

#include "pages.hpp"
#include "wide.hpp"

namespace mcpn {

using Node = std::uint32_t;
using Level = std::uint32_t;

constexpr Node kAnything = ~Node(0);  // no diagram: the limit of a saturation that has none

struct BudgetExceeded : std::runtime_error { using std::runtime_error::runtime_error; };
struct MemoryLimit : std::runtime_error { using std::runtime_error::runtime_error; };
struct StateLimit : std::runtime_error { using std::runtime_error::runtime_error; };
struct Interrupted : std::runtime_error { Interrupted() : std::runtime_error("interrupted") {} };
struct Cancelled : std::runtime_error { Cancelled() : std::runtime_error("the operation was cancelled") {} };

enum class Touch : std::uint8_t { consume, produce, read, zero };  // 1 to 0, 0 to 1, 1 to 1, 0 to 0

// What an event does to a level, and to those below it. Suffixes that do the same are the same one. One with
// alternatives at its level (`more`, in the order of their touch, each touch once) does what any of them does.
struct Suffix {
  Level level;
  Touch touch;
  std::uint32_t next;  // 0: nothing more
  std::uint32_t more;  // 0: no other way
};

// What an event does to one level, and what it asks of it before.
struct Touched {
  Level level;
  Touch touch;
  Touch asked() const { return touch == Touch::consume ? Touch::read : touch == Touch::produce ? Touch::zero : touch; }
};

// Some events by their first level, in the order in which they were given; alternatives there stand side by side.
struct Program {
  std::vector<std::uint32_t> events, begin;  // those of a level: events[begin[level]] to events[begin[level + 1]]
  std::vector<Level> wakes;  // from each level on, the first at which an event can fire on an unmarked place
  std::uint64_t bytes() const { return (events.capacity() + begin.capacity() + wakes.capacity()) * 4; }
};

class Scratch;

class Store {
 public:
  Store(Level number, std::uint64_t memory_limit);

  Node make(Level level, Node lo, Node hi);
  Node join(Node a, Node b);
  Node meet(Node a, Node b);
  Node minus(Node a, Node b);
  Node filter(Node a, std::uint32_t literals);     // literals: a suffix of read (marked) and zero (unmarked)
  Node onto(Node a, std::uint32_t kept);           // kept: a suffix of levels; all others are forgotten
  Node without(Node a, const std::vector<std::uint32_t>& conditions);
  Node image(Node a, std::uint32_t event, Node within = kAnything);  // one firing, without closure
  Node images(Node a, const std::vector<std::uint32_t>& events, Node within = kAnything);
  Node beyond(Node a, Node from, const std::vector<std::uint32_t>& events);  // what no event makes of `from`
  bool meets(Node a, std::uint32_t literals);  // whether some marking satisfies them: makes no node
  Node singleton(const std::vector<Level>& marked);
  Node weighing(Node a, const std::vector<Wide>& weights, Wide least, Wide most);

  std::uint32_t suffix(Level level, Touch touch, std::uint32_t next, std::uint32_t more = 0);
  Level first_level(std::uint32_t suffix) const { return suffixes_[suffix].level; }
  bool is_condition(std::uint32_t suffix) const { return is_condition_[suffix]; }  // nothing but read and zero
  // An event that does what any of some ways does, of which several that fit one marking make the same of it; nothing
  // where it has too many branches.
  std::optional<std::uint32_t> choice(std::span<const std::vector<Touched>> ways, std::size_t most);
  void declare(const std::vector<std::uint32_t>& events);  // what saturate() closes under
  Node saturate(Node a, Node within = kAnything);          // firings that leave `within` do not happen

  std::vector<std::vector<std::uint64_t>> counts(Node a, const std::vector<std::uint32_t>& conditions);
  std::int64_t first(Node a, const std::vector<std::uint32_t>& conditions);  // that some marking satisfies, or -1
  Wide largest(Node a, const std::vector<Wide>& weights);  // most weight in one marking
  std::uint64_t size(Node a);
  std::vector<bool> support(Node a);  // levels that some marking marks
  bool possible(std::uint32_t suffix, const std::vector<bool>& support) const;  // no level wanted that none marks
  bool pick(Node a, std::vector<Level>& marking);
  std::vector<std::uint32_t> table(Node a);  // triples (level, lo, hi), children first; 0 and 1 are the terminals
  // Markings given as bit sets, by level; `bits` says by level which bit tells of it, -1 that it is unmarked. 64 levels
  // are a word, the first in the highest bit.
  std::vector<std::uint64_t> keys_of(const std::uint64_t* rows, std::size_t count, std::size_t words,
                                     const std::vector<std::int64_t>& bits);
  Node from_keys(const std::vector<std::uint64_t>& keys, std::size_t count);
  Node from_table(const std::vector<std::uint32_t>& rows);  // the set of the last triple, the others being parts of it

  static constexpr Level kAtATime = 64;
  std::size_t chunks() const { return (std::size_t(levels) + kAtATime - 1) / kAtATime; }

  void keep(Node a) {
    const std::lock_guard lock(kept_mutex_);
    ++kept_[a];
  }
  void drop(Node a) {
    const std::lock_guard lock(kept_mutex_);
    if (--kept_.at(a) == 0) kept_.erase(a);
  }
  void collect(std::initializer_list<Node> also = {});
  void begin(std::uint64_t most_nodes = 0, std::uint64_t most_steps = 0);  // before each operation; 0: no budget
  std::atomic<bool> stop{false};       // ends the operation under way
  std::atomic<bool> cancelled{false};  // ends this operation and every later one
  std::function<bool()> asked_to_stop;  // looked at now and then, for operations that run on the calling thread

  const Level levels;
  Level level(Node a) const { return nodes_[a].level; }
  Node lo(Node a) const { return nodes_[a].lo; }
  Node hi(Node a) const { return nodes_[a].hi; }
  std::uint64_t live() const { return used_; }  // a hint only, while an operation runs on another thread
  std::uint64_t peak() const { return peak_; }
  std::uint64_t collections() const { return collections_; }
  std::uint64_t steps() const { return steps_; }  // of the last operation
  Level closed() const { return closed_; }  // the first level of what the last saturation has closed
  std::uint64_t bytes() const;  // what the memory limit bounds

 private:
  struct Cell { Level level; Node lo, hi, next; };
  struct Cached { std::uint32_t tag = 0, x, y, z; Node result; };  // tag 0: nothing
  struct alignas(64) Line { Cached ways[3]; };                     // the last one remembered stands first
  struct Branches { Node lo, hi; };
  enum Op : std::uint32_t { op_join = 1, op_meet, op_minus, op_filter, op_onto, op_image,
    op_saturate, op_fire, op_meeting, op_images };  // from op_saturate on, results of declared lists

  void begin_walk();
  bool visit(Node n) {  // whether the walk comes to a node for the first time
    const bool first = seen_[n] != walk_;
    seen_[n] = walk_;
    return first;
  }
  template <class F> void walk(Node a, F body);
  bool meets_from(Node a, std::uint32_t literals);
  friend class Levelled;
  Branches split(Node a, Level at) const {
    return level(a) == at ? Branches{lo(a), hi(a)} : Branches{a, 0};
  }
  // Results of operations on two nodes y and z (0: none) and what else tells them apart.
  static std::uint32_t tag(Op op, Level at = 0, std::uint32_t program = 0) { return op << 28 | program << 20 | at; }
  Line& line(std::uint32_t tag, std::uint32_t x, Node y, Node z);
  bool recall(std::uint32_t tag, std::uint32_t x, Node y, Node z, Node& result);
  void remember(std::uint32_t tag, std::uint32_t x, Node y, Node z, Node result);
  void count_step() {
    if (++steps_ >= look_at_) look_up();
  }
  void look_up();
  void check();
  void make_room(Node lo, Node hi);
  void grow_table();
  void grow_cache();
  std::uint64_t overwritten_ = 0;  // cache entries lost to others since it last grew
  void require(std::uint64_t bytes) const;

  Node saturate_from(Level from, Node a, Node within);
  Node fire(std::uint32_t event, Level from, Node a, Node within);
  Node close(Level at, Node lo, Node hi, Branches within);
  Node below(Node within, Level at) const {  // the part whose levels above `at` are unmarked
    while (within != kAnything && level(within) < at) within = lo(within);
    return within;
  }
  Branches limits(Node within, Level at) const {
    return within == kAnything ? Branches{kAnything, kAnything} : split(within, at);
  }

  struct Pending { std::vector<std::uint32_t> suffixes; Level least; };  // least: the first level of any
  struct Asked { std::uint32_t sets[2]; bool met[2]; };
  std::uint32_t pending(std::vector<std::uint32_t>& suffixes);
  void begin_pending();
  Asked ask(std::uint32_t set, Level at);
  Node meeting_none(Node a, Level from, std::uint32_t set);
  Node images_from(Node a, Level from, std::uint32_t set, bool more, Node within);

  friend class Held;
  friend class Scratch;

  Table<Cell> nodes_;
  Table<Node> buckets_;
  Table<Line> cache_;
  Node free_ = 0;
  std::uint64_t used_ = 0, peak_ = 0, made_ = 0, budget_ = 0, collect_at_ = 0, collections_ = 0;
  std::uint64_t steps_ = 0, most_steps_ = 0, look_at_ = ~0ull;
  std::uint64_t scratch_ = 0;  // bytes of what operations keep beside nodes and cache
  std::uint64_t memory_limit_;
  std::mutex kept_mutex_;  // handles may die while an operation runs on another thread
  std::unordered_map<Node, std::uint32_t> kept_;
  std::vector<Node> held_;
  std::vector<std::uint32_t> seen_;  // by node, the last walk that came to it
  std::uint32_t walk_ = 0;
  std::vector<std::uint32_t> number_;  // by node that the last walk came to, its place in a levelled diagram
  std::vector<Suffix> suffixes_;
  std::unordered_map<std::uint64_t, std::uint32_t> suffix_index_;
  std::map<std::pair<std::uint64_t, std::uint32_t>, std::uint32_t> choice_index_;  // of those with alternatives
  std::vector<bool> is_condition_;  // by suffix
  std::vector<Program> programs_;
  std::map<std::vector<std::uint32_t>, std::uint32_t> program_index_;
  std::vector<Pending> pending_;
  std::map<std::vector<std::uint32_t>, std::uint32_t> pending_index_;
  std::size_t most_pending_ = 0;
  std::uint64_t program_bytes_ = 0, pending_bytes_ = 0;
  std::uint32_t program_ = 0;
  Level closed_ = 0;
};

// A node that garbage collection must leave alone while this lives.
class Held {
 public:
  Held(Store& store, Node node) : store_(store), at_(store.held_.size()) { store.held_.push_back(node); }
  ~Held() { store_.held_.pop_back(); }
  Held(const Held&) = delete;
  Held& operator=(const Held&) = delete;
  Held& operator=(Node node) {
    store_.held_[at_] = node;
    return *this;
  }
  operator Node() const { return store_.held_[at_]; }

 private:
  Store& store_;
  std::size_t at_;
};

// Memory that an operation takes for itself, inside the store's limit.
class Scratch {
 public:
  explicit Scratch(Store& store) : store_(store) {}
  ~Scratch() { store_.scratch_ -= taken_; }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  void take(std::uint64_t bytes) {
    store_.require(bytes);
    taken_ += bytes;
    store_.scratch_ += bytes;
  }

 private:
  Store& store_;
  std::uint64_t taken_ = 0;
};

// Calls a function on each node of a diagram, terminals aside, once.
template <class F> void Store::walk(Node a, F body) {
  begin_walk();
  std::vector<Node> stack{a};
  while (!stack.empty()) {
    const Node n = stack.back();
    stack.pop_back();
    if (n < 2 || !visit(n)) continue;
    body(n);
    stack.push_back(lo(n));
    stack.push_back(hi(n));
  }
}

}  // namespace mcpn
