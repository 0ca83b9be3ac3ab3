// A lasso of the product of a net and an automaton, found greedily in legs.
//
// The first leg leads to a component of the automaton that may accept, the next ones, inside it, to a step with each
// mark; then all marks once more, and back to where that began. Any circle with all marks that closes on the way will
// do. Each leg is a greedy best-first search in the product (greedy.hpp): it costs the relaxed runs to what the
// cheapest edges of the automaton ask for, and on the way back the tokens that are lacking.
#include <unordered_map>

#include "search/greedy.hpp"
#include "search/product.hpp"

namespace mcpn::search {

namespace {

constexpr std::uint64_t kLegs = 4;  // a leg that ends the search has had this part of its steps

class Guided : public LassoSearch {
 public:
  Guided(const PathTask& task, std::uint32_t bits, const LassoOptions& options)
      : task_(task), automaton_(task.automaton), options_(options), product_(task, bits, options.seed),
        relaxation_(task.net, task.goals), draw_(options.seed), anchor_(task.net.places), best_(automaton_.edges.size()),
        left_(automaton_.edges.size()), roots_(task.roots.size()) {
    look_at_components();
  }

  Lasso go_on(std::uint64_t steps, const GoOn& still) override {
    if (product_.size() == 0) {
      here_ = product_.begin(task_.initial);
      if (automaton_.accepting_all[0]) return {Lasso::found};
      if (!hopeful_[0]) return {Lasso::none};
      arrive();
    }
    for (const std::uint64_t until = count_ + steps; count_ < until; ++count_) {
      if ((count_ & 0x3F) == 0x3F) {
        if (!still()) throw Interrupted();
        if (bytes() > options_.max_bytes) throw Limit{Lasso::bytes};
      }
      if (count_ >= options_.max_steps) throw Limit{Lasso::steps};
      if (every_.empty() && preferred_.empty()) {
        if (stage_ == reach) return {Lasso::none};
        give_up_leg();
      } else if (stage_ != reach && count_ >= leg_ends_) {
        give_up_leg();
      } else if (auto found = take()) {
        return *found;
      }
    }
    return {Lasso::pause};
  }

 private:
  enum Stage : std::uint8_t { reach, gather, close };
  struct Came {
    std::uint32_t leg = 0, from = kNone;
    Step by{};
    std::uint64_t marks = 0;
    bool expanded = false;
  };
  struct Hop {
    Step by;
    std::uint64_t marks;
  };

  void look_at_components() {
    const auto& of = automaton_.components;
    std::vector<std::uint64_t> marks(of.size(), 0);
    std::vector<bool> inside(of.size(), false);
    for (std::uint32_t q = 0; q < of.size(); ++q)
      for (const AutomatonEdge& edge : automaton_.edges[q])
        if (of[edge.target] == of[q]) {
          inside[of[q]] = true;
          marks[of[q]] |= edge.marks;
        }
    accepts_.resize(of.size());
    for (std::uint32_t q = 0; q < of.size(); ++q)
      accepts_[q] = automaton_.accepting_all[q] || (inside[of[q]] && marks[of[q]] == automaton_.marks);
    hopeful_ = accepts_;
    for (bool changed = true; changed;) {
      changed = false;
      for (std::uint32_t q = 0; q < of.size(); ++q)
        for (const AutomatonEdge& edge : automaton_.edges[q])
          if (hopeful_[edge.target] && !hopeful_[q]) hopeful_[q] = changed = true;
    }
  }

  // Begins a leg where the one before has ended.
  void begin(Stage stage) {
    stage_ = stage;
    ++leg_;
    leg_ends_ = count_ + std::max<std::uint64_t>(options_.max_steps / kLegs, 1);
    nearest_ = kNever;
    every_ = {};
    preferred_ = {};
    came(here_) = {leg_, kNone, {}, 0, false};
    every_.push(0, 0, here_);
  }
  void arrive() {
    if (stage_ == reach) {
      if (!accepts_[product_.state(here_)]) return begin(reach);
      missing_ = automaton_.marks;
    }
    if (missing_) return begin(gather);
    if (!anchored_) return anchor();
    begin(close);
  }
  // What follows is to come back here.
  void anchor() {
    anchored_ = true;
    product_.marking_of(here_, anchor_);
    anchor_state_ = product_.state(here_);
    missing_ = automaton_.marks;
    begin(missing_ ? gather : close);
  }
  void give_up_leg() {
    if (stage_ != close || ++tries_ == kLegs) throw Limit{Lasso::steps};
    anchor();
  }

