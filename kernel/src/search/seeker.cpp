// Best-first search with stubborn sets: A. Valmari, Stubborn sets for reduced state space generation, 1989; for
// goals: L. M. Kristensen, K. Schmidt, A. Valmari, Question-guided stubborn set methods for state properties, 2006.
#include <algorithm>
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

Search seek_packed(const TokenNet& net, const Marking& initial, const Goals& goals, std::uint32_t root,
                   bool stubborn, std::uint32_t bits, std::uint64_t max_states, std::uint64_t max_bytes,
                   const GoOn& go_on) {
  Markings markings(net.places, bits);
  if (!markings.fits(initial)) return {Outcome::tokens};
  using Entry = std::pair<std::int64_t, std::uint32_t>;  // distance; the newest first among equals
  std::priority_queue<Entry, std::vector<Entry>, decltype([](const Entry& a, const Entry& b) {
                        return a.first != b.first ? a.first > b.first : a.second < b.second;
                      })> open;
  const bool asks_dead = goals.asks_dead(root);
  Stubborn reduction(net, goals);
  Marking marking(net.places);
  std::vector<std::uint64_t> row, after;
  std::vector<Transition> enabled;
  std::vector<Tokens> sums = goals.sums(initial);
  markings.add(markings.packed(initial), 0, 0);
  open.emplace(0, 0);
  if (!asks_dead && goals.distance(root, sums, 1) == 0) return {Outcome::reached, 1, {}};
  for (std::uint64_t expanded = 0; !open.empty(); ++expanded) {
    const std::uint32_t at = open.top().second;
    open.pop();
    markings.get(at, marking, row);
    net.collect(marking, enabled);
    sums = goals.sums(marking);
    if (asks_dead && goals.distance(root, sums, enabled.size()) == 0)
      return {Outcome::reached, markings.size(), markings.run(at)};
    if (stubborn) reduction.reduce(marking, sums, root, enabled);
    for (const Transition t : enabled) {
      after = row;
      if (!markings.fire(after, net.rules[t])) return {Outcome::tokens, markings.size(), {}};
      if (markings.add(after, at, t)) {
        const auto number = std::uint32_t(markings.size() - 1);
        std::int64_t far = 0;
        if (!asks_dead) {
          for (const auto& [place, change] : net.rules[t].change)
            for (const auto& [atom, weight] : goals.watch[place]) sums[atom] += weight * change;
          far = goals.distance(root, sums, 1);
          for (const auto& [place, change] : net.rules[t].change)
            for (const auto& [atom, weight] : goals.watch[place]) sums[atom] -= weight * change;
          if (far == 0) return {Outcome::reached, markings.size(), markings.run(number)};
        }
        open.emplace(far, number);
        if (markings.size() > max_states) return {Outcome::states, markings.size(), {}};
        if (markings.bytes() + open.size() * sizeof(Entry) > max_bytes) return {Outcome::bytes, markings.size(), {}};
      }
    }
    if ((expanded & 0x3FF) == 0x3FF && !go_on()) throw Interrupted();
  }
  return {Outcome::unreachable, markings.size(), {}};
}

}  // namespace

Search seek(const TokenNet& net, const Marking& initial, const Goals& goals, std::uint32_t root, bool stubborn,
            std::uint64_t max_states, std::uint64_t max_bytes, const GoOn& go_on) {
  max_states = std::min<std::uint64_t>(max_states, kNone - 1);
  Search found{Outcome::tokens};
  for (const std::uint32_t bits : kWidths) {  // wider where a place holds more than fits
    found = seek_packed(net, initial, goals, root, stubborn && !net.priorities, bits, max_states, max_bytes, go_on);
    if (found.outcome != Outcome::tokens) break;
  }
  return found;
}

}  // namespace mcpn::search
