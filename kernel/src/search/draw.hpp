// Numbers drawn for walks and searches.
#pragma once

#include <cstdint>

namespace mcpn::search {

// xorshift64*: Vigna, An experimental exploration of Marsaglia's xorshift generators, 2016.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : state_(seed * 0x9E3779B97F4A7C15ull + 0x2545F4914F6CDD1Dull) {}
  std::uint64_t next() {
    state_ ^= state_ >> 12;
    state_ ^= state_ << 25;
    state_ ^= state_ >> 27;
    return state_ * 0x2545F4914F6CDD1Dull;
  }
  std::uint32_t below(std::uint64_t count) { return std::uint32_t((next() >> 32) * count >> 32); }

 private:
  std::uint64_t state_;
};

}  // namespace mcpn::search
