// A second checker of core missions beside nets, written from docs/certificates.md alone: c++ -O2 -std=c++17 core_checker.cpp -o core_checker.
//
// core_checker FILE [--max-states N] [--seconds S] prints "proved net", "refuted net" or "not checked net", and ends with 0, 1 or 2.
// Why a net is refuted or not checked is told in one sentence.
#include <optional>

#include "certificate.hpp"

struct Refuted : std::runtime_error { using runtime_error::runtime_error; };

using Fact = std::pair<std::size_t, std::string>;  // a fact has a value
using Facts = std::vector<Fact>;
const std::string kNothing;  // where nothing is left: no exit

// ---- what core.json says

struct Case { Facts when; std::string to; };
using Cases = std::vector<Case>;
struct Handler { std::string event, once; Cases to; std::size_t pauses; };
struct Left { Facts when; Cases to; };
struct Graph;
struct Branch { std::string name; bool mandatory; std::unique_ptr<Graph> graph; };
struct Pause { std::unique_ptr<Graph> graph; std::vector<Handler> handlers; };
struct Section {
  std::string name;
  bool block;
  std::map<std::string, Cases> routes;
  std::vector<Handler> handlers;
  std::vector<Left> left;
  std::vector<std::size_t> activities;  // of an objective, and what follows
  std::map<std::string, Facts> sets;
  std::vector<Branch> branches;  // of a block, and what follows
  std::vector<Pause> pauses;
  Int needed = 0, failing = 0;
  bool hasty = false;
  bool routed(const std::string& outcome) const { return routes.count(outcome) > 0; }
};
struct Graph {
  std::size_t entry = 0;
  std::vector<Section> sections;
  std::map<std::string, std::size_t> numbers;
};

struct Hardware { std::string name; bool faulty, shared, repairable, out, late, crash; };
struct Alternative { std::string name; std::set<std::size_t> hardware, consumed, producers; Facts requires_; };
struct Activity {
  std::string name;
  bool switch_back;
  std::set<std::size_t> detects, products;
  std::vector<Alternative> alternatives;
  std::size_t layer = 0;
};

class Core {
 public:
  explicit Core(const Json& of) {
    keys(of, {"format", "version", "graph", "robot"}, "core.json");
    header(of);
    robot(of.at("robot"));
    graph = made(of.at("graph"), {"succeed", "fail", "abort"});
  }

  std::unique_ptr<Graph> graph;
  std::vector<Hardware> hardware;
  std::vector<std::string> facts, initial;
  std::map<std::string, std::map<Fact, std::string>> events;  // by event, of facts with values those that they have then
  std::vector<Activity> activities;
  std::vector<bool> contended;  // resources: hardware, then software
  std::set<std::string> names;  // of sections

  // The hardware that activities, and what may produce for them at any depth, consume in some alternative.
  std::set<std::size_t> used(const std::vector<std::size_t>& of) const {
    std::set<std::size_t> found, seen;
    std::vector<std::size_t> open = of;
    while (!open.empty()) {
      const std::size_t next = open.back();
      open.pop_back();
      if (!seen.insert(next).second) continue;
      for (const Alternative& each : activities[next].alternatives) {
        found.insert(each.hardware.begin(), each.hardware.end());
        open.insert(open.end(), each.producers.begin(), each.producers.end());
      }
    }
    return found;
  }

 private:
  Facts facts_of(const Json& of) const {
    Facts found;
    for (const Json& each : list(of)) {
      const Texts pair = texts(each);
      require(pair.size() == 2, "a fact without a value");
      const auto at = fact_numbers_.find(pair[0]);
      require(at != fact_numbers_.end(), "no fact " + pair[0]);
      found.emplace_back(at->second, pair[1]);
    }
    return found;
  }

  // Changes of which none is of the same fact as another one.
  static Facts once(Facts sets) {
    std::set<std::size_t> changed;
    for (const Fact& each : sets) require(changed.insert(each.first).second, "a fact changes twice");
    return sets;
  }

