// Stable markings of a 1-safe net with priorities, the events between them, and the proof that each has one outcome.
#pragma once

#include <optional>
#include <vector>

#include "markings/explorer.hpp"
#include "markings/reads.hpp"
#include "markings/state_table.hpp"
#include "markings/stubborn.hpp"

namespace mcpn {

// The orders of internal transitions in which an event is run to completion: one; enough of them, which proves that all
// lead to one end; or every one, which proves it, too, and judges the former.
enum class Orders { kOne, kEnough, kEvery };

// What an event makes of every stable marking that marks some places, those that it takes from included, and leaves
// others empty, those that it puts into included: the places that it takes from and puts into, internal evolution
// included, and the others that were looked at.
struct BigStep { std::vector<std::uint32_t> taken, put, marked, empty; };

// Runs each event to completion, from stable marking to stable marking.
//
// In one order, the lowest internal transition of the first rank first: that is sound where internal evolution is confluent.
// Or in several, which proves that it is: depth first, the one stable end of each transient marking kept that is left in
// several ways. Where enough orders are tried, a marking that a transition may leave alone is left so, and not kept.
//
// The trouble at which it ends is of three kinds. "unsafe": the last firing is. "endless": it closes a circle, or it is
// one of very many where one order is followed. "parted": the last two firings are the ways that lead from the
// marking before them to two ends, and each of them to one alone.
class Settling {
 public:
  Settling(const SafeNet& net, const Stubborn::Places& initial, Orders orders, const Limits& limits,
           std::uint64_t max_transient, std::uint64_t max_firings = ~std::uint64_t(0));

  Exploration run();

  // The big step of an event, or of none, from a stable marking, or the initial one; nothing where it came to trouble.
  // Enough orders of what follows are tried for all markings that the step is of.
  std::optional<BigStep> step(const Stubborn::Places& marking, std::optional<std::uint32_t> event);

 private:
  // A marking on the way, the end of its ways, the next of them and the first transition behind them, and how many firings led to it.
  struct Step { State number, end; std::uint32_t next, ways_end; std::size_t firings; };

  bool fire(std::uint32_t t);
  std::optional<State> settled(State from, std::uint32_t event);
  std::optional<State> one_way(State from, std::uint32_t event);
  std::optional<State> all_ways(State from, std::uint32_t event);
  std::optional<State> enter(State from, std::uint32_t event);
  void forget();
  void absent(std::uint32_t end);
  void stop(State from, const char* kind);
  BigStep told(const Word* after) const;
  const Word* top() const { return ways_.data() + ways_.size() - enabled_.size(); }  // the ways of the last step

  const SafeNet& net_;
  const Stubborn::Places initial_;
  const Orders orders_;
  const Limits limits_, transient_limits_;
  std::optional<Stubborn> stubborn_;
  Exploration found_, passed_;     // stable markings; transient ones, with the end of each as its target
  StateTable stable_;
  std::optional<StateTable> transient_;
  std::optional<Reads> reads_;           // by big steps
  std::vector<Word> marking_, enabled_;  // where it is, and the internal transitions covered there
  std::vector<std::uint32_t> firings_;   // from the event on to where it is
  std::vector<Step> path_;               // the markings passed that are kept
  std::vector<Word> ways_;               // what each of them covers
  const std::uint64_t max_firings_;
  std::uint64_t fired_ = 0;
  Means means_ = Means::kOnly;           // the last that was needed behind the event
};

}  // namespace mcpn
