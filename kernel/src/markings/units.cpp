// Units: sets of places that together hold one token at most, shown on the arcs.
#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "markings/explorer.hpp"

namespace mcpn {

namespace {

using Numbers = std::vector<std::uint32_t>;

constexpr std::size_t kStepsOfASeed = 4000, kStepsOfAPlace = 50;  // at most: for one place, and for all for each

// Grows a unit from a place: what puts more into the unit than it takes must take from one place more. Choices are tried
// depth first; the places that led nowhere are barred below the choice that left them.
class Growth {
 public:
  Growth(const std::vector<Firing>& firings, std::uint32_t places, const Numbers& initial)
      : firings_(firings), givers_(places), takers_(places), marked_(places), in_(places), covered_(places), barred_(places),
        excess_(firings.size()), place_in_over_(firings.size()) {
    for (std::uint32_t t = 0; t < firings.size(); ++t) {
      for (const std::uint32_t p : firings[t].put) givers_[p].push_back(t);
      for (const std::uint32_t p : firings[t].take) takers_[p].push_back(t);
    }
    for (const std::uint32_t p : initial) marked_[p] = true;
  }

  bool covered(std::uint32_t p) const { return covered_[p]; }

  // A unit with a place; empty where none is found. Counts the steps taken.
  Numbers grow(std::uint32_t seed, std::size_t most, std::size_t& steps) {
    std::vector<Choice> made;
    bool found = false;
    std::uint32_t place = seed;
    for (Numbers failed;;) {
      if (place != kNoBit) {
        add(place);
        made.push_back({place, std::move(failed)});
        failed = {};
        if (over_.empty()) {
          found = true;
          break;
        }
        if (++steps > most) break;
      } else {
        for (const std::uint32_t p : failed) barred_[p] = false;
        const std::uint32_t last = made.back().place;
        failed = std::move(made.back().failed);
        made.pop_back();
        remove(last);
        if (made.empty()) break;
        barred_[last] = true;
        failed.push_back(last);
      }
      place = choose();
    }
    Numbers unit;
    for (const Choice& choice : made) {
      if (found) covered_[choice.place] = true;
      unit.push_back(choice.place);
      for (const std::uint32_t p : choice.failed) barred_[p] = false;
    }
    for (const std::uint32_t p : unit) remove(p);
    std::fill(barred_.begin(), barred_.end(), false);
    return found ? unit : Numbers();
  }

 private:
  struct Choice { std::uint32_t place; Numbers failed; };

  // The place to go on with, for the firing in excess that leaves the least choice; kNoBit where one leaves none.
  std::uint32_t choose() const {
    std::uint32_t best = kNoBit;
    std::size_t fewest = std::numeric_limits<std::size_t>::max();
    for (const std::uint32_t t : over_) {
      std::size_t count = 0, least = std::numeric_limits<std::size_t>::max();
      std::uint32_t first = kNoBit;
      for (const std::uint32_t p : firings_[t].take) {
        if (in_[p] || barred_[p] || (marked_[p] && tokens_ > 0)) continue;
        ++count;
        const std::size_t made = worsened(p) * 2 + covered_[p];
        if (made < least) least = made, first = p;
      }
      if (count == 0) return kNoBit;
      if (count < fewest) fewest = count, best = first;
    }
    return best;
  }

  // How many firings a place would bring into excess.
  std::size_t worsened(std::uint32_t p) const {
    return std::size_t(std::count_if(givers_[p].begin(), givers_[p].end(), [&](std::uint32_t t) { return excess_[t] >= 0; }));
  }

  void add(std::uint32_t p) {
    in_[p] = true;
    tokens_ += marked_[p];
    for (const std::uint32_t t : givers_[p]) shift(t, 1);
    for (const std::uint32_t t : takers_[p]) shift(t, -1);
  }
  void remove(std::uint32_t p) {
    in_[p] = false;
    tokens_ -= marked_[p];
    for (const std::uint32_t t : givers_[p]) shift(t, -1);
    for (const std::uint32_t t : takers_[p]) shift(t, 1);
  }
  void shift(std::uint32_t t, int by) {
    const bool before = excess_[t] > 0;
    excess_[t] += by;
    if (before == (excess_[t] > 0)) return;
    if (!before) {
      place_in_over_[t] = std::uint32_t(over_.size());
      over_.push_back(t);
    } else {
      over_[place_in_over_[t]] = over_.back();
      place_in_over_[over_.back()] = place_in_over_[t];
      over_.pop_back();
    }
  }

  const std::vector<Firing>& firings_;
  std::vector<Numbers> givers_, takers_;   // by place
  std::vector<bool> marked_, in_, covered_, barred_;
  std::vector<int> excess_;                // by firing, what it puts into the unit less what it takes
  Numbers over_, place_in_over_;           // the firings in excess, and where each stands there
  int tokens_ = 0;
};

}  // namespace

// No firing leaves more tokens in a unit than it finds there, and the marking has one there at most.
std::vector<Numbers> SafeNet::units(const Numbers& initial) const {
  Growth growth(firings_, places_, initial);
  std::vector<Numbers> found;
  std::size_t left = kStepsOfASeed + kStepsOfAPlace * places_;
  for (std::uint32_t p = 0; p < places_ && left > 0; ++p) {
    if (growth.covered(p)) continue;
    std::size_t steps = 0;
    Numbers unit = growth.grow(p, std::min(left, kStepsOfASeed), steps);
    left -= std::min(left, steps);
    if (!unit.empty()) found.push_back(std::move(unit));
  }
  return found;
}

}  // namespace mcpn
