// Sets as rows of words, a bit for each member.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

namespace mcpn {

using Word = std::uint64_t;

constexpr std::uint32_t kNoBit = ~std::uint32_t(0);

// The first bit that is set from one on; kNoBit where there is none.
inline std::uint32_t next_bit(const Word* bits, std::size_t words, std::uint32_t from) {
  for (std::size_t w = from / 64; w < words; ++w) {
    const Word left = w == from / 64 ? bits[w] & ~Word(0) << from % 64 : bits[w];
    if (left) return std::uint32_t(w) * 64 + std::uint32_t(std::countr_zero(left));
  }
  return kNoBit;
}

inline bool has_bit(const Word* bits, std::uint32_t bit) { return bits[bit / 64] >> bit % 64 & 1; }
inline void set_bit(Word* bits, std::uint32_t bit) { bits[bit / 64] |= Word(1) << bit % 64; }

}  // namespace mcpn