  void robot(const Json& of) {
    keys(of, {"hardware", "software", "facts", "events", "activities"}, "the robot");
    for (const char* key : {"hardware", "software", "facts", "events", "activities"}) {
      std::set<std::string> names;
      for (const Json& each : list(of.at(key))) {
        require(each.kind == Json::object && each.members.count("name"), std::string("no name among ") + key);
        require(names.insert(text(each.at("name"))).second, "two of one name: " + text(each.at("name")));
      }
    }
    std::map<std::string, std::size_t> resources;
    std::vector<bool> exclusive;
    for (const Json& each : of.at("hardware").items) {
      keys(each, {"name", "faulty", "shared", "repairable", "out", "late", "crash"}, "hardware");
      hardware.push_back({text(each.at("name")), truth(each.at("faulty")), truth(each.at("shared")), truth(each.at("repairable")),
                          truth(each.at("out")), truth(each.at("late")), truth(each.at("crash"))});
      resources.emplace(hardware.back().name, exclusive.size());
      exclusive.push_back(!hardware.back().shared);
    }
    for (const Json& each : of.at("software").items) {
      keys(each, {"name", "exclusive"}, "software");
      require(resources.emplace(text(each.at("name")), exclusive.size()).second, "hardware and software of one name: " + text(each.at("name")));
      exclusive.push_back(truth(each.at("exclusive")));
    }
    for (const Json& each : of.at("facts").items) {
      keys(each, {"name", "initial"}, "a fact");
      fact_numbers_.emplace(text(each.at("name")), facts.size());
      facts.push_back(text(each.at("name")));
      initial.push_back(text(each.at("initial")));
    }
    for (const Json& each : of.at("events").items) {
      keys(each, {"name", "changes"}, "an event");
      std::map<Fact, std::string>& changes = events[text(each.at("name"))];
      for (const Json& change : list(each.at("changes"))) {
        const Texts said = texts(change);
        require(said.size() == 3, "a change that is no fact with two values");
        const auto at = fact_numbers_.find(said[0]);
        require(at != fact_numbers_.end(), "no fact " + said[0]);
        require(said[1] != said[2], "a change to the same value");
        require(changes.emplace(Fact(at->second, said[1]), said[2]).second, "a fact changes twice");
      }
    }
    std::map<std::size_t, std::size_t> producers;
    for (const Json& each : of.at("activities").items) {
      keys(each, {"name", "produces", "switch_back", "detects", "alternatives"}, "an activity");
      Activity activity{text(each.at("name")), truth(each.at("switch_back")), {}, {}, {}};
      for (const std::string& name : texts(each.at("produces"))) {
        const auto [at, fresh] = resources.emplace(name, exclusive.size());
        if (fresh) exclusive.push_back(false);
        require(at->second >= hardware.size(), "what is produced is no software: " + name);
        require(producers.emplace(at->second, activities.size()).second, "produced twice: " + name);
        activity.products.insert(at->second);
      }
      for (const std::string& name : texts(each.at("detects"))) {
        const auto at = resources.find(name);
        require(at != resources.end() && at->second < hardware.size(), "what is detected is no hardware: " + name);
        activity.detects.insert(at->second);
      }
      activity_numbers_.emplace(activity.name, activities.size());
      activities.push_back(std::move(activity));
    }
    std::vector<int> consumers(exclusive.size());
    for (std::size_t a = 0; a < activities.size(); ++a) {
      std::set<std::size_t> consumed;
      for (const Json& each : list(of.at("activities").items[a].at("alternatives"))) {
        keys(each, {"name", "consumes", "requires"}, "an alternative");
        Alternative made{text(each.at("name")), {}, {}, {}, facts_of(each.at("requires"))};
        for (const std::string& name : texts(each.at("consumes"))) {
          const auto at = resources.find(name);
          require(at != resources.end() && (at->second < hardware.size() || producers.count(at->second)),
                  "what is consumed is neither hardware nor produced: " + name);
          made.consumed.insert(at->second);
          if (at->second < hardware.size()) made.hardware.insert(at->second);
          else made.producers.insert(producers.at(at->second));
        }
        consumed.insert(made.consumed.begin(), made.consumed.end());
        activities[a].alternatives.push_back(std::move(made));
      }
      for (const std::size_t each : consumed) ++consumers[each];
    }
    for (std::size_t each = 0; each < exclusive.size(); ++each) contended.push_back(exclusive[each] && consumers[each] > 1);
    std::vector<int> known(activities.size());
    for (std::size_t a = 0; a < activities.size(); ++a) layer(a, known);
  }
  std::size_t layer(std::size_t of, std::vector<int>& known) {
    require(known[of] != 1, "needed to produce itself: " + activities[of].name);
    if (known[of] == 2) return activities[of].layer;
    known[of] = 1;
    std::size_t found = 0;
    for (const Alternative& each : activities[of].alternatives)
      for (const std::size_t producer : each.producers) found = std::max(found, layer(producer, known) + 1);
    known[of] = 2;
    return activities[of].layer = found;
  }

