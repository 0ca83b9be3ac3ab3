// The states of a net, by every order of internal firings.
#pragma once

#include "marking.hpp"

using Set = std::vector<bool>;  // of states

struct Edge { Int transition; std::size_t to; };

struct Unsafe {};
struct NotConfluent {};

class States {
 public:
  States(const Net& net, const Clock& clock) : net_(net), clock_(clock), places_(net.places.size()), known_(net.transitions.size()), seen_(places_) {
    read_net();
    Marking initial(places_);
    for (std::size_t p = 0; p < places_; ++p) if (net.places[p].initial) initial.add(p);
    std::vector<std::size_t> internal;
    for (std::size_t t = 0; t < firings_.size(); ++t) (net.transitions[t].internal() ? internal : events_).push_back(t);
    number(end_of(initial, covered_of(internal, initial)));
    for (std::size_t s = 0; s < markings.size(); ++s) {
      clock.look(markings.size());
      edges.emplace_back();
      const Marking at = markings[s];
      for (const std::size_t t : covered_of(events_, at)) edges[s].push_back({Int(t), number(behind(at, t))});
    }
  }

  std::vector<Marking> markings;
  std::vector<std::vector<Edge>> edges;

  bool says(std::size_t state, const std::string& role, const std::string& element) const {
    const auto found = roles_.find({role, element});
    return found != roles_.end() && markings[state].meets(found->second);
  }
  // The states that mark a place with one of some roles, of any element.
  Set ending(const std::set<std::string>& roles) const {
    Marking places(places_);
    for (const auto& [role, own] : roles_) if (roles.count(role.first)) places |= own;
    return marking(places);
  }
  // Those that mark one with this role of this element.
  Set saying(const std::string& role, const std::string& element) const {
    const auto found = roles_.find({role, element});
    return found == roles_.end() ? Set(markings.size()) : marking(found->second);
  }

 private:
  // What firing needs, takes and puts, the internal transitions that need what it puts, and all places that are looked at for it:
  // those that it needs or puts, and those that they need.
  struct Firing { Marking needs, takes, puts, looks; std::vector<std::size_t> wakes; };
  using Choices = std::vector<std::size_t>;

  void read_net() {
    for (std::size_t p = 0; p < places_; ++p)
      for (const Role& role : net_.places[p].roles) roles_.emplace(role, Marking(places_)).first->second.add(p);
    std::vector<std::set<std::size_t>> needing(places_);
    for (std::size_t t = 0; t < net_.transitions.size(); ++t) {
      const Transition& of = net_.transitions[t];
      Firing made{Marking(places_, of.consume), Marking(places_, of.consume), Marking(places_, of.produce), Marking(places_), {}};
      made.needs |= Marking(places_, of.read);
      firings_.push_back(std::move(made));
      for (const Numbers* side : {&of.consume, &of.read})
        for (const Int place : *side) if (of.internal()) needing[std::size_t(place)].insert(t);
    }
    for (std::size_t t = 0; t < firings_.size(); ++t) {
      Firing& of = firings_[t];
      std::set<std::size_t> woken;
      for (const Int place : net_.transitions[t].produce) woken.insert(needing[std::size_t(place)].begin(), needing[std::size_t(place)].end());
      of.wakes.assign(woken.begin(), woken.end());
      of.looks = of.needs;
      of.looks |= of.puts;
      for (const std::size_t each : of.wakes) of.looks |= firings_[each].needs;
    }
  }
  Set marking(const Marking& places) const {
    Set found(markings.size());
    for (std::size_t s = 0; s < markings.size(); ++s) found[s] = markings[s].meets(places);
    return found;
  }
  Choices covered_of(const Choices& some, const Marking& in) const {
    Choices found;
    for (const std::size_t t : some) if (in.holds(firings_[t].needs)) found.push_back(t);
    return found;
  }
  Marking fired(std::size_t t, Marking in) {
    seen_ |= firings_[t].looks;
    in -= firings_[t].takes;
    if (in.meets(firings_[t].puts)) throw Unsafe();
    return in |= firings_[t].puts;
  }
  // The internal transitions covered after a firing, of which some were before it.
  Choices covered_after(std::size_t t, const Choices& before, const Marking& in) const {
    Choices found = covered_of(before, in);
    for (const std::size_t each : covered_of(firings_[t].wakes, in))
      if (std::find(found.begin(), found.end(), each) == found.end()) found.push_back(each);
    return found;
  }
  // The end behind an event. It changes alike where all is alike that firings have looked at, whatever orders they came in.
  Marking behind(const Marking& from, std::size_t t) {
    for (const auto& [seen, ends] : known_[t]) {
      Marking alike = from;
      alike &= seen;
      const auto found = ends.find(alike);
      if (found == ends.end()) continue;
      Marking end = from;
      end -= seen;
      return end |= found->second;
    }
    seen_ = Marking(places_);
    const Marking after = fired(t, from);
    const Marking end = end_of(after, covered_after(t, {}, after));
    auto at = std::find_if(known_[t].begin(), known_[t].end(), [&](const auto& each) { return each.first == seen_; });
    if (at == known_[t].end()) at = known_[t].insert(at, {seen_, {}});
    Marking alike = from, changed = end;
    at->second.emplace(alike &= seen_, changed &= seen_);
    return end;
  }
  // Every order of internal firings is followed, depth first; some are covered at first.
  Marking end_of(const Marking& from, Choices covered) {
    using Ends = std::unordered_map<Marking, const Marking*, Marking::Hash>;  // the end is one of the keys, or none under way
    struct Frame { Ends::value_type& at; Choices covered, left; const Marking* end; };
    Ends ends;
    std::vector<Frame> stack;
    const auto enter = [&](Marking at, Choices internal) -> const Marking* {
      const auto [found, fresh] = ends.emplace(std::move(at), nullptr);
      if (!fresh && !found->second) throw NotConfluent();
      if (!fresh) return found->second;
      if (internal.empty()) return found->second = &found->first;
      clock_.look(markings.size() + ends.size());
      Int least = net_.transitions[internal[0]].rank;
      for (const std::size_t t : internal) least = std::min(least, net_.transitions[t].rank);
      Choices next;
      for (const std::size_t t : internal) if (net_.transitions[t].rank == least) next.push_back(t);
      stack.push_back({*found, std::move(internal), std::move(next), nullptr});
      return nullptr;
    };
    const Marking* known = enter(from, std::move(covered));
    while (!stack.empty()) {
      Frame& top = stack.back();
      if (known) {
        if (top.end && *top.end != *known) throw NotConfluent();
        top.end = known;
        known = nullptr;
      }
      if (top.left.empty()) {
        known = top.at.second = top.end;
        stack.pop_back();
        continue;
      }
      const std::size_t t = top.left.back();
      top.left.pop_back();
      Marking next = fired(t, top.at.first);
      Choices after = covered_after(t, top.covered, next);
      known = enter(std::move(next), std::move(after));
    }
    return *known;
  }
  std::size_t number(const Marking& of) {
    const auto [found, fresh] = numbers_.emplace(of, markings.size());
    if (fresh) markings.push_back(of);
    return found->second;
  }

  const Net& net_;
  const Clock& clock_;
  std::size_t places_;
  Choices events_;
  std::vector<Firing> firings_;
  std::map<Role, Marking> roles_;
  std::unordered_map<Marking, std::size_t, Marking::Hash> numbers_;
  // By event, where the same was looked at: what was there, and what is there in the end.
  std::vector<std::vector<std::pair<Marking, std::unordered_map<Marking, Marking, Marking::Hash>>>> known_;
  Marking seen_;
};
