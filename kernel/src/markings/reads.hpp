// The places that tell how internal evolution goes on behind an event, of those that were as they are before it.
#pragma once

#include <vector>

#include "markings/bits.hpp"
#include "markings/explorer.hpp"

namespace mcpn {

// In a stable marking no internal transition is enabled, so that only those need be looked at that have won a token
// behind the event. One that fires tells that its places are marked. One that is not enabled tells that any one of its
// places is empty, of which one is taken that is known to be, where there is one; and it need not tell before that
// matters, when it would have come first, or when nothing is enabled any more: it may have lost its token by then.
class Reads {
 public:
  using Places = std::vector<std::uint32_t>;

  // Units: sets of places that together hold one token at most.
  Reads(std::uint32_t words, const std::vector<Places>& units_of_place, std::size_t units, std::size_t transitions)
      : units_of_(units_of_place), read_(words), held_(units / 64 + 1), won_(transitions / 64 + 1), waiting_(won_) {}

  // From now on it is behind another event; `before` is the stable marking there.
  void begin(const std::vector<Word>& before) {
    before_ = before;
    std::fill(read_.begin(), read_.end(), 0);
    std::fill(held_.begin(), held_.end(), 0);
    std::fill(won_.begin(), won_.end(), 0);
    std::fill(waiting_.begin(), waiting_.end(), 0);
  }
  // A transition has won a token, and is not enabled.
  void wait(std::uint32_t t) {
    set_bit(won_.data(), t);
    set_bit(waiting_.data(), t);
  }
  // It goes on from a marking that it came to before.
  void go_back() { waiting_ = won_; }
  // Notes why those that wait, up to one transition and but for some, are not enabled in a marking; they need not wait
  // any longer.
  template <class F> void tell_absent(std::uint32_t end, const SafeNet& net, const Word* marking, F but) {
    for (std::uint32_t t = 0; (t = next_bit(waiting_.data(), waiting_.size(), t)) < end; ++t) {
      if (but(t)) continue;
      waiting_[t / 64] &= ~(Word(1) << t % 64);
      if (!net.covers(marking, t)) missing(net.firings_[t].need, marking);
    }
  }
  void read(const Places& places) {
    for (const std::uint32_t p : places) read(p);
  }
  // Notes why some places are not all marked in a marking: which of them it is that is empty.
  std::uint32_t missing(const Places& places, const Word* marking) {
    std::uint32_t any = kNoBit;
    for (const std::uint32_t p : places) {
      if (has_bit(marking, p)) continue;
      if (has_bit(read_.data(), p) || elsewhere(p)) return p;
      any = p;
    }
    read(any);
    return any;
  }
  const std::vector<Word>& places() const { return read_; }
  const std::vector<Word>& before() const { return before_; }

 private:
  void read(std::uint32_t p) {
    set_bit(read_.data(), p);
    if (has_bit(before_.data(), p))
      for (const std::uint32_t unit : units_of_[p]) set_bit(held_.data(), unit);
  }
  // Whether another place, which is known to be marked, holds the token of one of its units.
  bool elsewhere(std::uint32_t p) const {
    if (has_bit(before_.data(), p)) return false;
    for (const std::uint32_t unit : units_of_[p])
      if (has_bit(held_.data(), unit)) return true;
    return false;
  }

  const std::vector<Places>& units_of_;
  std::vector<Word> before_, read_, held_;  // held_: units whose token is at a place that was read
  std::vector<Word> won_, waiting_;         // transitions that have won a token, and that may not be enabled now
};

}  // namespace mcpn
