// How activities react to what has happened: they are idle, try alternatives, ask, run and are refused, until nothing can be done.
#pragma once

#include "state.hpp"

class Reaction : Doings {
 public:
  Reaction(const Core& core, const Clock& clock) : Doings(core), clock_(clock) {}

  // The first thing: activities of no objective that runs are idle, and so are producers that nobody needs.
  void stop(State& state) const {
    std::set<std::size_t> run;
    underway(state.root, [&](const Node& node) { if (node.run == Run::runs) run.insert(node.at->activities.begin(), node.at->activities.end()); });
    for (std::size_t a = 0; a < state.activities.size(); ++a)
      if (core_.activities[a].products.empty() && !run.count(a)) idle(state.activities[a]);
    while (unneeded(state)) {}
  }

  // All states in which nothing more can be done.
  std::map<std::string, State> settled(State from) const {
    std::map<std::string, State> ends;
    std::set<std::string> seen;
    std::vector<State> open;
    const auto next = [&](State state) {
      suspect(state);
      if (seen.insert(key_of(state)).second) open.push_back(std::move(state));
    };
    next(std::move(from));
    while (!open.empty()) {
      clock_.look(seen.size());
      State state = std::move(open.back());
      open.pop_back();
      if (State made = state; at_once(made)) { next(std::move(made)); continue; }
      const std::vector<std::size_t> ask = askers(state);
      for (const std::size_t a : ask) {
        State made = state;
        made.activities[a].does = Does::asks;
        next(std::move(made));
      }
      if (State made = state; by_layers(made)) { next(std::move(made)); continue; }
      auto begin = ask.empty() ? beginners(state, true) : std::vector<const Section*>();
      if (begin.empty()) begin = beginners(state, false);
      for (const Section* each : begin) next(begun(state, each));
      if (!begin.empty()) continue;
      if (State made = state; unneeded(made)) next(std::move(made));
      else if (ask.empty()) ends.emplace(key_of(state), std::move(state));
    }
    return ends;
  }

 private:
  static void idle(Doing& of) { of = {}; }
  static void tries(Doing& of, std::size_t alternative) { of = {Does::tries, alternative, {}}; }
  const Alternative& its(const State& of, std::size_t activity) const { return core_.activities[activity].alternatives[of.activities[activity].alternative]; }
  bool needed(const State& of, std::size_t producer) const {
    const auto& products = core_.activities[producer].products;
    return some(of, [&](std::size_t, const Doing& doing, const Alternative& its) {
      return doing.has() && !doing.told.count(producer) && its.producers.count(producer);
    }) && !products.empty();
  }
  bool known_out(const State& of, const Alternative& alternative) const {
    return std::any_of(alternative.hardware.begin(), alternative.hardware.end(), [&](std::size_t h) { return of.hardware[h].out && of.hardware[h].known; });
  }
  bool in_error(const State& of, std::size_t a) const {
    return of.activities[a].has() && (!of.activities[a].told.empty() || known_out(of, its(of, a)) || !so(its(of, a).requires_, of.facts));
  }
  // Whether activities can have alternatives, the first one this, that need no exclusive hardware twice.
  bool possible(const State& of, const Alternative& first) const {
    std::map<std::size_t, const Alternative*> chosen;
    std::set<std::size_t> taken;
    const std::function<bool(std::vector<std::size_t>)> all = [&](std::vector<std::size_t> open) -> bool {
      while (!open.empty() && chosen.count(open.back())) open.pop_back();
      if (open.empty()) return true;
      const std::size_t next = open.back();
      open.pop_back();
      for (const Alternative& each : core_.activities[next].alternatives) if (take(of, each, next, open, chosen, taken, all)) return true;
      return false;
    };
    return take(of, first, core_.activities.size(), {}, chosen, taken, all);
  }
  template <class All>
  bool take(const State& of, const Alternative& one, std::size_t activity, std::vector<std::size_t> open, std::map<std::size_t, const Alternative*>& chosen,
            std::set<std::size_t>& taken, const All& all) const {
    if (known_out(of, one) || !so(one.requires_, of.facts)) return false;
    for (const std::size_t h : one.hardware) if (!core_.hardware[h].shared && taken.count(h)) return false;
    clock_.look(0);
    const std::set<std::size_t> before = taken;
    taken.insert(one.hardware.begin(), one.hardware.end());
    chosen[activity] = &one;
    open.insert(open.end(), one.producers.begin(), one.producers.end());
    if (all(open)) return true;
    chosen.erase(activity);
    taken = before;
    return false;
  }

  bool unneeded(State& state) const {
    std::vector<std::size_t> found;
    for (std::size_t a = 0; a < state.activities.size(); ++a)
      if (!core_.activities[a].products.empty() && state.activities[a].does != Does::idle && !needed(state, a)) found.push_back(a);
    for (const std::size_t a : found) idle(state.activities[a]);
    return !found.empty();
  }

