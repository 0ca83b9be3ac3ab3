// A state of a mission that is played: what is under way in its graph, its facts, its hardware, and what activities do.
#pragma once

#include "core.hpp"

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

inline void write(const Node& node, std::string& to) {
  to += node.at->name + '\n' + char('a' + int(node.run));
  for (const std::size_t pause : node.paused) to += std::to_string(pause) + ' ';
  for (const Held& each : node.branches) {
    to += char('0' + int(each.end));
    for (const Node& held : each.node) write(held, to);
  }
  for (const Node& held : node.meanwhile) write(held, to);
  to += ';';
}
inline std::string key_of(const State& state) {
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

inline bool so(const Facts& facts, const std::vector<std::string>& in) {
  return std::all_of(facts.begin(), facts.end(), [&](const Fact& each) { return in[each.first] == each.second; });
}
inline void set(State& state, const Facts& facts) { for (const Fact& each : facts) state.facts[each.first] = each.second; }
inline bool counts(const State& of, const Handler& handler) { return handler.once.empty() || !of.happened.count(handler.once); }

// What activities do in a state.
class Doings {
 public:
  explicit Doings(const Core& core) : core_(core) {}

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
  // Of the hardware that an objective may use what is held, and out of service without being known to be.
  std::vector<std::size_t> misused(const State& of, const Section& objective) const {
    std::vector<std::size_t> found;
    for (const std::size_t h : core_.used(objective.activities))
      if (of.hardware[h].out && !of.hardware[h].known && had(of, h)) found.push_back(h);
    return found;
  }

 protected:
  const Core& core_;
};