  Cases cases(const Json& of, const Graph& in, const std::set<std::string>& exits) const {
    Cases found;
    for (const Json& each : list(of)) {
      keys(each, {"when", "to"}, "a case");
      found.push_back({facts_of(each.at("when")), text(each.at("to"))});
      require(in.numbers.count(found.back().to) || exits.count(found.back().to), "no section and no exit: " + found.back().to);
    }
    require(!found.empty() && found.back().when.empty(), "cases without a last one that always counts");
    return found;
  }
  std::vector<Handler> handlers(const Json& of, const Graph& in, const std::set<std::string>& exits, std::size_t pauses) const {
    std::vector<Handler> found;
    for (const Json& each : list(of)) {
      keys(each, {"event", "once", "to", "pauses"}, "a handler");
      const Int pause = whole(each.at("pauses"));
      require(pause >= 0 && std::size_t(pause) <= pauses, "no such pause");
      require(!pause || list(each.at("to")).empty(), "a handler that pauses and leads elsewhere");
      require(!events.count(text(each.at("event"))), "an event changes facts and is handled: " + text(each.at("event")));
      found.push_back({text(each.at("event")), text(each.at("once")), pause ? Cases() : cases(each.at("to"), in, exits), std::size_t(pause)});
    }
    return found;
  }
  std::unique_ptr<Graph> made(const Json& of, const std::set<std::string>& exits) {
    keys(of, {"entry", "sections"}, "a graph");
    auto graph = std::make_unique<Graph>();
    for (const Json& each : list(of.at("sections"))) {
      require(each.kind == Json::object && each.members.count("name"), "a section without a name");
      require(!exits.count(text(each.at("name"))), "a section is named as an exit: " + text(each.at("name")));
      require(graph->numbers.emplace(text(each.at("name")), graph->numbers.size()).second, "two sections of one name: " + text(each.at("name")));
    }
    require(graph->numbers.count(text(of.at("entry"))), "no section " + text(of.at("entry")));
    graph->entry = graph->numbers.at(text(of.at("entry")));
    for (const Json& each : of.at("sections").items) graph->sections.push_back(section(each, *graph, exits));
    return graph;
  }
  Section section(const Json& of, const Graph& in, const std::set<std::string>& exits) {
    Section made_of;
    made_of.name = text(of.at("name"));
    require(names.insert(made_of.name).second, "two sections of one name: " + made_of.name);
    made_of.block = of.members.count("branches") > 0;
    if (made_of.block)
      keys(of, {"name", "routes", "handlers", "left", "branches", "pauses", "needed", "failing", "hasty"}, "a block");
    else
      keys(of, {"name", "routes", "handlers", "left", "activities", "sets"}, "an objective");
    require(of.at("routes").kind == Json::object, "routes that are no object");
    for (const auto& [outcome, to] : of.at("routes").members) {
      const bool fits = made_of.block || outcome == "success" || outcome == "failure" || outcome == "timeout" || outcome.rfind("failure ", 0) == 0;
      require(fits, "no objective ends by " + outcome);
      made_of.routes.emplace(outcome, cases(to, in, exits));
    }
    require(made_of.routed("success") && made_of.routed("failure"), "no route for success or failure: " + made_of.name);
    for (const Json& each : list(of.at("left"))) {
      keys(each, {"when", "to"}, "what is left");
      made_of.left.push_back({facts_of(each.at("when")), cases(each.at("to"), in, exits)});
    }
    made_of.handlers = handlers(of.at("handlers"), in, exits, made_of.block ? list(of.at("pauses")).size() : 0);
    if (!made_of.block) {
      for (const std::string& name : texts(of.at("activities"))) {
        const auto at = activity_numbers_.find(name);
        require(at != activity_numbers_.end(), "no activity " + name);
        const auto& own = made_of.activities;
        require(std::find(own.begin(), own.end(), at->second) == own.end(), "an objective runs twice " + name);
        made_of.activities.push_back(at->second);
      }
      for (const Json& each : list(of.at("sets"))) {
        const Texts set = texts(each);
        require(set.size() == 3 && (set[2] == "success" || set[2] == "failure" || set[2] == "start"), "a change of a fact that is none");
        const auto at = fact_numbers_.find(set[0]);
        require(at != fact_numbers_.end(), "no fact " + set[0]);
        made_of.sets[set[2]].emplace_back(at->second, set[1]);
        once(made_of.sets[set[2]]);
      }
      return made_of;
    }
    std::set<std::string> branches, ends{"succeed", "fail"};
    if (made_of.routed("abort")) ends.insert("abort");
    for (const Json& each : list(of.at("branches"))) {
      keys(each, {"name", "mandatory", "graph"}, "a branch");
      require(branches.insert(text(each.at("name"))).second, "two branches of one name");
      made_of.branches.push_back({text(each.at("name")), truth(each.at("mandatory")), made(each.at("graph"), ends)});
    }
    std::set<std::string> outcomes{"go on"};
    for (const auto& [outcome, _] : made_of.routes) outcomes.insert(outcome);
    for (const Json& each : list(of.at("pauses"))) {
      keys(each, {"graph", "handlers"}, "a pause");
      Pause pause{made(each.at("graph"), outcomes), {}};
      pause.handlers = handlers(each.at("handlers"), *pause.graph, outcomes, list(of.at("pauses")).size());
      made_of.pauses.push_back(std::move(pause));
    }
    made_of.needed = whole(of.at("needed"));
    made_of.failing = whole(of.at("failing"));
    made_of.hasty = truth(of.at("hasty"));
    return made_of;
  }

