// The markings that an exploration has found, by their words.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "diagrams/store.hpp"
#include "markings/explorer.hpp"
#include "words.hpp"

namespace mcpn {

template <class V> std::uint64_t room(const V& values) { return values.capacity() * sizeof(typename V::value_type); }

// Finds markings by their words: open addressing on the numbers of states. A slot holds half of the marking's hash
// beside the number, so that most other markings are told apart without being looked at, and none is hashed again.
// Where no number is asked for, a marking of one word stands in the slot itself.
class StateTable {
 public:
  // What it holds is named in errors; what stands beside it counts towards the same limit on memory.
  StateTable(Exploration& found, const Limits& limits, const char* what = "states", const StateTable* beside = nullptr)
      : found_(found), limits_(limits), what_(what), beside_(beside), slots_(1u << 16, kFree) {}

  std::uint64_t hash(const Word* marking) const { return hash_words(marking, found_.words); }

  // From now on markings stand in the slots: of one word, and nobody asks for their numbers.
  void hold_markings() { holds_markings_ = true; }
  bool holds_markings() const { return holds_markings_; }

  // Asks the memory for what number() will look at: first for the slot of each of some hashes, later for the marking
  // that this slot names. Tables outgrow caches, so that each look would wait otherwise.
  void fetch_slot(std::uint64_t hashed) const { __builtin_prefetch(&slots_[place(hashed)]); }
  void fetch_marking(std::uint64_t hashed) const {
    const std::uint64_t slot = slots_[place(hashed)];
    if (slot != kFree && slot >> 32 == hashed >> 32)
      __builtin_prefetch(found_.markings.data() + State(slot) * found_.words);
  }

  // The number of a marking; a new one is taken note of with where it came from.
  State number(const Word* marking, std::uint64_t hashed, State parent, std::uint32_t via) {
    const std::uint64_t words = found_.words, half = hashed >> 32 << 32;
    std::uint64_t at = place(hashed);
    for (; slots_[at] != kFree; at = (at + 1) & (slots_.size() - 1))
      if (slots_[at] >> 32 << 32 == half &&
          same(marking, found_.markings.data() + State(slots_[at]) * words, words))
        return State(slots_[at]);
    const State state = add(marking, parent, via);
    slots_[at] = half | state;
    if (found_.states() * 3 > slots_.size() * 2) widen();
    return state;
  }
  State number(const Word* marking, State parent, std::uint32_t via) {
    return number(marking, hash(marking), parent, via);
  }
  // Takes note of a marking of one word that is new, where slots hold markings.
  void note(Word marking, std::uint64_t hashed, State parent, std::uint32_t via) {
    std::uint64_t at = place(hashed);
    for (; slots_[at] != kFree; at = (at + 1) & (slots_.size() - 1))
      if (slots_[at] == marking) return;
    add(&marking, parent, via);
    slots_[at] = marking;
    if (found_.states() * 3 > slots_.size() * 2) widen();
  }
  // Makes room for so many more states, within the limit on memory.
  void prepare(std::uint64_t states) {
    grow(found_.markings, states * found_.words);
    grow(found_.parents, states);
    grow(found_.via, states);
    if ((found_.states() + states) * 3 > slots_.size() * 2) widen();
  }
  std::uint64_t bytes() const { return found_.bytes() + room(slots_); }

  // Room for more values at the end, within the limit on memory.
  template <class T> void grow(Appended<T>& values, std::uint64_t more) {
    if (values.size() + more <= values.capacity()) return;
    const std::uint64_t wider = values.capacity() / 4 + 1024 + more;
    require(wider * sizeof(T));
    values.reserve(values.capacity() + wider);
  }
  template <class V> void grow(V& values, std::uint64_t more) {
    if (values.size() + more <= values.capacity()) return;
    const std::uint64_t wanted = std::max<std::uint64_t>(values.capacity() + values.capacity() / 2, 1024) + more;
    require(wanted * sizeof(typename V::value_type));  // both copies live while a vector moves
    values.reserve(wanted);
  }

 private:
  State add(const Word* marking, State parent, std::uint32_t via) {
    const std::uint64_t words = found_.words;
    const State state = State(found_.states());
    if (state >= limits_.states)
      throw StateLimit("more than " + std::to_string(limits_.states) + " " + what_ + ": the limit on states was hit");
    if (state == ~State(0) - 1) throw StateLimit("more states than 32 bits can name");
    grow(found_.markings, words);
    grow(found_.parents, 1);
    grow(found_.via, 1);
    found_.markings.insert(found_.markings.end(), marking, marking + words);
    found_.parents.push_back(state == 0 ? 0 : parent);
    found_.via.push_back(via);
    return state;
  }
  void require(std::uint64_t more) const {
    if (bytes() + (beside_ ? beside_->bytes() : 0) + more > limits_.bytes)
      throw MemoryLimit("more than " + std::to_string(limits_.bytes) + " bytes: the limit on memory was hit at " +
                        std::to_string(found_.states()) + " " + what_);
  }
  static bool same(const Word* marking, const Word* known, std::uint64_t words) {
    for (std::uint64_t i = 0; i < words; ++i)
      if (marking[i] != known[i]) return false;
    return true;
  }
  std::uint64_t place(std::uint64_t hashed) const { return (hashed >> 32) * kSpread >> shift_; }
  void widen() {
    require(slots_.size() * 2 * sizeof(slots_[0]));
    Table<std::uint64_t> wider(slots_.size() * 2, kFree);
    --shift_;
    for (const std::uint64_t slot : slots_) {
      if (slot == kFree) continue;
      std::uint64_t at = place(holds_markings_ ? hash_words(&slot, 1) : slot);
      while (wider[at] != kFree) at = (at + 1) & (wider.size() - 1);
      wider[at] = slot;
    }
    slots_.swap(wider);
  }

  static constexpr std::uint64_t kFree = ~0ull, kSpread = 0x9E3779B97F4A7C15ull;
  Exploration& found_;
  const Limits& limits_;
  const char* what_;
  const StateTable* beside_;
  Table<std::uint64_t> slots_;
  bool holds_markings_ = false;
  int shift_ = 64 - 16;  // as many bits of a place as there are slots
};

}  // namespace mcpn
