// The events between stable markings, told by what they change.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "markings/explorer.hpp"

namespace mcpn {

// What a transition makes of some markings, internal evolution included: the places that lose a token, those that gain
// one, and the states where it does so.
struct Change {
  std::uint32_t label;
  std::vector<std::uint32_t> lost, gained;
  std::vector<State> sources;
};

// Every edge of a listing along events, together with those of the same transition that change the same; nothing where
// there are more changes than so many.
std::optional<std::vector<Change>> changes(const Exploration& found, std::size_t most);

}  // namespace mcpn
