// Cut sets at other moments than the start of the mission, the worst one among them.
#pragma once

#include "goals.hpp"

class Moments : Goals {
 public:
  using Goals::Goals;

  bool cut_sets(const std::string& kind, const Json& evidence) const {
    if (kind == "cut_sets_at_worst") return at_worst();
    const Goal goal = goal_of(kind == "cut_sets_at_start");
    Search search{goal.open, goal.won, goal.is_step};
    if (kind == "cut_sets_at_start") search.moments = ending({"begin"});
    if (kind == "cut_sets_at_entry") search.moments = entries();
    return CutSets(net_, states_, clock_).proved(statement_, evidence.at("survived"), search);
  }

 private:
  Set entries() const {
    const Texts entered = texts(statement_.at("entered")), again = texts(statement_.at("again"));
    const auto& inside = statement_.at("inside").items;
    for (const Json& role : inside) need(role.items.size() == 2);
    Set made(count_);
    for (std::size_t s = 0; s < count_; ++s) {
      const bool is_inside = std::any_of(inside.begin(), inside.end(), [&](const Json& role) { return marks(s, role.items[0].string, role.items[1].string); });
      for (const Edge& edge : states_.edges[s]) {
        const bool enters = std::any_of(entered.begin(), entered.end(), [&](const std::string& name) { return runs(edge.to, name) || marks(edge.to, "pending", name); });
        if (enters && (!is_inside || std::any_of(again.begin(), again.end(), [&](const std::string& name) { return ends_run(s, edge, name); }))) made[edge.to] = true;
      }
    }
    made = forward(std::move(made), [this](std::size_t, const Edge& edge) { return event(edge)[0] == "out of service"; });
    const std::string& objective = statement_.at("goal").at("objective").string;
    for (std::size_t s = 0; s < count_; ++s) made[s] = made[s] && (objective.empty() || runs(s, objective));
    return made;
  }
  Set worst_moments(const Goal& goal) const {
    std::map<std::string, Set> hopeless;  // by objective, where it runs and cannot succeed without repairs
    const auto is_hopeless = [&](std::size_t s, const std::string& objective) {
      auto found = hopeless.find(objective);
      if (found == hopeless.end()) {
        const Goal own = goal_of_objective(objective);
        Set made = backward(own.won, [&](std::size_t from, const Edge& edge) { return event(edge)[0] != "repaired" && own.is_step(from, edge); });
        for (std::size_t each = 0; each < count_; ++each) made[each] = own.open[each] && !made[each];
        found = hopeless.emplace(objective, std::move(made)).first;
      }
      return bool(found->second[s]);
    };
    std::map<std::string, Texts> timed;
    for (const Json& each : statement_.at("timed").items) {
      const Texts names = texts(each);
      need(!names.empty() && timed.emplace(names[0], Texts(names.begin() + 1, names.end())).second);
    }
    Set moments(count_);
    moments[0] = true;
    moments = forward(std::move(moments), [&](std::size_t s, const Edge& edge) {
      const Texts& what = event(edge);
      if (what[0] == "repaired") return false;
      if (what[0] == "failure") return is_hopeless(s, what[1]);
      if (what[0] != "timeout") return true;
      const auto held = timed.find(what[1]);
      if (held == timed.end()) return is_hopeless(s, what[1]);
      return std::any_of(held->second.begin(), held->second.end(), [&](const std::string& name) { return is_hopeless(s, name); });
    });
    const Texts over = texts(statement_.at("over"));
    const Set past = ending({over.begin(), over.end()});
    for (std::size_t s = 0; s < count_; ++s) moments[s] = moments[s] && goal.open[s] && !past[s];
    return moments;
  }
  bool at_worst() const {
    const Texts names = texts(statement_.at("hardware"));
    const CutSets judge(net_, states_, clock_);
    if (!judge.names_hardware(names)) return false;
    std::set<CutSets::Mask> cuts;
    for (const Json& each : statement_.at("cuts").items) {
      CutSets::Mask made;
      if (!CutSets::mask(names, texts(each), made)) return false;
      cuts.insert(made);
    }
    const Goal goal = goal_of(false);
    const Set moments = worst_moments(goal);
    std::map<CutSets::Mask, std::vector<std::size_t>> by_lost;
    for (std::size_t s = 0; s < count_; ++s) {
      if (!moments[s]) continue;
      CutSets::Mask lost(names.size());
      for (std::size_t i = 0; i < names.size(); ++i) lost[i] = marks(s, "oos", names[i]);
      by_lost[lost].push_back(s);
    }
    std::set<CutSets::Mask> losing;
    const Set unrepaired = backward(goal.won, [&](std::size_t s, const Edge& edge) { return event(edge)[0] != "repaired" && goal.is_step(s, edge); });
    for (const auto& [lost, states] : by_lost) {
      if (std::all_of(states.begin(), states.end(), [&](std::size_t s) { return bool(unrepaired[s]); })) continue;
      std::set<std::string> gone;
      for (std::size_t i = 0; i < names.size(); ++i) if (lost[i]) gone.insert(names[i]);
      const Set winning = backward(goal.won, [&](std::size_t s, const Edge& edge) { return goal.is_step(s, edge) && !(event(edge)[0] == "repaired" && gone.count(event(edge)[1])); });
      if (std::any_of(states.begin(), states.end(), [&](std::size_t s) { return !winning[s]; })) losing.insert(lost);
    }
    for (const auto& cut : cuts) {
      if (!losing.count(cut)) return false;
      for (const auto& other : cuts) if (other != cut && CutSets::within(cut, other)) return false;
    }
    return std::all_of(losing.begin(), losing.end(), [&](const auto& lost) {
      return std::any_of(cuts.begin(), cuts.end(), [&](const auto& cut) { return CutSets::within(cut, lost); });
    });
  }
};
