// Greedy best-first search by the additive heuristic of planning: what goals cost, and the queues.
//
// The heuristic ignores what firings take (delete relaxation): a token costs as much as the cheapest transition that
// puts it there, which costs one firing and what it needs. B. Bonet, H. Geffner, Planning as heuristic search,
// Artificial Intelligence 129, 2001. A marking is evaluated when it is taken out of the queue, and those that firings
// of the relaxed run lead to have a queue of their own: M. Helmert, The Fast Downward planning system, JAIR 26, 2006.
#pragma once

#include <algorithm>
#include <queue>
#include <utility>
#include <vector>

#include "search/packed.hpp"

namespace mcpn::search {

constexpr std::uint64_t kNever = std::uint64_t(1) << 40;  // the cost of what no firings bring about
constexpr int kBoost = 1000;  // how much longer the queue of preferred markings is favoured after a step nearer

inline std::uint64_t at_most_never(std::uint64_t cost) { return std::min(cost, kNever); }
inline std::uint64_t times(std::uint64_t cost, Tokens count) {
  return cost >= kNever || std::uint64_t(count) >= kNever / std::max<std::uint64_t>(cost, 1) ? kNever : cost * std::uint64_t(count);
}

// Costs of transitions, of tokens and of goals from one marking on.
class Relaxation {
 public:
  Relaxation(const TokenNet& net, const Goals& goals)
      : net_(net), goals_(goals), helpers_(goals.bounds.size()), missing_(net.rules.size()), lacking_(net.rules.size()),
        cost_(net.rules.size()), token_(net.places), raiser_(net.places), gain_(net.places), wanted_(net.rules.size()) {
    std::vector<Tokens> effect(goals.bounds.size(), 0);
    std::vector<std::uint32_t> touched;
    for (Transition t = 0; t < net.rules.size(); ++t) {
      touched.clear();
      for (const auto& [place, change] : net.rules[t].change)
        for (const auto& [atom, weight] : goals.watch[place]) {
          if (effect[atom] == 0) touched.push_back(atom);
          effect[atom] += weight * change;
        }
      for (const std::uint32_t atom : touched) {
        if (effect[atom] < 0) helpers_[atom].emplace_back(t, std::min(-effect[atom], kFar));
        effect[atom] = 0;
      }
    }
  }

  // Looks at a marking, from which on all that is asked until the next costs so much; kNever is the cost of what no
  // firings lead to, whatever they take.
  void look(const Marking& marking, std::uint64_t enabled) {
    marking_ = &marking;
    enabled_ = enabled;
    sums_ = goals_.sums(marking);
    std::fill(wanted_.begin(), wanted_.end(), false);
    spread(marking);
  }
  const std::vector<Tokens>& sums() const { return sums_; }
  std::uint64_t goal(std::uint32_t root) { return of_goal(root, false); }
  std::uint64_t firing(Transition t) const { return cost_[t]; }
  // A marking with at least so many tokens in each place.
  std::uint64_t cover(const Marking& tokens) const {
    std::uint64_t total = 0;
    for (Place p = 0; p < net_.places; ++p)
      if (const Tokens lacks = tokens[p] - (*marking_)[p]; lacks > 0)
        total = at_most_never(total + (token_[p] >= kNever ? kNever : times(token_[p], (lacks + gain_[p] - 1) / gain_[p])));
    return total;
  }
  // Wants the relaxed run to something, so that it is said of each transition that may fire whether it belongs there.
  void want_goal(std::uint32_t root) {
    of_goal(root, true);
    follow();
  }
  void want_firing(Transition t) {
    want(t);
    follow();
  }
  void want_cover(const Marking& tokens) {
    for (Place p = 0; p < net_.places; ++p)
      if (tokens[p] > (*marking_)[p] && token_[p] < kNever) want(raiser_[p]);
    follow();
  }
  bool wanted(Transition t) const { return wanted_[t]; }

