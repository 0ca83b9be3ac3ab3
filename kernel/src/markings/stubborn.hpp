// Stubborn sets of one transition: which internal transition may fire alone, so that no other order need be tried.
#pragma once

#include <optional>
#include <vector>

#include "markings/explorer.hpp"
#include "markings/reads.hpp"

namespace mcpn {

// How it is known that a transition may fire alone: no other may fire; no arcs of it conflict; units exclude those that
// do; what may fire from here on does not conflict; or it is not known, and every way is tried.
enum class Means : std::uint8_t { kOnly, kArcs, kUnits, kReach, kEvery };

// Let M be a marking whose first enabled rank is k, and F what firings of ranks up to k may come to from M if tokens are
// never taken. An enabled transition x of rank k brings about D: the members of F of ranks below k that need a token put
// by x or by one of D. Where no two transitions of F that M may lead to enable at a time are in conflict if one of them
// is x or of D, and no place that these take from may come to hold two tokens, every run from M has one that begins with
// x and has the same end (papers/mcpn.md, Proposition 3).
//
// Where D is empty, F need hold only what may fire as long as x does not: what waits for x is no rival of it.
//
// Two that need different places of a unit are never enabled at a time.
class Stubborn {
 public:
  using Places = std::vector<std::uint32_t>;

  Stubborn(const SafeNet& net, const Places& initial);

  // From now on markings are behind another event, which has led to this one.
  void begin(const Word* marking);
  // A transition that may fire alone, of those enabled in a marking, of which the first one is given.
  // Where reads are given, it notes what tells so of other markings, too.
  std::optional<std::uint32_t> alone(const Word* marking, const std::vector<Word>& enabled, std::uint32_t first, Reads* reads = nullptr);
  // Those that may fire alone wherever they are enabled.
  const std::vector<Word>& always() const { return always_; }
  // Whether one that is enabled in a marking may fire alone. If so it may in every marking that leaves some places empty,
  // too: those that are chosen, each of the places that a transition needs, of which those in reach may be marked.
  template <class Choose> bool alone_from(const Word* marking, std::uint32_t t, Choose choose) {
    const std::uint32_t end = net_.rank_end_[t];
    relax(marking, end, here_);
    std::uint32_t without = kNoBit;
    if (!judge(t, here_)) {
      if (brings_about(t)) return false;
      relax(marking, end, here_, without = t);
      if (!judge(t, here_)) return false;
    }
    note_absence(end, [&](const Places& need) { return choose(likely_empty(need, end, without), marked_); }, without);
    return true;
  }
  // Of one that may not fire alone there, as alone_from has just found: marked places for which it may not in any marking
  // that has them and enables it.
  void beside_others(const Word* marking, std::uint32_t t, Places& marked);
  // Whether two transitions take and put the same, so that it makes no difference which of them fires.
  bool alike(std::uint32_t t, std::uint32_t u) const { return does_[t] == does_[u]; }
  // Whether two places are in one unit.
  bool share_unit(std::uint32_t p, std::uint32_t q) const;
  // Why the one that was found, if any, may fire alone.
  Means means(std::optional<std::uint32_t> found, const std::vector<Word>& enabled, std::uint32_t first) const;

  // Notes the internal transitions before one of a later rank, one of them aside, that may fire from a marking on if
  // tokens are never taken.
  void relax(const Word* marking, std::uint32_t end, std::vector<Word>& may, std::uint32_t without = kNoBit);
  // Whether transitions of lower ranks may fire because one has fired.
  bool brings_about(std::uint32_t t) const;
  const std::vector<std::uint32_t>& rivals(std::uint32_t t) const { return rivals_[t]; }
  const std::vector<std::uint32_t>& crowders(std::uint32_t t) const { return crowders_[t]; }
  const std::vector<std::uint32_t>& givers(std::uint32_t place) const { return givers_[place]; }

  const std::vector<Places>& units_of() const { return units_of_; }
  std::size_t units() const { return units_; }

 private:
  enum class Known : std::uint8_t { kNot, kAlone, kBesideOthers };

  bool apart(std::uint32_t t, std::uint32_t u) const;
  Places likely_empty(const Places& need, std::uint32_t end, std::uint32_t without) const;
  bool judge(std::uint32_t t, const std::vector<Word>& may);
  bool free(std::uint32_t t, std::uint32_t end, const std::vector<Word>& may);
  template <class Choose> void note_absence(std::uint32_t end, Choose choose, std::uint32_t without);

  const SafeNet& net_;
  std::size_t units_ = 0;
  std::vector<std::vector<std::uint32_t>> units_of_;    // by place
  std::vector<Word> bounded_;                           // places of units
  std::vector<std::vector<std::uint32_t>> rivals_;      // by internal transition, those in conflict with it
  std::vector<std::vector<std::uint32_t>> crowders_;    // by internal transition, others that may put a second token
                                                        // into a place that it takes from
  std::vector<Word> always_;                            // those that may fire alone wherever they are enabled
  std::vector<Word> apart_;                             // those of them by their arcs, whatever units say
  bool told_ = false;                                   // what may fire behind the event, and who may fire alone there
  std::vector<Word> event_, behind_event_, here_;
  std::vector<Known> known_;
  std::vector<Word> marked_, brought_;                  // of relax and judge
  std::vector<std::uint32_t> queue_, giver_;            // giver_: by place that relax has marked, what marked it
  std::vector<std::vector<std::uint32_t>> givers_;      // by place, the internal transitions that put into it
  std::vector<std::uint32_t> does_;                     // by transition, the number of what it takes and puts
  std::vector<std::uint32_t> absent_;                   // those that judge looked for, and that may not fire
  std::vector<std::uint32_t> missed_;                   // those that would be brought about if they were in reach
};

// Those that judge found absent may not fire, wherever places that they need are as empty as here, and those absent that
// put into these. The others would only leave it more to judge. Nor does it matter of one that does the same as another
// one that is brought about, and that clashes with none here.
template <class Choose> void Stubborn::note_absence(std::uint32_t end, Choose choose, std::uint32_t without) {
  for (const std::uint32_t u : missed_) {
    bool twin = false;
    for (std::uint32_t v = 0; !twin && (v = next_bit(brought_.data(), brought_.size(), v)) != kNoBit; ++v)
      twin = alike(u, v);
    if (!twin || !free(u, end, here_)) absent_.push_back(u);
  }
  std::fill(brought_.begin(), brought_.end(), 0);
  for (const std::uint32_t u : absent_) set_bit(brought_.data(), u);
  while (!absent_.empty()) {
    const std::uint32_t u = absent_.back();
    absent_.pop_back();
    const std::uint32_t empty = choose(net_.firings_[u].need);
    for (const std::uint32_t t : givers_[empty])
      if (t < end && t != without && !has_bit(brought_.data(), t)) {
        set_bit(brought_.data(), t);
        absent_.push_back(t);
      }
  }
}

}  // namespace mcpn
