// Stable markings of a 1-safe net with priorities, the events between them, and the proof that each has one outcome.
#pragma once

#include <optional>
#include <vector>

#include "markings/explorer.hpp"
#include "markings/state_table.hpp"

namespace mcpn {

// Runs each event to completion, from stable marking to stable marking.
//
// Along one interleaving, the lowest internal transition of the first rank first: that is sound where internal evolution is confluent.
// Or along every one, which proves that it is: depth first, each transient marking once, its one stable end kept.
//
// The trouble at which it ends is of three kinds. "unsafe": the last firing is. "endless": it closes a circle, or it is
// one of very many where one interleaving is followed. "parted": the last two firings are the ways that lead from the
// marking before them to two ends, and each of them to one alone.
class Settling {
 public:
  Settling(const SafeNet& net, bool every, const Limits& limits, std::uint64_t max_transient);

  Exploration run(const std::vector<std::uint32_t>& initial);

 private:
  // A marking on the way, the end of its ways, the next of them, and the first transition of a later rank.
  struct Step { State number, end; std::uint32_t next, rank_end; };

  bool fire(std::uint32_t t);
  std::optional<State> settled(State from, std::uint32_t event);
  std::optional<State> one_way(State from, std::uint32_t event);
  std::optional<State> every_way(State from, std::uint32_t event);
  State enter(State from, std::uint32_t event);
  void stop(State from, const char* kind, std::vector<std::uint32_t> last);
  const Word* top() const { return ways_.data() + ways_.size() - enabled_.size(); }  // the ways of the last step

  const SafeNet& net_;
  const bool every_;
  const Limits limits_, transient_limits_;
  Exploration found_, passed_;     // stable markings; transient ones, with the end of each as its target
  StateTable stable_, transient_;
  std::vector<Word> marking_, enabled_;  // where it is, and the internal transitions covered there
  std::vector<Step> path_;
  std::vector<Word> ways_;         // what each marking on the path covers
  std::uint64_t firings_ = 0;
};

}  // namespace mcpn
