// The sections of a mission's graph, each type of them played alone once: their states, and the targets that they lead to.
#pragma once

#include "alone.hpp"
#include "play.hpp"

// The states of a type of sections, entered with each hardware that can be out of service.
class Played {
 public:
  Played(const Alone& alone, const Clock& clock, std::size_t& states)
      : core_(alone.core, exits_of(alone)), clock_(clock), states_(states) {
    for (const auto& [name, number] : core_.resources) core_.contended[number] = alone.contended.count(name) > 0;
    const Play play(core_, clock);
    std::vector<std::size_t> may;
    for (std::size_t h = 0; h < core_.hardware.size(); ++h) if (core_.hardware[h].faulty || core_.hardware[h].out) may.push_back(h);
    if (may.size() >= 40) throw Limit("a section with too much hardware");
    for (std::size_t set = 0; set < std::size_t(1) << may.size(); ++set) {
      State before = play.first();
      for (std::size_t i = 0; i < may.size(); ++i) before.hardware[may[i]] = set >> i & 1 ? Part{true, true, false} : Part{};
      numbered(outcome(play, play.happened(before, {"start", ""})));
    }
    start_ = numbered(outcome(play, play.happened(play.first(), {"start", ""})));
    for (std::size_t s = 0; s < open_.size(); ++s) {
      const State state = open_[s];
      ways.emplace_back();
      for (const Texts& event : play.events(state)) {
        const State after = play.happened(state, event);
        const bool quiet = event[0] != "out of service" && event[0] != "repaired";
        if (after.root.empty()) {
          const auto idle = [](const Doing& each) { return each.does == Does::idle; };
          if (!std::all_of(after.activities.begin(), after.activities.end(), idle)) throw Limit("an activity goes on as a section is left");
          outcome(play, after);
          ways[s].push_back({std::size_t(std::stoul(after_target(after))), true, quiet});
        } else {
          ways[s].push_back({numbered(outcome(play, after)), false, quiet});
        }
      }
    }
    open_.clear();
  }

  struct Way { std::size_t to; bool leaves, quiet; };
  std::vector<std::vector<Way>> ways;

  bool goes_on() const { return std::none_of(ways.begin(), ways.end(), [](const auto& each) { return each.empty(); }); }

  // The targets that some event leads to.
  std::set<std::size_t> targets() const {
    std::set<std::size_t> found;
    for (const auto& from : ways) for (const Way& way : from) if (way.leaves) found.insert(way.to);
    return found;
  }
  // Those that runs lead to on which no hardware fails and none is repaired, with hardware as it is at first.
  std::set<std::size_t> quiet_targets() const {
    std::set<std::size_t> found, seen{start_};
    std::vector<std::size_t> open{start_};
    while (!open.empty()) {
      const std::size_t s = open.back();
      open.pop_back();
      for (const Way& way : ways[s]) {
        if (!way.quiet) continue;
        if (way.leaves) found.insert(way.to);
        else if (seen.insert(way.to).second) open.push_back(way.to);
      }
    }
    return found;
  }
  // Whether from each state some run leads to one of these targets.
  bool always_leads_to(const std::set<std::size_t>& good) const {
    std::vector<std::vector<std::size_t>> before(ways.size());
    std::vector<bool> leads(ways.size());
    std::vector<std::size_t> open;
    const auto add = [&](std::size_t s) { if (!leads[s]) { leads[s] = true; open.push_back(s); } };
    for (std::size_t s = 0; s < ways.size(); ++s)
      for (const Way& way : ways[s]) {
        if (!way.leaves) before[way.to].push_back(s);
        else if (good.count(way.to)) add(s);
      }
    while (!open.empty()) {
      const std::size_t s = open.back();
      open.pop_back();
      for (const std::size_t each : before[s]) add(each);
    }
    return std::all_of(leads.begin(), leads.end(), [](bool each) { return each; });
  }

 private:
  static std::set<std::string> exits_of(const Alone& alone) {
    std::set<std::string> found;
    for (std::size_t i = 0; i < alone.targets.size(); ++i) found.insert("target" + std::to_string(i));
    return found;
  }
  static std::string after_target(const State& of) { return of.end.substr(6); }
  static State outcome(const Play& play, State of) {
    auto ends = play.settled(std::move(of));
    if (ends.size() != 1) throw Limit("an entry or an event has no outcome, or several");
    return std::move(ends.begin()->second);
  }
  std::size_t numbered(State state) {
    const auto [at, fresh] = numbers_.emplace(key_of(state), open_.size());
    if (fresh) {
      clock_.look(++states_);
      open_.push_back(std::move(state));
    }
    return at->second;
  }

  Core core_;
  const Clock& clock_;
  std::size_t& states_;
  std::size_t start_ = 0;
  std::vector<State> open_;
  std::map<std::string, std::size_t> numbers_;
};

class Sections {
 public:
  Sections(const Json& json, const Core& core, const Clock& clock) : entry_(json.at("graph").at("entry").string) {
    if (!core.facts.empty() || !core.events.empty()) throw Limit("the mission has facts, or events that change some");
    for (const Hardware& each : core.hardware) if (each.late) throw Limit("a loss is noticed late");
    apart(*core.graph);
    const Robot robot(json.at("robot"));
    std::map<std::string, std::size_t> types;
    for (const Json& each : json.at("graph").at("sections").items) {
      clock.look(states_);
      const Alone alone(each, core, robot);
      const auto [at, fresh] = types.emplace(alone.type(), types_.size());
      if (fresh) types_.push_back(std::make_unique<Played>(alone, clock, states_));
      sections_.emplace(each.at("name").string, Placed{at->second, alone.targets});
    }
  }

  std::size_t count() const { return sections_.size(); }
  std::size_t types() const { return types_.size(); }
  std::size_t states() const { return states_; }
  bool has(const std::string& section) const { return sections_.count(section) > 0; }
  bool goes_on(const std::string& section) const { return type(section).goes_on(); }

  // Sections, and ends of the mission, that targets lead to from the entry.
  std::set<std::string> reached() const { return led([](const Played& type) { return type.targets(); }); }
  std::set<std::string> reached_without_losses() const { return led([](const Played& type) { return type.quiet_targets(); }); }

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
  struct Placed { std::size_t type; Texts targets; };

  const Played& type(const std::string& section) const { return *types_[sections_.at(section).type]; }

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
  template <class Targets> std::set<std::string> led(const Targets& targets) const {
    std::vector<std::set<std::size_t>> by_type;
    for (const auto& each : types_) by_type.push_back(targets(*each));
    std::set<std::string> found{entry_};
    std::vector<std::string> open{entry_};
    while (!open.empty()) {
      const auto at = sections_.find(open.back());
      open.pop_back();
      if (at == sections_.end()) continue;
      for (const std::size_t each : by_type[at->second.type]) {
        const std::string& target = at->second.targets[each];
        if (found.insert(target).second) open.push_back(target);
      }
    }
    return found;
  }

  std::string entry_;
  std::size_t states_ = 0;
  std::vector<std::unique_ptr<Played>> types_;
  std::map<std::string, Placed> sections_;
};
