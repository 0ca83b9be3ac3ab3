// Sums of weighted tokens that 64 bits may not hold.
#pragma once

#include <cstdint>

namespace mcpn {

__extension__ typedef __int128 Wide;
__extension__ typedef unsigned __int128 WideWord;

constexpr Wide kMostWeight = Wide(1) << 105;  // of a level: the sum over all levels of a store is below kFarthest
constexpr Wide kFarthest = Wide(1) << 126;    // bounds are moved here from beyond

}  // namespace mcpn
