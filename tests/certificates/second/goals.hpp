// Goals of further claims: where they are won, where they are open, and which steps lead to them.
#pragma once

#include "cut_sets.hpp"
#include "grown.hpp"
#include "rate.hpp"

class Goals {
 public:
  Goals(const Net& net, const States& states, const Clock& clock, const Json& statement)
      : net_(net), states_(states), clock_(clock), statement_(statement), count_(states.markings.size()), before_(count_) {
    for (std::size_t s = 0; s < count_; ++s) {
      for (const Edge& edge : states.edges[s]) before_[edge.to].push_back({s, edge});
      for (std::size_t p = 0; p < net.places.size(); ++p)
        if (states.markings[s][p]) for (const Role& role : net.places[p].roles) mark(role, s);
    }
    for (const Json& each : statement.at("stopped").items) {
      const Numbers all = numbers(each.at("transitions"));
      for (const Int t : all) need(t >= 0 && t < Int(net.transitions.size()) && !net.transitions[std::size_t(t)].internal());
      need(stopped_.emplace(each.at("objective").string, std::set<Int>(all.begin(), all.end())).second);
    }
  }

 protected:
  using Step = std::function<bool(std::size_t, const Edge&)>;
  struct Goal { Set won, open; Step is_step; };

  void mark(const Role& role, std::size_t s) {
    Set& set = marked_.emplace(role, Set(count_)).first->second;
    set[s] = true;
  }
  bool marks(std::size_t s, const std::string& role, const std::string& element) const {
    const auto found = marked_.find({role, element});
    return found != marked_.end() && found->second[s];
  }
  Set ending(const std::set<std::string>& roles) const {
    return states_.ending(roles);
  }
  const Texts& event(const Edge& edge) const { return net_.transitions[std::size_t(edge.transition)].event; }
  bool runs(std::size_t s, const std::string& objective) const { return marks(s, "objective", objective); }
  bool ends_run(std::size_t s, const Edge& edge, const std::string& objective) const {
    if (!runs(s, objective)) return false;
    if (!runs(edge.to, objective)) return true;
    const Texts& what = event(edge);
    if (what[1] == objective && (what[0] == "success" || what[0] == "failure" || what[0] == "timeout")) return true;
    const auto found = stopped_.find(objective);
    return found != stopped_.end() && found->second.count(edge.transition) > 0;
  }
  Goal goal_of_objective(const std::string& objective) const {
    Goal made{Set(count_), Set(count_), [this, objective](std::size_t s, const Edge& edge) { return runs(s, objective) && !ends_run(s, edge, objective); }};
    for (std::size_t s = 0; s < count_; ++s) {
      made.open[s] = runs(s, objective);
      const auto& out = states_.edges[s];
      made.won[s] = made.open[s] && std::any_of(out.begin(), out.end(), [&](const Edge& edge) { return event(edge)[0] == "success" && event(edge)[1] == objective; });
    }
    return made;
  }
  Goal goal_of(bool at_start) const {
    const Json& goal = statement_.at("goal");
    const Texts roles = texts(goal.at("ends"));
    need(roles.empty() != goal.at("objective").string.empty());
    const Step all = [](std::size_t, const Edge&) { return true; };
    if (!roles.empty()) {
      Goal made{ending({roles.begin(), roles.end()}), {}, all};
      made.open = made.won;
      made.open.flip();
      return made;
    }
    Goal made = goal_of_objective(goal.at("objective").string);
    if (at_start) made.is_step = all;
    return made;
  }
  // What some edges lead to, from some states.
  Set forward(Set from, const Step& is_step) const {
    clock_.look(0);
    return grown(std::move(from), [&](std::size_t s, const auto& add) { for (const Edge& edge : states_.edges[s]) if (is_step(s, edge)) add(edge.to); });
  }
  // From where some edges lead to some states.
  Set backward(Set to, const Step& is_step) const {
    clock_.look(0);
    return grown(std::move(to), [&](std::size_t s, const auto& add) { for (const auto& [from, edge] : before_[s]) if (is_step(from, edge)) add(from); });
  }

  const Net& net_;
  const States& states_;
  const Clock& clock_;
  const Json& statement_;
  std::size_t count_;
  std::vector<std::vector<std::pair<std::size_t, Edge>>> before_;
  std::map<Role, Set> marked_;
  std::map<std::string, std::set<Int>> stopped_;
};