  // Evaluates a pair and looks at what follows it.
  std::optional<Lasso> take() {
    Open& open = preferred_.empty() || (!every_.empty() && every_.credit > preferred_.credit) ? every_ : preferred_;
    --open.credit;
    const std::uint32_t at = open.pop();
    if (came(at).expanded) return {};
    came(at).expanded = true;
    steps_.clear();
    if (product_.expand(at, steps_)) return found(at);
    relaxation_.look(product_.tokens(), product_.enabled().size());
    const std::uint32_t state = product_.state(at);
    const std::uint64_t far = estimate(state);
    if (far >= kNever) return {};
    if (far < nearest_) {
      nearest_ = far;
      preferred_.credit += kBoost;
    }
    want(state);
    for (const Step& step : steps_) {
      const AutomatonEdge& edge = product_.edge(at, step);
      if (automaton_.accepting_all[edge.target]) return found(at, step);
      if (!hopeful_[edge.target] || (stage_ != reach && !inside(state, edge.target))) continue;
      const std::uint32_t target = product_.after(at, step).first;
      const bool seen = came(target).leg == leg_;
      if (seen || passed_.contains(target))
        if (auto lasso = closed(at, step, target)) return lasso;
      if (seen) continue;
      came(target) = {leg_, at, step, edge.marks, false};
      if (stage_ == reach ? bool(accepts_[edge.target]) : stage_ == gather && (edge.marks & missing_)) {
        keep(target);
        return {};
      }
      // Of what is equally near on the way back the newest goes first, so that a circle closes soon.
      const std::uint64_t drawn = stage_ == close ? ~++pushed_ : draw_.next();
      every_.push(far, drawn, target);
      if (step.transition != kNone && relaxation_.wanted(step.transition)) preferred_.push(far, drawn, target);
    }
    return {};
  }
  // Ends a leg.
  void keep(std::uint32_t target) {
    std::vector<Hop> hops;
    std::vector<std::uint32_t> pairs;
    for (std::uint32_t p = target; p != here_; p = came(p).from) {
      hops.push_back({came(p).by, came(p).marks});
      pairs.push_back(came(p).from);
    }
    while (!hops.empty()) {
      passed_.try_emplace(pairs.back(), trail_.size());
      trail_.push_back(hops.back());
      if (stage_ == gather) missing_ &= ~hops.back().marks;
      hops.pop_back();
      pairs.pop_back();
    }
    here_ = target;
    arrive();
  }

  // The circle that a step closes, if it has all marks.
  std::optional<Lasso> closed(std::uint32_t at, const Step& step, std::uint32_t target) {
    std::uint64_t marks = product_.edge(at, step).marks;
    std::size_t hops = 1;
    for (std::uint32_t p = at;; p = came(p).from, ++hops) {
      if (p == target) break;
      if (p != here_) {
        marks |= came(p).marks;
        continue;
      }
      const auto begun = passed_.find(target);
      if (begun == passed_.end()) return {};
      for (std::size_t i = begun->second; i < trail_.size(); ++i, ++hops) marks |= trail_[i].marks;
      break;
    }
    if (marks != automaton_.marks) return {};
    std::vector<Step> all = way(at);
    all.push_back(step);
    Lasso lasso{Lasso::found};
    std::optional<std::size_t> cycle;
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (i == all.size() - hops) cycle = lasso.run.size();
      if (all[i].transition != kNone) lasso.run.push_back(all[i].transition);
    }
    if (lasso.run.size() > *cycle) lasso.cycle = cycle;  // else nothing may fire
    return lasso;
  }
  std::vector<Step> way(std::uint32_t at) {
    std::vector<Step> leg, all;
    for (; at != here_; at = came(at).from) leg.push_back(came(at).by);
    for (const Hop& hop : trail_) all.push_back(hop.by);
    all.insert(all.end(), leg.rbegin(), leg.rend());
    return all;
  }
  // All that goes on from a pair, or from a step beyond, is accepted.
  Lasso found(std::uint32_t at, const Step& beyond = {kNone, 0}) {
    Lasso lasso{Lasso::found};
    for (const Step& step : way(at))
      if (step.transition != kNone) lasso.run.push_back(step.transition);
    if (beyond.transition != kNone) lasso.run.push_back(beyond.transition);
    return lasso;
  }

