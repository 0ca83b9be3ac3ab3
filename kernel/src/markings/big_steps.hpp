// The big steps of events from a set of stable markings: as many as tell what the events make of each of them.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "diagrams/store.hpp"
#include "markings/settling.hpp"

namespace mcpn {

// Big steps are given as what they do to the levels of a store, in their order. A level says whether a place is marked;
// of partners, of which always one is marked, one has a level.
class BigSteps {
 public:
  using Way = std::vector<Touched>;
  using Places = std::vector<std::uint32_t>;

  static constexpr std::uint32_t kNoPlace = ~std::uint32_t(0);

  // Places by level, kNoPlace where it is of none; partners without a level, each with the level of the other.
  BigSteps(const SafeNet& net, const Places& initial, Places places, std::vector<std::pair<std::uint32_t, Level>> partners,
           std::uint64_t max_bytes, std::uint64_t max_transient);

  // The marked levels of the stable marking behind the initial one. Nothing here and below where it came to trouble:
  // an outcome is open, or a firing unsafe.
  std::optional<std::vector<Level>> start(Store& store);
  // The big steps of an event from a set of stable markings that enable it, so many at most, and whether these are all.
  std::optional<std::pair<std::vector<Way>, bool>> cover(Store& store, Node markings, std::uint32_t event, std::size_t most);

 private:
  Way way(const BigStep& step) const;

  const Places initial_, places_;
  const std::vector<std::pair<std::uint32_t, Level>> partners_;
  std::vector<std::pair<Level, bool>> level_of_;  // by place, and whether it says the reverse
  Store* store_ = nullptr;                        // the one that is asked for, which hears when to stop
  Settling settling_;
};

}  // namespace mcpn
