#include "markings/changes.hpp"

#include <string>
#include <unordered_map>

#include "markings/bits.hpp"

namespace mcpn {

namespace {

std::vector<std::uint32_t> members(const Word* bits, std::size_t words) {
  std::vector<std::uint32_t> found;
  for (std::uint32_t bit = 0; (bit = next_bit(bits, words, bit)) != kNoBit; ++bit) found.push_back(bit);
  return found;
}

}  // namespace

std::optional<std::vector<Change>> changes(const Exploration& found, std::size_t most) {
  const std::size_t words = found.words;
  std::vector<Word> key(1 + 2 * words);  // the transition, what is lost, what is gained
  std::unordered_map<std::string, std::size_t> numbers;
  std::vector<Change> told;
  for (State source = 0; source < found.states(); ++source) {
    const Word* before = found.markings.data() + std::uint64_t(source) * words;
    for (std::uint64_t edge = found.offsets[source]; edge < found.offsets[source + 1]; ++edge) {
      const Word* after = found.markings.data() + std::uint64_t(found.targets[edge]) * words;
      key[0] = found.labels[edge];
      for (std::size_t w = 0; w < words; ++w) {
        key[1 + w] = before[w] & ~after[w];
        key[1 + words + w] = after[w] & ~before[w];
      }
      const auto [at, fresh] = numbers.try_emplace(
          std::string(reinterpret_cast<const char*>(key.data()), key.size() * sizeof(Word)), told.size());
      if (fresh) {
        if (told.size() == most) return std::nullopt;
        told.push_back({found.labels[edge], members(key.data() + 1, words), members(key.data() + 1 + words, words), {}});
      }
      told[at->second].sources.push_back(source);
    }
  }
  return told;
}

}  // namespace mcpn
