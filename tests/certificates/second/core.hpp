// What core.json says, read in C++ from docs/certificates.md alone: the graph of a mission, and its robot.
#pragma once

#include "certificate.hpp"

using Fact = std::pair<std::size_t, std::string>;  // a fact has a value
using Facts = std::vector<Fact>;

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
  explicit Core(const Json& of, const std::set<std::string>& exits = {"succeed", "fail", "abort"}) {
    keys(of, {"format", "version", "graph", "robot"}, "core.json");
    header(of);
    robot(of.at("robot"));
    graph = made(of.at("graph"), exits);
  }

  std::unique_ptr<Graph> graph;
  std::vector<Hardware> hardware;
  std::vector<std::string> facts, initial;
  std::map<std::string, std::map<Fact, std::string>> events;  // by event, of facts with values those that they have then
  std::vector<Activity> activities;
  std::map<std::string, std::size_t> resources;  // hardware, then software
  std::map<std::size_t, std::size_t> producers;  // by resource
  std::vector<bool> contended;  // by resource
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
        require(activities[at->second].products.empty(), "an objective runs what produces: " + name);
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
