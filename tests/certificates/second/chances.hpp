// Between which numbers the probability of an end lies.
#pragma once

#include "goals.hpp"

const std::set<std::string> kEnds{"success", "failure", "abort"};

class Chances : Goals {
 public:
  using Goals::Goals;

  bool chance(const Json& evidence) const {
    need(kEnds.count(statement_.at("end").string) > 0);
    const Rates rates = read();
    std::vector<Big> above, below;
    for (const Int each : numbers(evidence.at("above"))) above.emplace_back(each);
    for (const Int each : numbers(evidence.at("below"))) below.emplace_back(each);
    if (above.size() != count_ || below.size() != count_) return false;
    std::vector<std::size_t> starts;
    for (const Edge& edge : states_.edges[0]) if (event(edge)[0] == "start") starts.push_back(edge.to);
    if (starts.size() != 1) return false;
    const auto ways = chain(rates);
    Set reached(count_);
    std::vector<std::size_t> stack{starts[0]};
    reached[starts[0]] = true;
    while (!stack.empty()) {
      const std::size_t s = stack.back();
      stack.pop_back();
      for (const Way& way : ways[s]) if (!reached[way.to]) { reached[way.to] = true; stack.push_back(way.to); }
    }
    const Set asked = ending({statement_.at("end").string});
    const Big whole(100'000'000'000'000'000);
    Set settled(count_);
    for (std::size_t s = 0; s < count_; ++s) {
      if (!reached[s]) continue;
      if (s % 256 == 0) clock_.look(0);
      if (above[s].sign() < 0) return false;
      settled[s] = ways[s].empty() || below[s].sign() <= 0;
      if (ways[s].empty()) {
        if (asked[s] && (above[s] - whole).sign() < 0) return false;
        if ((below[s] - (asked[s] ? whole : Big())).sign() > 0) return false;
        continue;
      }
      if (largest(ways[s], above, s, rates, false) > 0) return false;
      if (below[s].sign() > 0 && largest(ways[s], below, s, rates, true) > 0) return false;
    }
    for (bool grown = true; grown;) {
      grown = false;
      clock_.look(0);
      for (std::size_t s = count_; s-- > 0;) {
        if (!reached[s] || settled[s] || std::none_of(ways[s].begin(), ways[s].end(), [&](const Way& way) { return bool(settled[way.to]); })) continue;
        settled[s] = true;
        grown = true;
      }
    }
    for (std::size_t s = 0; s < count_; ++s) if (reached[s] && !settled[s]) return false;
    const Big scale("1" + std::string(23, '0'));  // from parts of 10^-17 to parts of 10^-40
    const std::size_t first = starts[0];
    return (above[first] * scale - number(statement_.at("high"))).sign() <= 0 && (below[first] * scale - number(statement_.at("low"))).sign() >= 0;
  }

 private:
  struct Way { std::size_t to; Big least, most; std::string of; };  // a rate, in parts of 1 / duration of an objective if one is named
  struct Objective { Big duration; std::map<std::string, Big> failures; Goal goal; };
  struct Rates { std::map<Texts, Rate> events; std::map<std::string, Objective> objectives; };

  static std::string reason(const Texts& event) { return event.size() == 3 ? event[2] : ""; }
  static bool is_end_of_run(const Texts& event) { return event[0] == "success" || event[0] == "failure"; }

  // What the statement says of rates.
  Rates read() const {
    Rates made;
    Texts hardware;
    for (const Json& each : statement_.at("hardware").items) {
      const std::string& name = each.at("name").string;
      hardware.push_back(name);
      made.events[{"out of service", name}] = rate(each.at("fails"));
      made.events[{"repaired", name}] = rate(each.at("repaired"));
    }
    for (const Json& each : statement_.at("events").items) {
      const Texts named = texts(each.at("event"));
      need(named.size() == 2 && (named[0] == "declared" || named[0] == "detected") && made.events.emplace(named, rate(each.at("rate"))).second);
    }
    std::set<std::string> objectives;
    for (const Transition& each : net_.transitions) if (!each.internal() && is_end_of_run(each.event)) objectives.insert(each.event[1]);
    for (const Json& each : statement_.at("objectives").items) {
      const std::string& name = each.at("name").string;
      Objective one{number(each.at("duration")), {}, goal_of_objective(name)};
      for (const Json& failure : each.at("failures").items)
        need(failure.items.size() == 2 && one.failures.emplace(failure.items[0].string, number(failure.items[1])).second);
      need(part(one, {"success", name}).sign() >= 0);
      need(one.duration.sign() > 0 || std::count(one.goal.won.begin(), one.goal.won.end(), true) == 0);
      need(objectives.count(name) > 0 && made.objectives.emplace(name, std::move(one)).second);
    }
    need(made.objectives.size() == objectives.size() && CutSets(net_, states_, clock_).names_hardware(hardware));
    return made;
  }
  // The rate of an edge by 1.
  static Rate plain(const Rates& rates, const Texts& what) {
    const auto found = rates.events.find(what);
    return found == rates.events.end() ? Rate{} : found->second;
  }
  // The ways out of each state that are taken with some rate.
  std::vector<std::vector<Way>> chain(const Rates& rates) const {
    std::vector<std::vector<Way>> ways(count_);
    std::map<std::string, Set> lost;  // by objective, where it runs and cannot succeed any more
    for (const auto& [name, objective] : rates.objectives) {
      const Goal& goal = objective.goal;
      Set made = backward(goal.won, [&](std::size_t s, const Edge& edge) {
        return goal.is_step(s, edge) && (is_end_of_run(event(edge)) || plain(rates, event(edge)).most.sign() > 0);
      });
      for (std::size_t s = 0; s < count_; ++s) made[s] = goal.open[s] && !made[s];
      lost.emplace(name, std::move(made));
    }
    const Set ends = ending(kEnds);
    for (std::size_t s = 0; s < count_; ++s) {
      if (ends[s]) continue;
      for (const Edge& edge : states_.edges[s]) {
        const Texts& what = event(edge);
        if (what[0] == "failure" && what.size() == 2 && lost.at(what[1])[s]) ways[s].push_back({edge.to, kOne, kOne, ""});
      }
      if (!ways[s].empty()) continue;  // it is hasty
      for (const Edge& edge : states_.edges[s]) {
        const Texts& what = event(edge);
        if (edge.to == s) continue;
        Way way{edge.to, {}, {}, ""};
        const auto objective = rates.objectives.find(what[1]);
        if (is_end_of_run(what) && objective->second.goal.won[s]) {
          way.of = what[1];
          way.most = part(objective->second, what);
          way.least = way.most;
        } else {
          const Rate found = plain(rates, what);
          way.least = found.least;
          way.most = found.most;
        }
        if (way.most.sign() > 0) ways[s].push_back(std::move(way));
      }
    }
    return ways;
  }
  static Big part(const Objective& of, const Texts& what) {
    if (what[0] == "failure") {
      const auto found = of.failures.find(reason(what));
      return found == of.failures.end() ? Big() : found->second;
    }
    Big left = kOne;
    for (const auto& [_, failure] : of.failures) left = left - failure;
    return left;
  }
  // The sign of the sum of rates times differences, with the rates chosen so that it is largest.
  static int largest(const std::vector<Way>& ways, const std::vector<Big>& values, std::size_t s, const Rates& rates, bool smallest) {
    std::set<std::string> objectives;
    for (const Way& way : ways) if (!way.of.empty()) objectives.insert(way.of);
    Big sum;
    for (const Way& way : ways) {
      const Big rises = smallest ? values[s] - values[way.to] : values[way.to] - values[s];
      Big term = (rises.sign() > 0 ? way.most : way.least) * rises * (way.of.empty() ? Big(1) : kOne);
      for (const std::string& name : objectives) if (name != way.of) term = term * rates.objectives.at(name).duration;
      sum = sum + term;
    }
    return sum.sign();
  }
};
