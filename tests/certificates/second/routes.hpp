// How routes are followed through the graph of a mission: as sections end, as declared events are handled, and as facts become so.
#pragma once

#include "state.hpp"

const std::string kNothing;  // where nothing is left: no exit

struct Advanced { bool did = false; std::string exit; };

class Routes : Doings {
 public:
  using Doings::Doings;

  static Node entered(const Graph& in, std::size_t section) {
    Node made;
    made.at = &in.sections[section];
    for (const Branch& branch : made.at->branches) made.branches.push_back({End::none, {entered(*branch.graph, branch.graph->entry)}});
    return made;
  }
  void ended(State& state, const std::string& what, const std::string& element, const std::string& outcome) const {
    underway(state.root, [&](const Node& node) {
      if (node.at->block || node.at->name != element) return;
      if (what != "success")
        for (const std::size_t h : misused(state, *node.at)) state.hardware[h].suspected = true;
      const auto found = node.at->sets.find(what == "success" ? "success" : "failure");
      if (found != node.at->sets.end()) set(state, found->second);
    });
    const auto own = [&](const Graph& in, Node& node) -> Advanced {
      const bool its = node.at->name == element && (node.at->block ? what == "timeout" && node.at->routed("timeout") && node.paused.empty() : node.run == Run::runs);
      if (!its) return {};
      return {true, leave(state, in, node, outcome)};
    };
    move(state, false, own, [](const Pause&, Node&) { return Advanced(); });
  }
  void handled(State& state, const std::string& event) const {
    std::set<std::string> happen;
    const auto first = [&](const std::vector<Handler>& among) -> const Handler* {
      for (const Handler& each : among) if (each.event == event && counts(state, each)) return &each;
      return nullptr;
    };
    const auto own = [&](const Graph& in, Node& node) -> Advanced {
      const Handler* found = first(node.at->handlers);
      if (!found) return {};
      if (!found->once.empty()) happen.insert(found->once);
      if (!found->pauses) return {true, led(state, in, node, found->to)};
      pause(node, found->pauses);
      return {true, kNothing};
    };
    const auto pausing = [&](const Pause& during, Node& node) -> Advanced {
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
    const auto own = [&](const Graph& in, Node& node) -> Advanced {
      if (node.fresh) return {};
      for (const Left& each : node.at->left)
        if (so(each.when, state.facts) && !so(each.when, before)) return {true, led(state, in, node, each.to)};
      return {};
    };
    move(state, true, own, [](const Pause&, Node&) { return Advanced(); });
  }

 private:
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
  static Advanced moved(State& state, const Graph& in, Node& node, bool outer, const Own& own, const Pausing& pausing) {
    if (!node.at->block) return own(in, node);
    if (outer)
      if (Advanced found = own(in, node); found.did) return found;
    if (!node.paused.empty()) {
      const Pause& pause = node.at->pauses[node.paused.back() - 1];
      Advanced found = moved(state, *pause.graph, node.meanwhile.back(), outer, own, pausing);
      if (!found.did) found = pausing(pause, node);
      if (!found.did) return {};
      return {true, after_pause(state, in, node, found.exit)};
    }
    bool did = false, exits = false;
    for (std::size_t b = 0; b < node.branches.size(); ++b) {
      Held& held = node.branches[b];
      if (held.end != End::none) continue;
      const Advanced found = moved(state, *node.at->branches[b].graph, held.node[0], outer, own, pausing);
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
    const Advanced found = moved(state, *core_.graph, state.root[0], outer, own, pausing);
    if (found.exit.empty()) return;
    state.end = found.exit == "succeed" ? "success" : found.exit == "fail" ? "failure" : found.exit;
    state.root.clear();
  }
};
