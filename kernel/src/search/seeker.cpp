// Best-first search with stubborn sets: A. Valmari, Stubborn sets for reduced state space generation, 1989; for
// goals: L. M. Kristensen, K. Schmidt, A. Valmari, Question-guided stubborn set methods for state properties, 2006.
#include <algorithm>
#include <memory>
#include <optional>
#include <queue>
#include <utility>

#include "diagrams/store.hpp"
#include "search/packed.hpp"

namespace mcpn::search {

namespace {

constexpr std::size_t kSeeds = 8;       // transitions tried as the first of a stubborn set
constexpr std::uint64_t kPatience = 100;  // states in a row in which none of them leaves anything out

// Sets of transitions that hold the next step of some shortest run to the goal. A run to the goal fires one of
// the `interesting` transitions. The closure takes in, for an enabled transition, all that it may disable, and
// for a disabled one, all that put tokens in one place that it lacks: then the first of the set that a run
// fires can fire first as well. No enabled transition in the set: the goal is out of reach.
class Stubborn {
 public:
  Stubborn(const TokenNet& net, const Goals& goals) : net_(net), goals_(goals), seen_(net.rules.size(), 0), raised_(net.places, 0), used_(net.places, 0) {}

  void reduce(const Marking& marking, const std::vector<Tokens>& sums, std::uint32_t root,
              std::vector<Transition>& enabled) {
    if (enabled.size() < 2) return;
    std::vector<Transition> best;
    const bool deadlock = goals_.nodes[root].kind == Goals::dead;
    // Where many seeds have been of no use for long, one is tried.
    const std::size_t seeds = deadlock && useless_ < kPatience ? std::min(kSeeds, enabled.size()) : 1;
    for (std::size_t i = 0; i < seeds; ++i) {
      close(marking, sums, root, enabled, enabled[i]);
      if (i == 0 || chosen_.size() < best.size()) best = chosen_;
      if (best.size() < 2) break;
    }
    useless_ = best.size() < enabled.size() ? 0 : useless_ + 1;
    enabled = best;
  }

 private:
  void close(const Marking& marking, const std::vector<Tokens>& sums, std::uint32_t root,
             const std::vector<Transition>& enabled, Transition seed) {
    ++stamp_;
    work_.clear();
    chosen_.clear();
    first_.clear();
    interesting(root, sums, enabled, seed, first_);
    for (const Transition t : first_) add(t);
    while (!work_.empty() && chosen_.size() < enabled.size()) {
      const Transition t = work_.back();
      work_.pop_back();
      Place lacking = kNone;
      for (const auto& [place, weight] : net_.rules[t].need)
        if (marking[place] < weight &&
            (lacking == kNone || net_.raisers[place].size() < net_.raisers[lacking].size()))
          lacking = place;
      if (lacking != kNone) {
        if (std::exchange(raised_[lacking], stamp_) != stamp_)
          for (const Transition other : net_.raisers[lacking]) add(other);
        continue;
      }
      chosen_.push_back(t);
      for (const auto& [place, change] : net_.rules[t].change)
        if (change < 0 && std::exchange(used_[place], stamp_) != stamp_)
          for (const auto& [other, weight] : net_.users[place]) add(other);
    }
    if (!work_.empty()) chosen_ = enabled;
  }
  void add(Transition t) {
    if (seen_[t] == stamp_) return;
    seen_[t] = stamp_;
    work_.push_back(t);
  }
  // Transitions of which each run from here to the goal fires one; the goal does not hold here.
  void interesting(std::uint32_t number, const std::vector<Tokens>& sums, const std::vector<Transition>& enabled,
                   Transition seed, std::vector<Transition>& found) const {
    const Goals::Node& node = goals_.nodes[number];
    switch (node.kind) {
      case Goals::at_most:
        for (const auto& [place, weight] : goals_.terms[node.atom]) {
          const auto& changers = weight > 0 ? net_.lowerers[place] : net_.raisers[place];
          found.insert(found.end(), changers.begin(), changers.end());
        }
        return;
      case Goals::dead:  // the seed must be disabled some day
        for (const auto& [place, weight] : net_.rules[seed].need)
          found.insert(found.end(), net_.lowerers[place].begin(), net_.lowerers[place].end());
        return;
      case Goals::not_dead: return;  // nothing may fire, and nothing will
      case Goals::any:
        for (const std::uint32_t inside : node.inside) interesting(inside, sums, enabled, seed, found);
        return;
      case Goals::all: {
        std::vector<Transition> least, here;
        bool first = true;
        for (const std::uint32_t inside : node.inside) {
          if (goals_.distance(inside, sums, enabled.size()) == 0) continue;
          here.clear();
          interesting(inside, sums, enabled, seed, here);
          if (first || here.size() < least.size()) least = here;
          first = false;
        }
        found.insert(found.end(), least.begin(), least.end());
        return;
      }
    }
  }

