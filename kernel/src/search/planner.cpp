// Greedy best-first search for a marking of a goal.
#include <memory>
#include <optional>

#include "diagrams/store.hpp"
#include "search/draw.hpp"
#include "search/greedy.hpp"

namespace mcpn::search {

namespace {

class Planner {
 public:
  Planner(const TokenNet& net, const Marking& initial, const Goals& goals, std::uint32_t root, std::uint64_t draws,
          std::uint32_t bits)
      : net_(net), goals_(goals), root_(root), asks_dead_(goals.asks_dead(root)), markings_(net.places, bits),
        draw_(draws), relaxation_(net, goals), marking_(net.places) {
    fits_ = markings_.fits(initial);
    if (!fits_) return;
    net.collect(initial, enabled_);
    at_once_ = goals.holds(root, goals.sums(initial), enabled_.size());
    markings_.add(markings_.packed(initial), 0, 0);
    every_.push(0, 0, 0);
  }

  Search search(std::uint64_t max_states, std::uint64_t max_bytes, const GoOn& go_on) {
    if (!fits_) return {Outcome::tokens};
    if (at_once_) return {Outcome::reached, 1, {}};
    for (std::uint64_t taken = 1; !every_.empty() || !preferred_.empty(); ++taken) {
      if (markings_.size() > max_states) return {Outcome::states, markings_.size(), {}};
      if (markings_.bytes() + every_.bytes() + preferred_.bytes() > max_bytes)
        return {Outcome::bytes, markings_.size(), {}};
      if (const std::optional<Search> found = expand()) return *found;
      if ((taken & 0x3F) == 0) {
        if (!go_on()) throw Interrupted();
        return {Outcome::pause, markings_.size(), {}};
      }
    }
    return {Outcome::unreachable, markings_.size(), {}};
  }

 private:
  // Looks at all that follows the next marking; what it ends with, if it does.
  std::optional<Search> expand() {
    Open& open = preferred_.empty() || (!every_.empty() && every_.credit > preferred_.credit) ? every_ : preferred_;
    --open.credit;
    const std::uint32_t at = open.pop();
    expanded_.resize(markings_.size(), false);
    if (expanded_[at]) return std::nullopt;
    expanded_[at] = true;
    markings_.get(at, marking_, row_);
    net_.collect(marking_, enabled_);
    relaxation_.look(marking_, enabled_.size());
    std::vector<Tokens> sums = relaxation_.sums();
    const std::uint64_t far = relaxation_.goal(root_);
    if (far >= kNever) return std::nullopt;
    if (far < nearest_) {
      nearest_ = far;
      preferred_.credit += kBoost;
    }
    relaxation_.want_goal(root_);
    for (const Transition t : enabled_) {
      after_ = row_;
      if (!markings_.fire(after_, net_.rules[t])) return Search{Outcome::tokens, markings_.size(), {}};
      if (!markings_.add(after_, at, t)) continue;
      const auto number = std::uint32_t(markings_.size() - 1);
      std::uint64_t may_fire = 1;
      if (asks_dead_) {
        Marking there(marking_);
        for (const auto& [place, change] : net_.rules[t].change) there[place] += change;
        net_.collect(there, found_);
        may_fire = found_.size();
      }
      for (const auto& [place, change] : net_.rules[t].change)
        for (const auto& [atom, weight] : goals_.watch[place]) sums[atom] += weight * change;
      const bool holds = goals_.holds(root_, sums, may_fire);
      for (const auto& [place, change] : net_.rules[t].change)
        for (const auto& [atom, weight] : goals_.watch[place]) sums[atom] -= weight * change;
      if (holds) return Search{Outcome::reached, markings_.size(), markings_.run(number)};
      const std::uint64_t drawn = draw_.next();
      every_.push(far, drawn, number);
      if (relaxation_.wanted(t)) preferred_.push(far, drawn, number);
    }
    return std::nullopt;
  }

  const TokenNet& net_;
  const Goals& goals_;
  std::uint32_t root_;
  bool asks_dead_, fits_, at_once_ = false;
  Markings markings_;
  Draw draw_;
  Relaxation relaxation_;
  Open every_, preferred_;
  std::vector<bool> expanded_;
  Marking marking_;
  Packed::Row row_, after_;
  std::vector<Transition> enabled_, found_;
  std::uint64_t nearest_ = kNever;
};

}  // namespace

std::unique_ptr<GoalSearch> plan(const TokenNet& net, const Marking& initial, const Goals& goals, std::uint32_t root,
                                 std::uint64_t draws) {
  return std::make_unique<Widening<Planner>>([&net, initial, &goals, root, draws](std::uint32_t bits) {
    return std::make_unique<Planner>(net, initial, goals, root, draws, bits);
  });
}

}  // namespace mcpn::search
