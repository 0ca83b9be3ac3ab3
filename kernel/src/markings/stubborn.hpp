// Stubborn sets of one transition: which internal transition may fire alone, so that no other order need be tried.
#pragma once

#include <optional>
#include <vector>

#include "markings/explorer.hpp"

namespace mcpn {

// Let M be a marking whose first enabled rank is k, and F what firings of ranks up to k may come to from M if tokens are
// never taken. An enabled transition x of rank k brings about D: the members of F of ranks below k that need a token put
// by x or by one of D. Where no two transitions of F that M may lead to enable at a time are in conflict if one of them
// is x or of D, and no place that these take from may come to hold two tokens, every run from M has one that begins with
// x and has the same end (papers/mcpn.md, Proposition 3).
//
// Two that need different places of a unit are never enabled at a time.
class Stubborn {
 public:
  using Places = std::vector<std::uint32_t>;

  Stubborn(const SafeNet& net, const Places& initial);

  // From now on markings are behind another event, which has led to this one.
  void begin(const Word* marking);
  // A transition that may fire alone, of those enabled in a marking, of which the first one is given.
  std::optional<std::uint32_t> alone(const Word* marking, const std::vector<Word>& enabled, std::uint32_t first);

 private:
  enum class Known : std::uint8_t { kNot, kAlone, kBesideOthers };

  bool apart(std::uint32_t t, std::uint32_t u) const;
  void relax(const Word* marking, std::uint32_t end, std::vector<Word>& may);
  bool judge(std::uint32_t t, const std::vector<Word>& may);

  const SafeNet& net_;
  std::vector<std::vector<std::uint32_t>> units_of_;    // by place
  std::vector<Word> bounded_;                           // places of units
  std::vector<std::vector<std::uint32_t>> rivals_;      // by internal transition, those in conflict with it
  std::vector<std::vector<std::uint32_t>> crowders_;    // by internal transition, those that may put a second token
                                                        // into a place that it takes from
  std::vector<Word> always_;                            // those that may fire alone wherever they are enabled
  bool told_ = false;                                   // what may fire behind the event, and who may fire alone there
  std::vector<Word> event_, behind_event_, here_;
  std::vector<Known> known_;
  std::vector<Word> marked_, brought_;                  // of relax and judge
  std::vector<std::uint32_t> queue_;
};

}  // namespace mcpn