  std::map<std::string, std::size_t> fact_numbers_, activity_numbers_;
};

// ---- a mission as it is played

enum class Run { begins, runs, halted };
enum class End { none, well, badly, aborted };
struct Node;
struct Held { End end = End::none; std::vector<Node> node; };  // a branch
struct Node {
  const Section* at = nullptr;
  bool fresh = true;  // entered in this event
  Run run = Run::begins;  // of an objective
  std::vector<Held> branches;  // of a block
  std::vector<std::size_t> paused;  // by which pauses, one within the other
  std::vector<Node> meanwhile;  // what runs in the last one, and in the others ran before it
};

enum class Does { idle, tries, asks, runs, refused };
struct Doing {
  Does does = Does::idle;
  std::size_t alternative = 0;
  std::set<std::size_t> told;  // by which producers that they are refused
  bool has() const { return does == Does::asks || does == Does::runs; }
};
struct Part { bool out = false, known = false, suspected = false; };

struct State {
  std::string end = "begin";  // how the mission has ended, or empty
  std::vector<Node> root;
  std::vector<std::string> facts;
  std::vector<Part> hardware;
  std::vector<Doing> activities;
  std::set<std::string> happened;
};

void write(const Node& node, std::string& to) {
  to += node.at->name + '\n' + char('a' + int(node.run));
  for (const std::size_t pause : node.paused) to += std::to_string(pause) + ' ';
  for (const Held& each : node.branches) {
    to += char('0' + int(each.end));
    for (const Node& held : each.node) write(held, to);
  }
  for (const Node& held : node.meanwhile) write(held, to);
  to += ';';
}
std::string key_of(const State& state) {
  std::string made = state.end + '\n';
  for (const Node& node : state.root) write(node, made);
  for (const std::string& value : state.facts) made += value + '\n';
  for (const Part& part : state.hardware) made += char('0' + int(part.out) + 2 * int(part.known) + 4 * int(part.suspected));
  for (const Doing& each : state.activities) {
    made += char('a' + int(each.does));
    made += std::to_string(each.alternative);
    for (const std::size_t producer : each.told) made += '!' + std::to_string(producer);
  }
  for (const std::string& once : state.happened) made += once + '\n';
  return made;
}