 private:
  void spread(const Marking& marking) {
    std::fill(token_.begin(), token_.end(), kNever);
    std::fill(cost_.begin(), cost_.end(), kNever);
    std::fill(lacking_.begin(), lacking_.end(), 1);
    for (Transition t = 0; t < net_.rules.size(); ++t) {
      missing_[t] = 0;
      for (const auto& [place, weight] : net_.rules[t].need) missing_[t] += marking[place] < weight;
      if (missing_[t] == 0) fires(t);
    }
    while (!queue_.empty()) {
      const auto [cost, place] = queue_.top();
      queue_.pop();
      if (cost != token_[place]) continue;
      token_[place] = cost;
      for (const auto& [t, weight] : net_.users[place]) {
        const Tokens lacks = weight - marking[place];
        if (lacks <= 0) continue;
        lacking_[t] = at_most_never(lacking_[t] + times(cost, (lacks + gain_[place] - 1) / gain_[place]));
        if (--missing_[t] == 0) fires(t);
      }
    }
  }
  void fires(Transition t) {
    cost_[t] = lacking_[t];
    for (const auto& [place, change] : net_.rules[t].change)
      if (change > 0 && cost_[t] < token_[place]) {
        token_[place] = cost_[t];
        raiser_[place] = t;
        gain_[place] = change;
        queue_.emplace(cost_[t], place);
      }
  }
  void follow() {
    while (!work_.empty()) {
      const Transition t = work_.back();
      work_.pop_back();
      for (const auto& [place, weight] : net_.rules[t].need)
        if ((*marking_)[place] < weight) want(raiser_[place]);
    }
  }
  void want(Transition t) {
    if (wanted_[t]) return;
    wanted_[t] = true;
    work_.push_back(t);
  }
  std::uint64_t of_goal(std::uint32_t number, bool wants) {
    const Goals::Node& node = goals_.nodes[number];
    switch (node.kind) {
      case Goals::at_most: return of_sum(node.atom, sums_[node.atom] - goals_.bounds[node.atom], wants);
      case Goals::dead: return enabled_;
      case Goals::not_dead: return enabled_ == 0 ? kNever : 0;
      case Goals::all: {
        std::uint64_t total = 0;
        for (const std::uint32_t inside : node.inside) total = at_most_never(total + of_goal(inside, wants));
        return total;
      }
      case Goals::any: {
        std::uint64_t least = kNever;
        std::uint32_t best = kNone;
        for (const std::uint32_t inside : node.inside) {
          const std::uint64_t found = of_goal(inside, false);
          if (found < least) {
            least = found;
            best = inside;
          }
        }
        if (wants && best != kNone) of_goal(best, true);
        return least;
      }
    }
    return kNever;
  }
  // The cheapest transitions that lower a sum, each once; if all of them do not do, the cheapest more often.
  std::uint64_t of_sum(std::uint32_t atom, Tokens excess, bool wants) {
    if (excess <= 0) return 0;
    excess = std::min(excess, kFar);
    ranked_.clear();
    for (const auto& [t, drop] : helpers_[atom])
      if (cost_[t] < kNever) ranked_.push_back({cost_[t], t, drop});
    if (ranked_.empty()) return kNever;
    std::sort(ranked_.begin(), ranked_.end());
    std::uint64_t total = 0;
    for (const auto& [cost, t, drop] : ranked_) {
      if (wants) want(t);
      total = at_most_never(total + cost);
      excess -= drop;
      if (excess <= 0) return total;
    }
    const auto& [cost, t, drop] = ranked_.front();
    return std::min(kNever - 1, total + times(cost, (excess + drop - 1) / drop));
  }

  struct Helper {
    std::uint64_t cost;
    Transition transition;
    Tokens drop;
    auto operator<=>(const Helper&) const = default;
  };
  using Entry = std::pair<std::uint64_t, Place>;

  const TokenNet& net_;
  const Goals& goals_;
  const Marking* marking_ = nullptr;
  std::uint64_t enabled_ = 0;
  std::vector<Tokens> sums_;
  std::vector<std::vector<std::pair<Transition, Tokens>>> helpers_;  // by atom: what lowers its sum, and by how much
  std::vector<std::uint32_t> missing_;                               // needs that no tokens are there for yet
  std::vector<std::uint64_t> lacking_, cost_;                        // of transitions: what they need, with their firing
  std::vector<std::uint64_t> token_;                                 // by place: what more tokens cost
  std::vector<Transition> raiser_;                                   // by place: the cheapest that puts some there,
  std::vector<Tokens> gain_;                                         // and how many
  std::vector<bool> wanted_;
  std::vector<Transition> work_;
  std::vector<Helper> ranked_;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_;
};

// Markings to evaluate, the nearest first; those that are equally near in a drawn order.
class Open {
 public:
  bool empty() const { return heap_.empty(); }
  void push(std::uint64_t far, std::uint64_t drawn, std::uint32_t number) { heap_.push({far, drawn, number}); }
  std::uint32_t pop() {
    const std::uint32_t number = heap_.top().number;
    heap_.pop();
    return number;
  }
  std::uint64_t bytes() const { return heap_.size() * sizeof(Entry); }

  int credit = 0;  // how often it is asked before the other

 private:
  struct Entry {
    std::uint64_t far, drawn;
    std::uint32_t number;
    auto operator<=>(const Entry&) const = default;
  };
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> heap_;
};

}  // namespace mcpn::search
