// The net on sets of markings: where transitions may fire, and what they lead to.
#pragma once

#include "diagrams.hpp"

using Marked = std::vector<bool>;  // by place
const std::set<std::string> kEnds{"success", "failure", "abort"};

class Markings {
 public:
  Markings(const Net& net, const Diagrams& given, Families& families) : net_(net), given_(given), families_(families), says_(net.places.size()) {
    for (std::size_t l = 0; l < given.order.size(); ++l) says_[std::size_t(given.order[l])] = {std::uint32_t(l), true};
    for (const Partner& each : given.partners) says_[std::size_t(each.place)] = {says_[std::size_t(each.of)].level, false};
    std::map<Int, std::vector<std::size_t>> by_rank;
    for (std::size_t t = 0; t < net.transitions.size(); ++t) {
      if (net.transitions[t].internal()) by_rank[net.transitions[t].rank].push_back(t);
      else events.push_back(t);
    }
    for (auto& [_, all] : by_rank) ranks.push_back(std::move(all));
    for (std::size_t t = 0; t < net.transitions.size(); ++t) covered_.push_back(covering(net.transitions[t]));
  }

  std::vector<std::vector<std::size_t>> ranks;
  std::vector<std::size_t> events;

  bool partners_are_right() const {
    for (const Partner& each : given_.partners) {
      if (net_.places[std::size_t(each.place)].initial == net_.places[std::size_t(each.of)].initial) return false;
      for (const Transition& t : net_.transitions) if (gain(t, each.place) != -gain(t, each.of)) return false;
    }
    return true;
  }
  Node initial() const {
    Marked all;
    for (const Place& place : net_.places) all.push_back(place.initial);
    return single(all);
  }
  Node single(const Marked& marked) const {
    Node made = 1;
    for (std::size_t l = given_.order.size(); l-- > 0;)
      if (marked[std::size_t(given_.order[l])]) made = families_.node(std::uint32_t(l), 0, made);
    return made;
  }
  bool holds(Node set, const Marked& marked) const { return families_.within(single(marked), set); }

  // Those of a set in which the tokens of a transition are; of pairs, in the first ones.
  Node covered(Node set, std::size_t t, bool pairs = false) const { return covered_[t] ? families_.changed(set, doubled(*covered_[t], pairs)) : 0; }
  // The markings after a transition, of a set of those in which its tokens are.
  Node fired(Node set, std::size_t t, bool pairs = false) const { return families_.changed(set, doubled(firing(t, false), pairs)); }
  // The markings in which its tokens are and that it leads into a set.
  Node before(Node set, std::size_t t) const { return covered_[t] ? families_.changed(set, firing(t, true)) : 0; }
  // Those of a set that mark a place.
  Node marking(Node set, std::size_t place) const { return families_.changed(set, {{says_[place].level, says_[place].is ? 1 : 0, Change::as_it_came}}); }

  // Calls with each internal transition and those of a set in which it may fire; gives those that are stable.
  template <class Then> Node internally(Node set, Then then, bool pairs = false) const {
    for (const auto& rank : ranks) {
      Node taken = 0;
      for (const std::size_t t : rank) {
        const Node here = covered(set, t, pairs);
        if (here) then(t, here);
        taken = families_.any(taken, here);
      }
      set = families_.less(set, taken);
    }
    return set;
  }
  Node ending(Node set, const std::set<std::string>& roles) const {
    Node found = 0;
    for (std::size_t p = 0; p < net_.places.size(); ++p)
      if (is_end(p, roles)) found = families_.any(found, marking(set, p));
    return found;
  }
  // The level and the side of it that say whether a place is marked.
  std::pair<std::uint32_t, bool> side(std::size_t place) const { return {says_[place].level, says_[place].is}; }
  std::size_t levels() const { return given_.order.size(); }
  bool is_end(std::size_t place, const std::set<std::string>& roles) const {
    const auto& all = net_.places[place].roles;
    return std::any_of(all.begin(), all.end(), [&](const Role& role) { return roles.count(role.first) > 0; });
  }

 private:
  struct Said { std::uint32_t level = 0; bool is = true; };

  static bool has(const Numbers& all, Int place) { return std::find(all.begin(), all.end(), place) != all.end(); }
  static int gain(const Transition& t, Int place) { return int(has(t.produce, place)) - int(has(t.consume, place)); }
  // None where its tokens are never all there, for one place is marked exactly where another is not.
  std::optional<Changes> covering(const Transition& t) const {
    std::map<std::uint32_t, int> needed;
    for (const Numbers* side : {&t.consume, &t.read})
      for (const Int place : *side) {
        const Said& said = says_[std::size_t(place)];
        const auto [found, fresh] = needed.emplace(said.level, said.is ? 1 : 0);
        if (!fresh && found->second != int(said.is)) return std::nullopt;
      }
    Changes made;
    for (const auto& [level, value] : needed) made.push_back({level, value, Change::as_it_came});
    return made;
  }
  Changes firing(std::size_t t, bool back) const {
    std::map<std::uint32_t, Change> all;
    for (const Change& each : *covered_[t]) all.emplace(each.level, each);
    const Transition& of = net_.transitions[t];
    for (const Numbers* side : {&of.consume, &of.produce})  // what is produced is there, even if it was consumed
      for (const Int place : *side) {
        const Said& said = says_[std::size_t(place)];
        if (!said.is) continue;  // its partner changes in the opposite way
        Change& change = all.emplace(said.level, Change{said.level, -1, Change::as_it_came}).first->second;
        change.leaves = side == &of.produce ? Change::in : Change::out;
      }
    Changes made;
    for (auto [_, change] : all) {
      if (back && change.leaves != Change::as_it_came) {
        const int after = change.leaves == Change::in;
        change.leaves = change.needed < 0 ? Change::either : change.needed ? Change::in : Change::out;
        change.needed = after;
      }
      made.push_back(change);
    }
    return made;
  }
  static Changes doubled(Changes of, bool pairs) {
    if (pairs) for (Change& each : of) each.level *= 2;
    return of;
  }

  const Net& net_;
  const Diagrams& given_;
  Families& families_;
  std::vector<Said> says_;
  std::vector<std::optional<Changes>> covered_;
};
