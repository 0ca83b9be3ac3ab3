// Minimal cut sets before the mission starts, proved by sets of markings.
#pragma once

#include "closures.hpp"

class DiagramCuts : Closures {
 public:
  using Closures::Closures;

  bool are_cut_sets(bool holds, const Json& statement, const Json& evidence) {
    const Texts names = texts(statement.at("hardware")), ends = texts(statement.at("ends"));
    const std::set<std::string> goal(ends.begin(), ends.end()), all(names.begin(), names.end());
    const auto closed = layers_of(evidence.at("closed"), given_.nodes), layers = layers_of(evidence.at("layers"), given_.nodes);
    const auto out = out_of_service(names);
    const auto& cuts = list(statement.at("cuts"));
    if (!holds || !out || closed.size() != cuts.size()) return false;
    const Node before = markings_.ending(markings_.internally(given_.reached, [](std::size_t, Node) {}), {"begin"});
    std::vector<std::set<std::uint32_t>> lost;  // as levels
    for (std::size_t i = 0; i < closed.size(); ++i) {
      const Texts cut = texts(cuts[i]);
      const std::set<std::string> once(cut.begin(), cut.end());
      Node starts = before;
      lost.emplace_back();
      for (const std::string& name : cut) {
        if (!all.count(name)) return false;
        starts = markings_.marking(starts, out->at(name));
        lost.back().insert(markings_.side(out->at(name)).first);
      }
      if (once.size() != cut.size() || !families_.within(starts, closed[i]) || !is_closed_but(closed[i], once) || markings_.ending(closed[i], goal)) return false;
    }
    std::vector<std::size_t> unrepaired;
    for (const std::size_t t : markings_.events) if (net_.transitions[t].event[0] != "repaired") unrepaired.push_back(t);
    if (!lead_to(layers, goal, unrepaired)) return false;
    const Node survived = parts(families_.both(begun(), layers.empty() ? 0 : layers.back()), *out);
    Node every = 1, holding = 0;
    for (auto level : levels_of(*out)) every = families_.node(level, every, every);
    for (const auto& cut : lost) {
      for (const std::uint32_t level : cut) {
        std::set<std::uint32_t> less = cut;
        less.erase(level);
        if (!families_.within(set_of(less), survived)) return false;
      }
      Node above = 1;
      for (auto level : levels_of(*out)) above = families_.node(level, cut.count(level) ? 0 : above, above);
      holding = families_.any(holding, above);
    }
    return families_.any(holding, survived) == every;  // nothing is in both
  }

 private:
  bool repairs(std::size_t t, const std::set<std::string>& of) const {
    const Texts& event = net_.transitions[t].event;
    return event.size() > 1 && event[0] == "repaired" && of.count(event[1]) > 0;
  }
  // By element the place that says that it is out of service; none where this is no list of all, or they share places.
  std::optional<std::map<std::string, std::size_t>> out_of_service(const Texts& names) const {
    std::map<std::string, std::size_t> found;
    std::set<std::uint32_t> levels;
    for (std::size_t p = 0; p < net_.places.size(); ++p)
      for (const Role& role : net_.places[p].roles)
        if (role.first == "oos" && (!found.emplace(role.second, p).second || !levels.insert(markings_.side(p).first).second)) return std::nullopt;
    const std::set<std::string> once(names.begin(), names.end());
    if (once.size() != names.size() || once.size() != found.size()) return std::nullopt;
    for (const std::string& name : names) if (!found.count(name)) return std::nullopt;
    return found;
  }
  bool is_closed_but(Node set, const std::set<std::string>& repaired) const {
    bool closed = true;
    firing(set, [&](std::size_t t, Node here) { closed = closed && (repairs(t, repaired) || families_.within(markings_.fired(here, t), set)); });
    return closed;
  }
  Node settled(Node set, const std::set<std::size_t>& may) const {
    for (Node all = set;;) {
      Node more = all;
      const Node stable = markings_.internally(all, [&](std::size_t t, Node here) { if (may.count(t)) more = families_.any(more, markings_.fired(here, t)); });
      if (more == all) return stable;
      all = more;
    }
  }
  // The stable markings that are reached before the start, by what takes nothing from a place with the role begin.
  Node begun() const {
    std::set<std::size_t> may;
    for (std::size_t t = 0; t < net_.transitions.size(); ++t) {
      const Numbers& taken = net_.transitions[t].consume;
      if (std::none_of(taken.begin(), taken.end(), [&](Int place) { return markings_.is_end(std::size_t(place), {"begin"}); })) may.insert(t);
    }
    for (Node found = settled(markings_.initial(), may);;) {
      Node more = found;
      for (const std::size_t t : markings_.events)
        if (may.count(t)) more = families_.any(more, settled(markings_.fired(markings_.covered(more, t), t), may));
      if (more == found) return markings_.ending(found, {"begin"});
      found = more;
    }
  }
  // The levels of hardware, the last one first.
  static std::vector<std::uint32_t> levels_of_all(const std::set<std::uint32_t>& all) { return {all.rbegin(), all.rend()}; }
  std::vector<std::uint32_t> levels_of(const std::map<std::string, std::size_t>& out) const {
    std::set<std::uint32_t> all;
    for (const auto& [_, place] : out) all.insert(markings_.side(place).first);
    return levels_of_all(all);
  }
  Node set_of(const std::set<std::uint32_t>& levels) const {
    Node made = 1;
    for (auto level : levels_of_all(levels)) made = families_.node(level, 0, made);
    return made;
  }
  // What hardware is out of service in some markings, and every part of that.
  Node parts(Node set, const std::map<std::string, std::size_t>& out) const {
    std::map<std::uint32_t, bool> sides;
    for (const auto& [_, place] : out) sides.insert(markings_.side(place));
    for (std::uint32_t level = 0; level < markings_.levels(); ++level) {
      const Node with = families_.part(set, level, true), without = families_.part(set, level, false);
      const auto side = sides.find(level);
      if (side == sides.end()) { set = families_.any(with, without); continue; }
      const Node lost = side->second ? with : without;
      set = families_.any(families_.any(with, without), families_.changed(lost, {{level, -1, Change::in}}));
    }
    return set;
  }
};
