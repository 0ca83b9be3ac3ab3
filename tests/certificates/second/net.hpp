// The net of a certificate, and its states, by every order of internal firings.
#pragma once

#include "command.hpp"
#include "json.hpp"

using Marking = std::vector<bool>;
using Set = std::vector<bool>;  // of states
using Role = std::pair<std::string, std::string>;

struct Place { bool initial; std::set<Role> roles; };
struct Transition { Texts event; Int rank; Numbers consume, produce, read; bool internal() const { return event.empty(); } };
struct Net { std::vector<Place> places; std::vector<Transition> transitions; };
struct Edge { Int transition; std::size_t to; };

struct Unsafe {};
struct NotConfluent {};

inline void header(const Json& of) {
  require(text(of.at("format")) == "mcpn-certificate" && whole(of.at("version")) == 1, "another format or version");
}

inline Texts event_of(const Json& of) {
  Texts event = texts(of);
  require(event.empty() || event.size() == 2 || event.size() == 3, "an event that is none");
  return event;
}

inline Net net_of(const Json& of) {
  keys(of, {"format", "version", "places", "transitions"}, "net.json");
  header(of);
  Net net;
  std::set<std::string> names;
  for (const Json& each : list(of.at("places"))) {
    keys(each, {"name", "initial", "roles"}, "a place");
    require(names.insert(text(each.at("name"))).second, "two places of one name");
    const Int initial = whole(each.at("initial"));
    require(initial == 0 || initial == 1, "another initial marking than 0 or 1");
    Place place{initial == 1, {}};
    for (const Json& role : list(each.at("roles"))) {
      const Texts pair = texts(role);
      require(pair.size() == 2, "a role that is no pair");
      place.roles.emplace(pair[0], pair[1]);
    }
    net.places.push_back(std::move(place));
  }
  names.clear();
  for (const Json& each : list(of.at("transitions"))) {
    keys(each, {"name", "event", "rank", "consume", "produce", "read"}, "a transition");
    require(names.insert(text(each.at("name"))).second, "two transitions of one name");
    Transition made{event_of(each.at("event")), whole(each.at("rank")), {}, {}, {}};
    require(made.internal() || made.rank == 0, "an event with a rank");
    const auto side = [&](const char* key) {
      Numbers found = numbers(each.at(key));
      std::set<Int> once(found.begin(), found.end());
      require(once.size() == found.size(), "a place twice");
      require(found.empty() || (*once.begin() >= 0 && *once.rbegin() < Int(net.places.size())), "no such place");
      return found;
    };
    made.consume = side("consume");
    made.produce = side("produce");
    made.read = side("read");
    require(!made.internal() || !made.consume.empty() || !made.read.empty(), "an internal transition that nothing enables");
    net.transitions.push_back(std::move(made));
  }
  return net;
}

class States {
 public:
  States(const Net& net, const Clock& clock) : net_(net), clock_(clock) {
    Marking initial;
    for (const Place& place : net.places) initial.push_back(place.initial);
    number(end_of(initial));
    for (std::size_t s = 0; s < markings.size(); ++s) {
      clock.look(markings.size() + ends_.size());
      edges.emplace_back();
      for (std::size_t t = 0; t < net.transitions.size(); ++t) {
        if (net.transitions[t].internal() || !covered(net.transitions[t], markings[s])) continue;
        const Marking end = end_of(fired(net.transitions[t], markings[s]));
        edges[s].push_back({Int(t), number(end)});
      }
    }
  }

  std::vector<Marking> markings;
  std::vector<std::vector<Edge>> edges;

  bool says(std::size_t state, const std::string& role, const std::string& element) const {
    return marks(state, [&](const Role& found) { return found.first == role && found.second == element; });
  }
  bool ends(std::size_t state, const std::set<std::string>& roles) const {
    return marks(state, [&](const Role& found) { return roles.count(found.first) > 0; });
  }

 private:
  template <class Is> bool marks(std::size_t state, Is is) const {
    for (std::size_t p = 0; p < net_.places.size(); ++p)
      if (markings[state][p] && std::any_of(net_.places[p].roles.begin(), net_.places[p].roles.end(), is)) return true;
    return false;
  }
  static bool covered(const Transition& t, const Marking& in) {
    const auto marked = [&](Int place) { return bool(in[std::size_t(place)]); };
    return std::all_of(t.consume.begin(), t.consume.end(), marked) && std::all_of(t.read.begin(), t.read.end(), marked);
  }
  static Marking fired(const Transition& t, Marking in) {
    for (const Int place : t.consume) in[std::size_t(place)] = false;
    for (const Int place : t.produce) {
      if (in[std::size_t(place)]) throw Unsafe();
      in[std::size_t(place)] = true;
    }
    return in;
  }
  std::vector<std::size_t> permitted(const Marking& in) const {
    std::vector<std::size_t> found;
    for (std::size_t t = 0; t < net_.transitions.size(); ++t) {
      const Transition& one = net_.transitions[t];
      if (!one.internal() || !covered(one, in)) continue;
      if (!found.empty() && one.rank < net_.transitions[found[0]].rank) found.clear();
      if (found.empty() || one.rank == net_.transitions[found[0]].rank) found.push_back(t);
    }
    return found;
  }
  // Every order of internal firings is followed, depth first.
  Marking end_of(const Marking& from) {
    struct Frame { Marking at; std::vector<std::size_t> left; std::unique_ptr<Marking> end; };
    std::set<Marking> underway;
    std::vector<Frame> stack;
    Marking result;
    const auto enter = [&](const Marking& at) {
      if (const auto known = ends_.find(at); known != ends_.end()) { result = known->second; return true; }
      if (underway.count(at)) throw NotConfluent();
      std::vector<std::size_t> next = permitted(at);
      if (next.empty()) { result = at; return true; }
      clock_.look(ends_.size() + underway.size());
      underway.insert(at);
      stack.push_back({at, std::move(next), nullptr});
      return false;
    };
    bool known = enter(from);
    while (!stack.empty()) {
      Frame& top = stack.back();
      if (known) {
        if (top.end && *top.end != result) throw NotConfluent();
        if (!top.end) top.end = std::make_unique<Marking>(result);
        known = false;
      }
      if (top.left.empty()) {
        result = *top.end;
        ends_.emplace(top.at, result);
        underway.erase(top.at);
        stack.pop_back();
        known = true;
        continue;
      }
      const std::size_t t = top.left.back();
      top.left.pop_back();
      known = enter(fired(net_.transitions[t], top.at));
    }
    return result;
  }
  std::size_t number(const Marking& of) {
    const auto [found, fresh] = numbers_.emplace(of, markings.size());
    if (fresh) markings.push_back(of);
    return found->second;
  }

  const Net& net_;
  const Clock& clock_;
  std::unordered_map<Marking, Marking> ends_;
  std::unordered_map<Marking, std::size_t> numbers_;
};
