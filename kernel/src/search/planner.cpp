// Greedy best-first search for a marking of a goal.
#include "diagrams/store.hpp"
#include "search/draw.hpp"
#include "search/greedy.hpp"

namespace mcpn::search {

namespace {

Search plan_packed(const TokenNet& net, const Marking& initial, const Goals& goals, std::uint32_t root,
                   std::uint32_t bits, std::uint64_t max_states, std::uint64_t max_bytes, std::uint64_t draws,
                   const GoOn& go_on) {
  Markings markings(net.places, bits);
  if (!markings.fits(initial)) return {Outcome::tokens};
  Draw draw(draws);
  Relaxation relaxation(net, goals);
  Open every, preferred;
  std::vector<bool> expanded;
  Marking marking(net.places);
  Packed::Row row, after;
  std::vector<Transition> enabled, found;
  const bool asks_dead = goals.asks_dead(root);
  std::uint64_t nearest = kNever;
  std::vector<Tokens> sums = goals.sums(initial);
  net.collect(initial, enabled);
  if (goals.holds(root, sums, enabled.size())) return {Outcome::reached, 1, {}};
  markings.add(markings.packed(initial), 0, 0);
  every.push(0, 0, 0);
  for (std::uint64_t taken = 0; !every.empty() || !preferred.empty(); ++taken) {
    if ((taken & 0x3F) == 0x3F && !go_on()) throw Interrupted();
    Open& open = preferred.empty() || (!every.empty() && every.credit > preferred.credit) ? every : preferred;
    --open.credit;
    const std::uint32_t at = open.pop();
    expanded.resize(markings.size(), false);
    if (expanded[at]) continue;
    expanded[at] = true;
    markings.get(at, marking, row);
    net.collect(marking, enabled);
    relaxation.look(marking, enabled.size());
    sums = relaxation.sums();
    const std::uint64_t far = relaxation.goal(root);
    if (far >= kNever) continue;
    if (far < nearest) {
      nearest = far;
      preferred.credit += kBoost;
    }
    relaxation.want_goal(root);
    for (const Transition t : enabled) {
      after = row;
      if (!markings.fire(after, net.rules[t])) return {Outcome::tokens, markings.size(), {}};
      if (!markings.add(after, at, t)) continue;
      const auto number = std::uint32_t(markings.size() - 1);
      std::uint64_t may_fire = 1;
      if (asks_dead) {
        Marking there(marking);
        for (const auto& [place, change] : net.rules[t].change) there[place] += change;
        net.collect(there, found);
        may_fire = found.size();
      }
      for (const auto& [place, change] : net.rules[t].change)
        for (const auto& [atom, weight] : goals.watch[place]) sums[atom] += weight * change;
      const bool holds = goals.holds(root, sums, may_fire);
      for (const auto& [place, change] : net.rules[t].change)
        for (const auto& [atom, weight] : goals.watch[place]) sums[atom] -= weight * change;
      if (holds) return {Outcome::reached, markings.size(), markings.run(number)};
      const std::uint64_t drawn = draw.next();
      every.push(far, drawn, number);
      if (relaxation.wanted(t)) preferred.push(far, drawn, number);
      if (markings.size() > max_states) return {Outcome::states, markings.size(), {}};
      if (markings.bytes() + every.bytes() + preferred.bytes() > max_bytes) return {Outcome::bytes, markings.size(), {}};
    }
  }
  return {Outcome::unreachable, markings.size(), {}};
}

}  // namespace

Search plan(const TokenNet& net, const Marking& initial, const Goals& goals, std::uint32_t root,
            std::uint64_t max_states, std::uint64_t max_bytes, std::uint64_t draws, const GoOn& go_on) {
  max_states = std::min<std::uint64_t>(max_states, kNone - 1);
  Search found{Outcome::tokens};
  for (const std::uint32_t bits : kWidths) {  // wider where a place holds more than fits
    found = plan_packed(net, initial, goals, root, bits, max_states, max_bytes, draws, go_on);
    if (found.outcome != Outcome::tokens) break;
  }
  return found;
}

}  // namespace mcpn::search