// Calls with each section under way, blocks before what they hold.
template <class One, class Visit> void inside(One& node, const Visit& visit);
template <class One, class Visit> void underway_at(One& node, const Visit& visit) {
  visit(node);
  inside(node, visit);
}
template <class Of, class Visit> void underway(Of& nodes, const Visit& visit) {
  for (auto& node : nodes) underway_at(node, visit);
}
template <class One, class Visit> void inside(One& node, const Visit& visit) {
  if (!node.paused.empty()) return underway_at(node.meanwhile.back(), visit);
  for (auto& branch : node.branches) underway(branch.node, visit);
}

struct Moved { bool did = false; std::string exit; };

class Play {
 public:
  Play(const Core& core, const Clock& clock) : core_(core), clock_(clock) {}

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
  std::map<std::string, State> after(State state, const Texts& event) const {
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
      state.root.push_back(entered(*core_.graph, core_.graph->entry));
    } else if (what == "declared") {
      if (const auto found = core_.events.find(element); found != core_.events.end())
        for (std::size_t fact = 0; fact < state.facts.size(); ++fact)
          if (const auto to = found->second.find({fact, state.facts[fact]}); to != found->second.end()) state.facts[fact] = to->second;
      handled(state, element);
    } else {
      ended(state, what, element, event.size() == 3 ? "failure " + event[2] : what);
    }
    if (state.facts != before) left(state, before);
    underway(state.root, [&](Node& node) {
      if (node.fresh && !node.at->block)
        if (const auto found = node.at->sets.find("start"); found != node.at->sets.end()) set(state, found->second);
    });
    stop(state);
    return settled(std::move(state));
  }

 private:
  template <class List> static std::size_t named(const List& among, const std::string& name) {
    return std::size_t(std::find_if(among.begin(), among.end(), [&](const auto& each) { return each.name == name; }) - among.begin());
  }
  static bool so(const Facts& facts, const std::vector<std::string>& in) {
    return std::all_of(facts.begin(), facts.end(), [&](const Fact& each) { return in[each.first] == each.second; });
  }
  static void set(State& state, const Facts& facts) { for (const Fact& each : facts) state.facts[each.first] = each.second; }
  static bool counts(const State& of, const Handler& handler) { return handler.once.empty() || !of.happened.count(handler.once); }

  // Whether an activity with an alternative that it tries, asks or runs with is so.
  template <class Is> bool some(const State& of, const Is& is) const {
    for (std::size_t a = 0; a < of.activities.size(); ++a) {
      const Doing& doing = of.activities[a];
      if (doing.does == Does::idle || doing.does == Does::refused || doing.alternative >= core_.activities[a].alternatives.size()) continue;
      if (is(a, doing, core_.activities[a].alternatives[doing.alternative])) return true;
    }
    return false;
  }
  bool had(const State& of, std::size_t resource) const {
    return some(of, [&](std::size_t, const Doing& doing, const Alternative& its) { return doing.has() && its.consumed.count(resource); });
  }
  void done(const Node& node, std::set<Role>& found) const {
    for (std::size_t b = 0; b < node.branches.size(); ++b) {
      if (node.branches[b].end != End::none) found.emplace("done", node.at->branches[b].name);
      for (const Node& held : node.branches[b].node) done(held, found);
    }
    for (const Node& held : node.meanwhile) done(held, found);
  }
  // Of the hardware that an objective may use what is held, and out of service without being known to be.
  std::vector<std::size_t> misused(const State& of, const Section& objective) const {
    std::vector<std::size_t> found;
    for (const std::size_t h : core_.used(objective.activities))
      if (of.hardware[h].out && !of.hardware[h].known && had(of, h)) found.push_back(h);
    return found;
  }
  bool can_succeed(const State& of, const Section& objective) const {
    for (const std::size_t a : objective.activities) if (of.activities[a].does != Does::runs) return false;
    return misused(of, objective).empty();
  }

  // ---- routes

  static Node entered(const Graph& in, std::size_t section) {
    Node made;
    made.at = &in.sections[section];
    for (const Branch& branch : made.at->branches) made.branches.push_back({End::none, {entered(*branch.graph, branch.graph->entry)}});
    return made;
  }
  static std::string led(const State& state, const Graph& in, Node& node, const Cases& cases) {
    for (const Case& each : cases) {
      if (!so(each.when, state.facts)) continue;
      const auto section = in.numbers.find(each.to);
      if (section == in.numbers.end()) return each.to;
      node = entered(in, section->second);
      return kNothing;
    }
    malformed("cases of which none counts");
  }
  static std::string leave(const State& state, const Graph& in, Node& node, const std::string& outcome) {
    const auto found = node.at->routes.find(outcome);
    return led(state, in, node, found->second);
  }
  static std::string decided(const State& state, const Graph& in, Node& node) {
    const Section& block = *node.at;
    const Int count = Int(node.branches.size());
    Int open = 0, well = 0, badly = 0;
    bool aborted = false, lost = false;
    for (std::size_t b = 0; b < node.branches.size(); ++b) {
      const End end = node.branches[b].end;
      open += end == End::none;
      well += end == End::well;
      badly += end == End::badly;
      aborted = aborted || end == End::aborted;
      lost = lost || (end == End::badly && block.branches[b].mandatory);
    }
    if (aborted) return leave(state, in, node, "abort");
    if (block.needed > count ? !open && !lost : well >= block.needed) return leave(state, in, node, "success");
    if (!open || badly >= block.failing || (block.hasty && lost)) return leave(state, in, node, "failure");
    return kNothing;
  }
  static void pause(Node& node, std::size_t number) {
    const Graph& graph = *node.at->pauses[number - 1].graph;
    inside(node, [](Node& held) { if (!held.at->block) held.run = Run::halted; });
    node.paused.push_back(number);
    node.meanwhile.push_back(entered(graph, graph.entry));
  }
  static std::string after_pause(const State& state, const Graph& in, Node& node, const std::string& exit) {
    if (exit.empty()) return kNothing;
    if (exit != "go on") return leave(state, in, node, exit);
    node.paused.pop_back();
    node.meanwhile.pop_back();
    inside(node, [](Node& held) {
      if (!held.at->block) { held.run = Run::begins; held.fresh = true; }
    });
    return kNothing;
  }

  // Moves what is under way as `own` does with a section and, where what runs meanwhile does not move, `pausing` with a block that pauses; outer blocks
  // go first, or else only where nothing in them has moved.
  template <class Own, class Pausing>
  static Moved moved(State& state, const Graph& in, Node& node, bool outer, const Own& own, const Pausing& pausing) {
    if (!node.at->block) return own(in, node);
    if (outer)
      if (Moved found = own(in, node); found.did) return found;
    if (!node.paused.empty()) {
      const Pause& pause = node.at->pauses[node.paused.back() - 1];
      Moved found = moved(state, *pause.graph, node.meanwhile.back(), outer, own, pausing);
      if (!found.did) found = pausing(pause, node);
      if (!found.did) return {};
      return {true, after_pause(state, in, node, found.exit)};
    }
    bool did = false, exits = false;
    for (std::size_t b = 0; b < node.branches.size(); ++b) {
      Held& held = node.branches[b];
      if (held.end != End::none) continue;
      const Moved found = moved(state, *node.at->branches[b].graph, held.node[0], outer, own, pausing);
      did = did || found.did;
      if (found.exit.empty()) continue;
      exits = true;
      held.end = found.exit == "succeed" ? End::well : found.exit == "fail" ? End::badly : End::aborted;
      held.node.clear();
    }
    if (exits) return {true, decided(state, in, node)};
    if (did || outer) return {did, kNothing};
    return own(in, node);
  }
  template <class Own, class Pausing> void move(State& state, bool outer, const Own& own, const Pausing& pausing) const {
    if (state.root.empty()) return;
    const Moved found = moved(state, *core_.graph, state.root[0], outer, own, pausing);
    if (found.exit.empty()) return;
    state.end = found.exit == "succeed" ? "success" : found.exit == "fail" ? "failure" : "abort";
    state.root.clear();
  }

  void ended(State& state, const std::string& what, const std::string& element, const std::string& outcome) const {
    underway(state.root, [&](const Node& node) {
      if (node.at->block || node.at->name != element) return;
      if (what != "success")
        for (const std::size_t h : misused(state, *node.at)) state.hardware[h].suspected = true;
      const auto found = node.at->sets.find(what == "success" ? "success" : "failure");
      if (found != node.at->sets.end()) set(state, found->second);
    });
    const auto own = [&](const Graph& in, Node& node) -> Moved {
      const bool its = node.at->name == element && (node.at->block ? what == "timeout" && node.at->routed("timeout") && node.paused.empty() : node.run == Run::runs);
      if (!its) return {};
      return {true, leave(state, in, node, outcome)};
    };
    move(state, false, own, [](const Pause&, Node&) { return Moved(); });
  }
  void handled(State& state, const std::string& event) const {
    std::set<std::string> happen;
    const auto first = [&](const std::vector<Handler>& among) -> const Handler* {
      for (const Handler& each : among) if (each.event == event && counts(state, each)) return &each;
      return nullptr;
    };
    const auto own = [&](const Graph& in, Node& node) -> Moved {
      const Handler* found = first(node.at->handlers);
      if (!found) return {};
      if (!found->once.empty()) happen.insert(found->once);
      if (!found->pauses) return {true, led(state, in, node, found->to)};
      pause(node, found->pauses);
      return {true, kNothing};
    };
    const auto pausing = [&](const Pause& during, Node& node) -> Moved {
      const Handler* found = first(during.handlers);
      if (!found) return {};
      if (!found->once.empty()) happen.insert(found->once);
      if (!found->pauses) return {true, led(state, *during.graph, node.meanwhile.back(), found->to)};
      pause(node, found->pauses);
      return {true, kNothing};
    };
    move(state, false, own, pausing);
    state.happened.insert(happen.begin(), happen.end());
  }
  void left(State& state, const std::vector<std::string>& before) const {
    const auto own = [&](const Graph& in, Node& node) -> Moved {
      if (node.fresh) return {};
      for (const Left& each : node.at->left)
        if (so(each.when, state.facts) && !so(each.when, before)) return {true, led(state, in, node, each.to)};
      return {};
    };
    move(state, true, own, [](const Pause&, Node&) { return Moved(); });
  }

  // ---- activities

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

  void stop(State& state) const {
    std::set<std::size_t> run;
    underway(state.root, [&](const Node& node) { if (node.run == Run::runs) run.insert(node.at->activities.begin(), node.at->activities.end()); });
    for (std::size_t a = 0; a < state.activities.size(); ++a)
      if (core_.activities[a].products.empty() && !run.count(a)) idle(state.activities[a]);
    while (unneeded(state)) {}
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

  const Core& core_;
  const Clock& clock_;
};