  // 1: whether somebody tries, asks, runs or is refused at once.
  bool at_once(State& state) const {
    const State before = state;
    bool did = false;
    for (std::size_t a = 0; a < state.activities.size(); ++a) {
      const Activity& activity = core_.activities[a];
      const Doing& was = before.activities[a];
      Doing& doing = state.activities[a];
      if (was.does == Does::idle && needed(before, a)) tries(doing, 0);
      else if (was.does == Does::tries && was.alternative >= activity.alternatives.size()) doing = {Does::refused, 0, {}};
      else if (was.does == Does::tries) {
        const Alternative& one = its(before, a);
        const bool lost = std::any_of(one.hardware.begin(), one.hardware.end(), [&](std::size_t h) { return before.hardware[h].out && before.hardware[h].known && !had(before, h); });
        const bool free = std::none_of(one.consumed.begin(), one.consumed.end(), [&](std::size_t each) { return core_.contended[each]; });
        if (lost || !so(one.requires_, before.facts)) tries(doing, was.alternative + 1);
        else if (free && !known_out(before, one)) doing.does = Does::asks;
        else continue;
      } else if (was.does == Does::asks && its(before, a).producers.empty()) doing.does = Does::runs;
      else continue;
      did = true;
    }
    return did;
  }
  // 2: whether a layer does something.
  bool by_layers(State& state) const {
    const State before = state;
    std::size_t last = 0;
    for (const Activity& each : core_.activities) last = std::max(last, each.layer);
    for (std::size_t layer = 0; layer <= last; ++layer) {
      bool did = false;
      const auto each_of = [&](const auto& does) {
        for (std::size_t a = 0; a < state.activities.size(); ++a) if (does(a, before.activities[a], state.activities[a])) did = true;
        return did;
      };
      const auto errs = [&](std::size_t a, const Doing& was, Doing& doing) {
        if (core_.activities[a].layer != layer) return false;
        if (in_error(before, a)) tries(doing, was.does == Does::runs ? 0 : was.alternative + 1);
        else if (was.does == Does::runs && core_.activities[a].switch_back && better(before, a)) tries(doing, 0);
        else return false;
        return true;
      };
      const auto tells = [&](std::size_t a, const Doing& was, Doing& doing) {
        if (core_.activities[a].layer != layer || core_.activities[a].products.empty() || was.does != Does::refused) return false;
        for (std::size_t user = 0; user < state.activities.size(); ++user)
          if (before.activities[user].has() && its(before, user).producers.count(a)) state.activities[user].told.insert(a);
        idle(doing);
        return true;
      };
      const auto runs = [&](std::size_t a, const Doing& was, Doing& doing) {
        if (was.does != Does::asks || in_error(before, a)) return false;
        bool reached = false;
        for (const std::size_t producer : its(before, a).producers) {
          if (before.activities[producer].does != Does::runs) return false;
          reached = reached || core_.activities[producer].layer <= layer;
        }
        if (reached) doing.does = Does::runs;
        return reached;
      };
      if (each_of(errs) || each_of(tells) || each_of(runs)) return true;
    }
    return false;
  }
  bool better(const State& of, std::size_t a) const {
    for (std::size_t each = 0; each < of.activities[a].alternative; ++each) if (possible(of, core_.activities[a].alternatives[each])) return true;
    return false;
  }
  // Who may ask for what is contended.
  std::vector<std::size_t> askers(const State& of) const {
    std::vector<std::size_t> found;
    for (std::size_t a = 0; a < of.activities.size(); ++a) {
      if (of.activities[a].does != Does::tries || of.activities[a].alternative >= core_.activities[a].alternatives.size()) continue;
      const Alternative& one = its(of, a);
      const bool free = std::none_of(one.consumed.begin(), one.consumed.end(), [&](std::size_t each) { return core_.contended[each] && had(of, each); });
      if (free && !known_out(of, one)) found.push_back(a);
    }
    return found;
  }
  // 3 and 4: objectives that may begin, those whose activities no other one wants, or others.
  std::vector<const Section*> beginners(const State& of, bool alone) const {
    std::map<std::size_t, int> wanted;
    std::vector<const Section*> about, found;
    underway(of.root, [&](const Node& node) {
      if (node.at->block || node.run != Run::begins) return;
      about.push_back(node.at);
      for (const std::size_t a : std::set<std::size_t>(node.at->activities.begin(), node.at->activities.end())) ++wanted[a];
    });
    for (const Section* each : about) {
      const auto& its = each->activities;
      const bool idle = std::all_of(its.begin(), its.end(), [&](std::size_t a) { return of.activities[a].does == Does::idle; });
      const bool single = std::all_of(its.begin(), its.end(), [&](std::size_t a) { return wanted[a] == 1; });
      if (idle && single == alone) found.push_back(each);
    }
    return found;
  }
  static State begun(State state, const Section* objective) {
    underway(state.root, [&](Node& node) { if (node.at == objective) node.run = Run::runs; });
    for (const std::size_t a : objective->activities) tries(state.activities[a], 0);
    return state;
  }
  void suspect(State& state) const {
    for (std::size_t h = 0; h < state.hardware.size(); ++h)
      if (state.hardware[h].suspected && !had(state, h)) state.hardware[h] = {true, true, false};
  }

  const Clock& clock_;
};