  const TokenNet& net_;
  const Goals& goals_;
  std::vector<std::uint64_t> seen_, raised_, used_;  // stamps: transitions in the set, places followed
  std::uint64_t stamp_ = 0, useless_ = 0;
  std::vector<Transition> work_, chosen_, first_;
};

class Seeker {
 public:
  Seeker(const TokenNet& net, const Marking& initial, const Goals& goals, std::uint32_t root, bool stubborn,
         std::uint32_t bits)
      : net_(net), goals_(goals), root_(root), stubborn_(stubborn), asks_dead_(goals.asks_dead(root)),
        fits_(Markings(net.places, bits).fits(initial)), markings_(net.places, bits), reduction_(net, goals),
        marking_(net.places) {
    if (!fits_) return;
    markings_.add(markings_.packed(initial), 0, 0);
    open_.emplace(0, 0);
    at_once_ = !asks_dead_ && goals.distance(root, goals.sums(initial), 1) == 0;
  }

  Search search(std::uint64_t max_states, std::uint64_t max_bytes, const GoOn& go_on) {
    if (!fits_) return {Outcome::tokens};
    if (at_once_) return {Outcome::reached, 1, {}};
    for (std::uint64_t expanded = 1; !open_.empty(); ++expanded) {
      if (markings_.size() > max_states) return {Outcome::states, markings_.size(), {}};
      if (markings_.bytes() + open_.size() * sizeof(Entry) > max_bytes) return {Outcome::bytes, markings_.size(), {}};
      if (const std::optional<Search> found = expand()) return *found;
      if ((expanded & 0x3FF) == 0) {
        if (!go_on()) throw Interrupted();
        return {Outcome::pause, markings_.size(), {}};
      }
    }
    return {Outcome::unreachable, markings_.size(), {}};
  }

 private:
  using Entry = std::pair<std::int64_t, std::uint32_t>;  // distance; the newest first among equals
  struct Later {
    bool operator()(const Entry& a, const Entry& b) const {
      return a.first != b.first ? a.first > b.first : a.second < b.second;
    }
  };

  // Looks at all that follows the nearest marking; what it ends with, if it does.
  std::optional<Search> expand() {
    const std::uint32_t at = open_.top().second;
    open_.pop();
    markings_.get(at, marking_, row_);
    net_.collect(marking_, enabled_);
    std::vector<Tokens> sums = goals_.sums(marking_);
    if (asks_dead_ && goals_.distance(root_, sums, enabled_.size()) == 0)
      return Search{Outcome::reached, markings_.size(), markings_.run(at)};
    if (stubborn_) reduction_.reduce(marking_, sums, root_, enabled_);
    for (const Transition t : enabled_) {
      after_ = row_;
      if (!markings_.fire(after_, net_.rules[t])) return Search{Outcome::tokens, markings_.size(), {}};
      if (!markings_.add(after_, at, t)) continue;
      const auto number = std::uint32_t(markings_.size() - 1);
      std::int64_t far = 0;
      if (!asks_dead_) {
        for (const auto& [place, change] : net_.rules[t].change)
          for (const auto& [atom, weight] : goals_.watch[place]) sums[atom] += weight * change;
        far = goals_.distance(root_, sums, 1);
        for (const auto& [place, change] : net_.rules[t].change)
          for (const auto& [atom, weight] : goals_.watch[place]) sums[atom] -= weight * change;
        if (far == 0) return Search{Outcome::reached, markings_.size(), markings_.run(number)};
      }
      open_.emplace(far, number);
    }
    return std::nullopt;
  }

  const TokenNet& net_;
  const Goals& goals_;
  std::uint32_t root_;
  bool stubborn_, asks_dead_, fits_, at_once_ = false;
  Markings markings_;
  std::priority_queue<Entry, std::vector<Entry>, Later> open_;
  Stubborn reduction_;
  Marking marking_;
  std::vector<std::uint64_t> row_, after_;
  std::vector<Transition> enabled_;
};

}  // namespace

std::unique_ptr<GoalSearch> seek(const TokenNet& net, const Marking& initial, const Goals& goals, std::uint32_t root,
                                 bool stubborn) {
  stubborn = stubborn && !net.priorities;
  return std::make_unique<Widening<Seeker>>([&net, initial, &goals, root, stubborn](std::uint32_t bits) {
    return std::make_unique<Seeker>(net, initial, goals, root, stubborn, bits);
  });
}

}  // namespace mcpn::search