  bool inside(std::uint32_t state, std::uint32_t target) const {
    return automaton_.components[state] == automaton_.components[target];
  }
  // What is left of the leg from the marking that is looked at, by the cheapest edges from each state.
  std::uint64_t estimate(std::uint32_t state) {
    std::fill(left_.begin(), left_.end(), kNever);
    for (std::size_t i = 0; i < roots_.size(); ++i) roots_[i] = relaxation_.goal(task_.roots[i]);
    if (stage_ == close) left_[anchor_state_] = 0;
    for (std::uint32_t q = 0; stage_ == reach && q < left_.size(); ++q)
      if (accepts_[q]) left_[q] = 0;
    for (bool changed = true; changed;) {
      changed = false;
      for (std::uint32_t q = 0; q < left_.size(); ++q) {
        if (!hopeful_[q] || (stage_ != reach && !inside(state, q))) continue;
        for (const AutomatonEdge& edge : automaton_.edges[q]) {
          if (stage_ != reach && !inside(state, edge.target)) continue;
          const std::uint64_t rest = stage_ == gather && (edge.marks & missing_) ? 0 : left_[edge.target];
          if (rest >= left_[q]) continue;
          const std::uint64_t total = at_most_never(rest + asks(edge));
          if (total >= left_[q]) continue;
          left_[q] = total;
          best_[q] = &edge;
          changed = true;
        }
      }
    }
    // Where no run leads back, some circle may still close.
    return stage_ == close ? std::min(left_[state] + relaxation_.cover(anchor_), kNever - 1) : left_[state];
  }
  std::uint64_t asks(const AutomatonEdge& edge) {
    std::uint64_t total = edge.any || edge.rests ? 1 : relaxation_cost(cheapest(edge));
    for (const std::uint32_t literal : edge.literals) total = at_most_never(total + roots_[literal]);
    return total;
  }
  std::uint64_t relaxation_cost(Transition t) const { return t == kNone ? kNever : relaxation_.firing(t); }
  Transition cheapest(const AutomatonEdge& edge) const {
    Transition best = kNone;
    for (const Transition t : edge.fired)
      if (relaxation_.firing(t) < relaxation_cost(best)) best = t;
    return best;
  }
  void want(std::uint32_t state) {
    for (std::uint64_t rest = kNever; left_[state] > 0 && left_[state] < rest;) {
      rest = left_[state];
      const AutomatonEdge& edge = *best_[state];
      for (const std::uint32_t literal : edge.literals) relaxation_.want_goal(task_.roots[literal]);
      if (const Transition t = edge.any || edge.rests ? kNone : cheapest(edge); t != kNone) relaxation_.want_firing(t);
      if (stage_ == gather && (edge.marks & missing_)) break;
      state = edge.target;
    }
    if (stage_ == close) relaxation_.want_cover(anchor_);
  }

  Came& came(std::uint32_t at) {
    if (at >= came_.size()) came_.resize(std::max<std::size_t>(product_.size(), at + 1));
    return came_[at];
  }
  std::uint64_t bytes() const {
    return product_.bytes() + came_.capacity() * sizeof(Came) + every_.bytes() + preferred_.bytes();
  }

  const PathTask& task_;
  const Automaton& automaton_;
  LassoOptions options_;
  Product product_;
  Relaxation relaxation_;
  Draw draw_;
  std::vector<bool> accepts_, hopeful_;  // by state: whether its component may accept, and whether one after it may
  Stage stage_ = reach;
  std::uint64_t count_ = 0, leg_ends_ = 0, nearest_ = kNever, missing_ = 0, tries_ = 0, pushed_ = 0;
  std::uint32_t leg_ = 0, here_ = 0;     // the leg, and the pair where it began
  std::vector<Hop> trail_;               // from the initial pair to there
  std::unordered_map<std::uint32_t, std::size_t> passed_;  // the pairs on it, and how many hops were before each
  bool anchored_ = false;
  Marking anchor_;
  std::uint32_t anchor_state_ = 0;
  std::vector<Came> came_;               // by pair: how the leg has come there
  Open every_, preferred_;
  std::vector<Step> steps_;
  std::vector<const AutomatonEdge*> best_;  // by state, with what is left
  std::vector<std::uint64_t> left_, roots_;
};

}  // namespace

std::unique_ptr<LassoSearch> guided(const PathTask& task, std::uint32_t bits, const LassoOptions& options) {
  return std::make_unique<Guided>(task, bits, options);
}

}  // namespace mcpn::search