// ---- the mission beside the net

std::set<Role> look_of(const Net& net, const Marking& marking) {
  static const std::set<std::string> ends{"begin", "success", "failure", "abort"};
  static const std::set<std::string> known{"objective", "pending", "done", "active", "wait", "refused", "oos", "known", "fact", "happened"};
  std::set<Role> found;
  for (std::size_t p = 0; p < marking.size(); ++p) {
    if (!marking[p]) continue;
    for (const auto& [role, element] : net.places[p].roles) {
      if (ends.count(role)) found.emplace(role, "");
      else if (role == "want") found.emplace("wait", element);
      else if (known.count(role)) found.emplace(role, element);
    }
  }
  return found;
}

void walk(const Net& net, const States& states, const Core& core, const Clock& clock) {
  const Play play(core, clock);
  std::vector<std::set<Role>> looks;
  for (const Marking& each : states.markings) looks.push_back(look_of(net, each));
  std::set<std::pair<std::size_t, std::string>> seen;
  std::vector<std::pair<std::size_t, State>> open;
  const auto told = [](const Texts& event) { return event[0] + " of " + event[1] + (event.size() == 3 ? " for " + event[2] : ""); };
  const auto next = [&](std::size_t s, const State& state) {
    if (!seen.emplace(s, key_of(state)).second) return;
    open.emplace_back(s, state);
  };
  if (const State first = play.first(); play.look(first) == looks[0]) next(0, first);
  else throw Refuted("state 0 does not say what the mission does before its start");
  std::size_t count = 0;
  while (!open.empty()) {
    clock.look(seen.size());
    const auto [s, state] = std::move(open.back());
    open.pop_back();
    const std::set<Texts> expected = play.events(state);
    std::set<Texts> found;
    for (const Edge& edge : states.edges[s]) {
      const Texts& event = net.transitions[std::size_t(edge.transition)].event;
      if (!found.insert(event).second) throw Refuted("state " + std::to_string(s) + " has twice " + told(event));
      if (!expected.count(event)) throw Refuted("in state " + std::to_string(s) + " there is, and may not happen, " + told(event));
    }
    for (const Texts& event : expected)
      if (!found.count(event)) throw Refuted("in state " + std::to_string(s) + " may happen, and there is not, " + told(event));
    for (const Edge& edge : states.edges[s]) {
      const Texts& event = net.transitions[std::size_t(edge.transition)].event;
      bool alike = false;
      for (const auto& [_, end] : play.after(state, event)) {
        if (play.look(end) != looks[edge.to]) continue;
        alike = true;
        next(edge.to, end);
      }
      ++count;
      if (!alike) throw Refuted("from state " + std::to_string(s) + ", to state " + std::to_string(edge.to) + ", other things come of " + told(event));
    }
  }
  std::cerr << seen.size() << " pairs of states, " << count << " events\n";
}

int checked(const std::string& path, const Clock& clock) {
  const auto files = unzipped(path);
  require(files.count("core.json") > 0, "there is no entry core.json");
  const Net net = net_of(parsed(files.at("net.json")));
  const Core core(parsed(files.at("core.json")));  // whatever is malformed is so before anything is refuted
  try {
    const States states(net, clock);
    walk(net, states, core, clock);
  } catch (const Unsafe&) {
    throw Refuted("the net is not safe");
  } catch (const NotConfluent&) {
    throw Refuted("the net is not confluent");
  }
  std::cout << "proved net\n";
  return 0;
}

int main(int count, char** words) {
  return answered(count, words, "--max-states", [](const std::string& path, const Clock& clock) {
    try {
      return checked(path, clock);
    } catch (const Refuted& error) {
      std::cout << "refuted net\n";
      std::cerr << path << ": " << error.what() << '\n';
      return 1;
    } catch (const std::exception&) {
      std::cout << "not checked net\n";
      throw;
    }
  });
}
