// Markings as words: their hash, the same for every table that finds them by it.
#pragma once

#include <cstdint>

namespace mcpn {

inline std::uint64_t hash_words(const std::uint64_t* marking, std::uint64_t words) {
  std::uint64_t x = 0x9E3779B97F4A7C15ull;
  for (std::uint64_t i = 0; i < words; ++i) {
    x = (x ^ marking[i]) * 0xBF58476D1CE4E5B9ull;
    x ^= x >> 29;
  }
  x *= 0x94D049BB133111EBull;
  return x ^ x >> 32;
}

}  // namespace mcpn
