// The sections of a mission's graph, each type of them played alone once, and what targets lead to.
#pragma once

#include "played.hpp"

// A section of the mission: its type, and the words of the mission for what is in it.
struct Placed {
  std::size_t type;
  Texts targets;
  std::map<std::string, std::map<std::string, std::string>> names;
  std::map<std::string, Texts> alternatives;
};

class Sections {
 public:
  Sections(const Json& json, const Core& core, const Clock& clock) : entry_(json.at("graph").at("entry").string) {
    if (!core.facts.empty() || !core.events.empty()) throw Limit("the mission has facts, or events that change some");
    for (const Hardware& each : core.hardware) if (each.late) throw Limit("a loss is noticed late");
    apart(*core.graph);
    const Equipment robot(json.at("robot"));
    std::map<std::string, std::size_t> types;
    for (const Json& each : json.at("graph").at("sections").items) {
      clock.look(states_);
      const Alone alone(each, core, robot);
      const auto [at, fresh] = types.emplace(alone.type(), types_.size());
      if (fresh) types_.push_back(std::make_unique<Played>(alone, clock, states_));
      sections_.emplace(each.at("name").string, Placed{at->second, alone.targets, alone.names, alone.alternatives});
    }
  }

  const std::string& entry() const { return entry_; }
  std::size_t count() const { return sections_.size(); }
  std::size_t types() const { return types_.size(); }
  std::size_t states() const { return states_; }
  bool has(const std::string& section) const { return sections_.count(section) > 0; }
  const Placed& placed(const std::string& section) const { return sections_.at(section); }
  const Played& type(const Placed& of) const { return *types_[of.type]; }
  bool goes_on(const std::string& section) const { return type(placed(section)).goes_on(); }

  // Sections, and ends of the mission, that some targets of each section lead to from the entry.
  template <class Targets> std::set<std::string> led(const Targets& targets) const {
    std::set<std::string> found{entry_};
    std::vector<std::string> open{entry_};
    while (!open.empty()) {
      const auto at = sections_.find(open.back());
      open.pop_back();
      if (at == sections_.end()) continue;
      const std::set<std::size_t> by = targets(at->second);
      for (const std::size_t each : by) {
        const std::string& target = at->second.targets[each];
        if (found.insert(target).second) open.push_back(target);
      }
    }
    return found;
  }
  std::set<std::string> reached() const { return led_by_type([](const Played& type) { return type.targets(); }); }
  std::set<std::string> reached_without_losses() const { return led_by_type([](const Played& type) { return type.quiet_targets(); }); }

  // These ends, and the sections from each state of which some run leads out of it to one that is good already.
  std::set<std::string> good(const std::set<std::string>& ends) const {
    std::map<std::string, std::vector<std::string>> before;
    for (const auto& [name, placed] : sections_) for (const std::string& target : placed.targets) before[target].push_back(name);
    std::map<std::pair<std::size_t, std::set<std::size_t>>, bool> known;
    std::set<std::string> found = ends;
    std::vector<std::string> open(ends.begin(), ends.end());
    while (!open.empty()) {
      const std::string next = open.back();
      open.pop_back();
      for (const std::string& section : before[next]) {
        if (found.count(section)) continue;
        const Placed& placed = sections_.at(section);
        std::set<std::size_t> targets;
        for (std::size_t i = 0; i < placed.targets.size(); ++i) if (found.count(placed.targets[i])) targets.insert(i);
        const auto [at, fresh] = known.emplace(std::make_pair(placed.type, targets), false);
        if (fresh) at->second = types_[placed.type]->always_leads_to(targets);
        if (!at->second) continue;
        found.insert(section);
        open.push_back(section);
      }
    }
    return found;
  }

 private:
  static void apart(const Graph& of) {
    const auto look = [](const std::vector<Handler>& handlers) {
      for (const Handler& each : handlers) if (!each.once.empty()) throw Limit("a handler happens once");
    };
    for (const Section& section : of.sections) {
      if (!section.left.empty()) throw Limit("a section is left as facts become so");
      look(section.handlers);
      for (const Branch& branch : section.branches) apart(*branch.graph);
      for (const Pause& pause : section.pauses) { look(pause.handlers); apart(*pause.graph); }
    }
  }
  template <class Targets> std::set<std::string> led_by_type(const Targets& targets) const {
    std::vector<std::set<std::size_t>> by_type;
    for (const auto& each : types_) by_type.push_back(targets(*each));
    return led([&](const Placed& each) { return by_type[each.type]; });
  }

  std::string entry_;
  std::size_t states_ = 0;
  std::vector<std::unique_ptr<Played>> types_;
  std::map<std::string, Placed> sections_;
};
