// Where transitions may fire alone, asked of all markings of a set at once.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "diagrams/store.hpp"
#include "markings/explorer.hpp"
#include "markings/stubborn.hpp"

namespace mcpn {

// What Stubborn asks of a marking, as sets: the markings from which each place is in reach if tokens are never taken are
// the least sets that hold those which mark it, and those from which a transition that puts into it is in reach.
class SetClashes {
 public:
  using Levels = std::vector<std::pair<Level, bool>>;  // by place, the level that tells of it, and whether by the reverse

  SetClashes(const SafeNet& net, const Levels& levels, Stubborn& stubborn)
      : net_(net), levels_(levels), stubborn_(stubborn), number_(net.places()), chosen_(net.transitions() / 64 + 1) {}

  // Those of some markings, which enable a transition, in which it may not fire alone.
  Node of(Store& store, Node enabled, std::uint32_t t);
  // The places that some of a set of markings mark.
  std::vector<Word> marked_in(Store& store, Node markings) const;

 private:
  using Transitions = std::vector<std::uint32_t>;

  void choose(std::uint32_t t);

  const SafeNet& net_;
  const Levels& levels_;
  Stubborn& stubborn_;
  std::vector<std::uint32_t> number_;  // by place, its number among those that matter, from 1 on; 0: it does not
  std::vector<Word> chosen_;           // transitions that matter
  Transitions asked_;                  // the same, in the order in which they were found
};

}  // namespace mcpn
