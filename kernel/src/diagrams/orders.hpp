// Orders of the places of a net, which are the levels of its diagrams.
#pragma once

#include <cstdint>
#include <vector>

namespace mcpn {

using Groups = std::vector<std::vector<std::uint32_t>>;

// Each starts from an order of all numbers; the groups hold those that belong together.
std::vector<std::uint32_t> force(const Groups& groups, const std::vector<std::uint32_t>& start, unsigned rounds);
std::vector<std::uint32_t> closing(const Groups& groups, const std::vector<std::uint32_t>& start);
std::vector<std::uint32_t> sloan(const Groups& groups, const std::vector<std::uint32_t>& start);
// Of the two parts of each cluster, the one that the start has further up on the average comes first.
std::vector<std::uint32_t> clustered(const Groups& groups, const std::vector<std::uint32_t>& start);

}  // namespace mcpn
