// When a list of cut sets is complete and minimal, by the four rules of docs/certificates.md, whatever moments, steps and goals are.
#pragma once

#include "certificate.hpp"
#include "listing.hpp"

struct Search {
  Set moments, won;
  std::function<bool(std::size_t, const Edge&)> is_step;
};

class CutSets {
 public:
  CutSets(const Net& net, const States& states, const Clock& clock) : net_(net), states_(states), clock_(clock) {}

  bool proved(const Json& statement, const Json& survived, const Search& search) const {
    const Texts names = texts(statement.at("hardware"));
    if (!names_hardware(names)) return false;
    if (names.size() > 120) throw Limit("more than 120 hardware resources");
    std::set<Mask> cuts, lost;
    for (const Json& each : list(statement.at("cuts"))) {
      Mask made;
      if (!mask(names, texts(each), made) || is_survived(texts(each), search)) return false;
      cuts.insert(made);
    }
    for (const Json& each : list(survived)) {
      Mask made;
      if (!mask(names, texts(each.at("lost")), made) || !is_shown(each, search)) return false;
      lost.insert(made);
    }
    for (const Mask& cut : cuts) {
      for (const Mask& other : cuts) if (other != cut && within(cut, other)) return false;
      for (std::size_t i = 0; i < names.size(); ++i) {
        if (!cut[i]) continue;
        Mask less = cut;
        less[i] = false;
        if (std::none_of(lost.begin(), lost.end(), [&](const Mask& each) { return within(less, each); })) return false;
      }
    }
    std::set<Mask> kept;  // part of a set is what holds, complemented, that set's complement
    for (Mask each : lost) { each.flip(); kept.insert(each); }
    Counting up{{}, names.size(), clock_}, down{{}, names.size(), clock_};
    return up.above(0, cuts) + down.above(0, kept) == Wide(1) << names.size();
  }
  static void shape_of_survived(const Json& of) {
    for (const Json& each : list(of)) {
      keys(each, {"lost", "by", "run"}, "a set that is survived");
      texts(each.at("lost"));
      whole(each.at("by"));
      numbers(each.at("run"));
    }
  }
  bool names_hardware(const Texts& names) const {
    const std::set<std::string> once(names.begin(), names.end());
    std::set<std::string> hardware;
    for (const Place& place : net_.places) for (const Role& role : place.roles) if (role.first == "oos") hardware.insert(role.second);
    return once == hardware && once.size() == names.size();
  }
  using Mask = std::vector<bool>;
  static bool mask(const Texts& names, const Texts& of, Mask& made) {
    made.assign(names.size(), false);
    for (const std::string& name : of) {
      const std::size_t at = std::size_t(std::find(names.begin(), names.end(), name) - names.begin());
      if (at == names.size() || made[at]) return false;
      made[at] = true;
    }
    return true;
  }
  static bool within(const Mask& small, const Mask& large) {
    for (std::size_t i = 0; i < small.size(); ++i) if (small[i] && !large[i]) return false;
    return true;
  }

 private:
  struct Counting {
    std::map<std::pair<std::size_t, std::set<Mask>>, Wide> known;
    std::size_t size;
    const Clock& clock;
    // Sets of the elements from one on that hold a set of some.
    Wide above(std::size_t element, const std::set<Mask>& sets) {
      if (sets.empty()) return 0;
      if (sets.count(Mask(size))) return Wide(1) << (size - element);
      const auto key = std::make_pair(element, sets);
      if (const auto found = known.find(key); found != known.end()) return found->second;
      clock.look(known.size());
      std::set<Mask> without, with;
      for (Mask each : sets) {
        if (!each[element]) without.insert(each);
        each[element] = false;
        with.insert(each);
      }
      return known[key] = above(element + 1, without) + above(element + 1, with);
    }
  };
  bool is_moment(std::size_t s, const Texts& lost, const Search& search) const {
    return search.moments[s] && std::all_of(lost.begin(), lost.end(), [&](const std::string& name) { return states_.says(s, "oos", name); });
  }
  // A step without repairs of what is lost.
  bool is_step(std::size_t s, const Edge& edge, const Texts& lost, const Search& search) const {
    const Texts& event = net_.transitions[std::size_t(edge.transition)].event;
    return search.is_step(s, edge) && (event[0] != "repaired" || std::find(lost.begin(), lost.end(), event[1]) == lost.end());
  }
  bool is_survived(const Texts& lost, const Search& search) const {
    Set seen(states_.markings.size());
    std::vector<std::size_t> stack;
    for (std::size_t s = 0; s < seen.size(); ++s) if (is_moment(s, lost, search)) { seen[s] = true; stack.push_back(s); }
    clock_.look(0);
    while (!stack.empty()) {
      const std::size_t s = stack.back();
      stack.pop_back();
      if (search.won[s]) return true;
      for (const Edge& edge : states_.edges[s])
        if (!seen[edge.to] && is_step(s, edge, lost, search)) { seen[edge.to] = true; stack.push_back(edge.to); }
    }
    return false;
  }
  bool is_shown(const Json& entry, const Search& search) const {
    const Texts lost = texts(entry.at("lost"));
    const Numbers run = numbers(entry.at("run"));
    const std::size_t by = std::size_t(std::clamp<Int>(whole(entry.at("by")), 0, Int(run.size())));
    std::size_t s = 0;
    for (std::size_t i = 0; i <= run.size(); ++i) {
      if (i == by && !is_moment(s, lost, search)) return false;
      if (i == run.size()) break;
      const auto& out = states_.edges[s];
      const auto edge = std::find_if(out.begin(), out.end(), [&](const Edge& each) { return each.transition == run[i]; });
      if (edge == out.end() || (i >= by && !is_step(s, *edge, lost, search))) return false;
      s = edge->to;
    }
    return search.won[s];
  }

  const Net& net_;
  const States& states_;
  const Clock& clock_;
};
