#include "search/tokens.hpp"

#include <algorithm>
#include <cstdlib>
#include <stdexcept>

namespace mcpn::search {

namespace {

constexpr std::uint16_t kLast = 0xFFFF;

}  // namespace

TokenNet::TokenNet(std::uint32_t count, std::vector<Rule> given, bool with_priorities)
    : places(count), rules(std::move(given)), priorities(with_priorities), order(rules.size()), users(count), raisers(count),
      lowerers(count), keyed_(count) {
  std::vector<std::uint16_t> known;
  if (priorities)
    for (const Rule& rule : rules) known.push_back(rule.rank);
  std::sort(known.begin(), known.end());
  known.erase(std::unique(known.begin(), known.end()), known.end());
  ranks = std::max<std::size_t>(known.size(), 1);
  for (Transition t = 0; t < rules.size() && priorities; ++t)
    order[t] = std::uint16_t(std::lower_bound(known.begin(), known.end(), rules[t].rank) - known.begin());
  for (Transition t = 0; t < rules.size(); ++t) {
    for (const auto& [place, weight] : rules[t].need) users[place].emplace_back(t, weight);
    for (const auto& [place, change] : rules[t].change) (change > 0 ? raisers : lowerers)[place].push_back(t);
  }
  for (Transition t = 0; t < rules.size(); ++t) {
    const auto& need = rules[t].need;
    if (need.empty()) {
      always_.push_back(t);
      continue;
    }
    const auto rarest = std::min_element(need.begin(), need.end(), [&](const Arc& a, const Arc& b) {
      return users[a.first].size() < users[b.first].size();
    });
    keyed_[rarest->first].push_back(t);
  }
}

void TokenNet::collect(const Marking& marking, std::vector<Transition>& found) const {
  found = always_;
  for (Place p = 0; p < places; ++p)
    if (marking[p] > 0)
      for (const Transition t : keyed_[p])
        if (enabled(marking, t)) found.push_back(t);
  std::sort(found.begin(), found.end());
  if (!priorities) return;
  std::uint16_t least = kLast;
  for (const Transition t : found) least = std::min(least, order[t]);
  std::erase_if(found, [&](Transition t) { return order[t] != least; });
}

std::uint32_t Goals::add(Kind kind, std::vector<std::uint32_t> inside, std::vector<Arc> weights, Tokens bound) {
  const auto atom = std::uint32_t(bounds.size());
  if (kind == at_most) {
    Tokens heaviest = 0;
    for (const auto& [place, weight] : weights) {
      if (weight > kMostWeights || weight < -kMostWeights || (heaviest += std::abs(weight)) > kMostWeights)
        throw std::invalid_argument("weights beyond what search follows");
    }
    for (const auto& [place, weight] : weights) watch[place].emplace_back(atom, weight);
    bounds.push_back(std::clamp(bound, -kFarBound, kFarBound));
    terms.push_back(std::move(weights));
  }
  nodes.push_back({kind, atom, std::move(inside)});
  return std::uint32_t(nodes.size() - 1);
}

Tokens Goals::distance(std::uint32_t number, const std::vector<Tokens>& sums, std::uint64_t enabled) const {
  const Node& node = nodes[number];
  switch (node.kind) {
    case at_most: return std::clamp<Tokens>(sums[node.atom] - bounds[node.atom], 0, kFar);
    case dead: return std::min<Tokens>(Tokens(enabled), kFar);
    case not_dead: return enabled == 0;
    case all: {
      Tokens total = 0;
      for (const std::uint32_t inside : node.inside) total += distance(inside, sums, enabled);
      return std::min(total, kFar);
    }
    case any: {
      Tokens least = kFar;
      for (const std::uint32_t inside : node.inside) {
        least = std::min(least, distance(inside, sums, enabled));
        if (least == 0) break;
      }
      return least;
    }
  }
  return kFar;
}

bool Goals::holds(std::uint32_t number, const std::vector<Tokens>& sums, std::uint64_t enabled) const {
  const Node& node = nodes[number];
  const auto inside = [&](std::uint32_t n) { return holds(n, sums, enabled); };
  switch (node.kind) {
    case at_most: return sums[node.atom] <= bounds[node.atom];
    case dead: return enabled == 0;
    case not_dead: return enabled != 0;
    case all: return std::all_of(node.inside.begin(), node.inside.end(), inside);
    case any: return std::any_of(node.inside.begin(), node.inside.end(), inside);
  }
  return false;
}

void Goals::atoms(std::uint32_t number, std::vector<std::uint32_t>& found) const {
  const Node& node = nodes[number];
  if (node.kind == at_most) found.push_back(node.atom);
  for (const std::uint32_t inside : node.inside) atoms(inside, found);
}

std::vector<Tokens> Goals::sums(const Marking& marking) const {
  std::vector<Tokens> found(bounds.size(), 0);
  for (std::size_t atom = 0; atom < found.size(); ++atom)
    for (const auto& [place, weight] : terms[atom]) found[atom] += weight * marking[place];
  return found;
}

bool Goals::asks_dead(std::uint32_t number) const {
  const Node& node = nodes[number];
  return node.kind == dead || node.kind == not_dead ||
         std::any_of(node.inside.begin(), node.inside.end(), [&](std::uint32_t n) { return asks_dead(n); });
}

}  // namespace mcpn::search
