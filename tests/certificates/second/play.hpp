// A mission that is played, in C++ from docs/certificates.md alone: what places say of it, what may happen, and what comes of it.
#pragma once

#include "reaction.hpp"
#include "routes.hpp"

class Play : Doings {
 public:
  Play(const Core& core, const Clock& clock) : Doings(core), routes_(core), reaction_(core, clock) {}

  State first() const {
    State made;
    made.facts = core_.initial;
    for (const Hardware& each : core_.hardware) made.hardware.push_back({each.out, each.out, false});
    made.activities.resize(core_.activities.size());
    return made;
  }

  std::set<Role> look(const State& of) const {
    std::set<Role> found;
    if (!of.end.empty()) found.emplace(of.end, "");
    underway(of.root, [&](const Node& node) {
      if (!node.at->block) found.emplace(node.run == Run::runs ? "objective" : "pending", node.at->name);
    });
    for (const Node& node : of.root) done(node, found);
    for (std::size_t a = 0; a < of.activities.size(); ++a) {
      const Doing& doing = of.activities[a];
      const Activity& activity = core_.activities[a];
      if (doing.does == Does::refused) found.emplace("refused", activity.name);
      else if (doing.does != Does::idle && doing.alternative < activity.alternatives.size())
        found.emplace(doing.does == Does::runs ? "active" : "wait", activity.name + '.' + activity.alternatives[doing.alternative].name);
    }
    for (std::size_t h = 0; h < of.hardware.size(); ++h) {
      if (of.hardware[h].out) found.emplace("oos", core_.hardware[h].name);
      if (of.hardware[h].out && core_.hardware[h].late && of.hardware[h].known) found.emplace("known", core_.hardware[h].name);
    }
    for (std::size_t f = 0; f < of.facts.size(); ++f) found.emplace("fact", core_.facts[f] + '=' + of.facts[f]);
    for (const std::string& once : of.happened) found.emplace("happened", once);
    return found;
  }

  // What may happen.
  std::set<Texts> events(const State& of) const {
    std::set<Texts> found;
    for (std::size_t h = 0; h < of.hardware.size(); ++h) {
      const Hardware& hardware = core_.hardware[h];
      const Part& part = of.hardware[h];
      const bool may = hardware.faulty && !part.out && (!hardware.crash || some(of, [&](std::size_t, const Doing& doing, const Alternative& its) { return doing.does == Does::runs && its.hardware.count(h); }));
      if (may) found.insert({"out of service", hardware.name});
      if (part.out && part.known && hardware.repairable) found.insert({"repaired", hardware.name});
      const bool looks = some(of, [&](std::size_t a, const Doing& doing, const Alternative&) { return doing.does == Does::runs && core_.activities[a].detects.count(h); });
      if (part.out && !part.known && looks) found.insert({"detected", hardware.name});
    }
    for (const auto& [name, changes] : core_.events)
      if (std::any_of(changes.begin(), changes.end(), [&](const auto& each) { return of.facts[each.first.first] == each.first.second; })) found.insert({"declared", name});
    if (of.end == "begin") found.insert({"start", ""});
    underway(of.root, [&](const Node& node) {
      const Section& section = *node.at;
      if (section.block) {
        if (section.routed("timeout") && node.paused.empty()) found.insert({"timeout", section.name});
      } else if (node.run == Run::runs) {
        found.insert({"failure", section.name});
        for (const auto& [outcome, _] : section.routes)
          if (outcome.rfind("failure ", 0) == 0) found.insert({"failure", section.name, outcome.substr(8)});
        if (section.routed("timeout")) found.insert({"timeout", section.name});
        if (can_succeed(of, section)) found.insert({"success", section.name});
      }
      const auto& handlers = node.paused.empty() ? section.handlers : section.pauses[node.paused.back() - 1].handlers;
      for (const Handler& each : handlers) if (counts(of, each)) found.insert({"declared", each.event});
    });
    return found;
  }

  // The states that the mission may be in after an event.
  std::map<std::string, State> after(const State& state, const Texts& event) const { return settled(happened(state, event)); }
  std::map<std::string, State> settled(State state) const { return reaction_.settled(std::move(state)); }

  // The state after an event in which activities have not reacted yet, but for those that are idle as nobody needs them any more.
  State happened(State state, const Texts& event) const {
    const std::vector<std::string> before = state.facts;
    underway(state.root, [](Node& node) { node.fresh = false; });
    const std::string& what = event[0];
    const std::string& element = event[1];
    if (what == "out of service" || what == "repaired" || what == "detected") {
      const std::size_t h = named(core_.hardware, element);
      Part& part = state.hardware[h];
      if (what == "out of service") part = {true, !core_.hardware[h].late, false};
      else if (what == "repaired") part = {};
      else part = {true, true, false};
    } else if (what == "start") {
      state.end.clear();
      state.root.push_back(Routes::entered(*core_.graph, core_.graph->entry));
    } else if (what == "declared") {
      if (const auto found = core_.events.find(element); found != core_.events.end())
        for (std::size_t fact = 0; fact < state.facts.size(); ++fact)
          if (const auto to = found->second.find({fact, state.facts[fact]}); to != found->second.end()) state.facts[fact] = to->second;
      routes_.handled(state, element);
    } else {
      routes_.ended(state, what, element, event.size() == 3 ? "failure " + event[2] : what);
    }
    if (state.facts != before) routes_.left(state, before);
    underway(state.root, [&](Node& node) {
      if (node.fresh && !node.at->block)
        if (const auto found = node.at->sets.find("start"); found != node.at->sets.end()) set(state, found->second);
    });
    reaction_.stop(state);
    return state;
  }

 private:
  template <class List> static std::size_t named(const List& among, const std::string& name) {
    return std::size_t(std::find_if(among.begin(), among.end(), [&](const auto& each) { return each.name == name; }) - among.begin());
  }
  void done(const Node& node, std::set<Role>& found) const {
    for (std::size_t b = 0; b < node.branches.size(); ++b) {
      if (node.branches[b].end != End::none) found.emplace("done", node.at->branches[b].name);
      for (const Node& held : node.branches[b].node) done(held, found);
    }
    for (const Node& held : node.meanwhile) done(held, found);
  }
  bool can_succeed(const State& of, const Section& objective) const {
    for (const std::size_t a : objective.activities) if (of.activities[a].does != Does::runs) return false;
    return misused(of, objective).empty();
  }

  Routes routes_;
  Reaction reaction_;
};
