// The net of a certificate, and its markings.
#pragma once

#include "command.hpp"
#include "json.hpp"

using Role = std::pair<std::string, std::string>;

struct Place { bool initial; std::set<Role> roles; };
struct Transition { Texts event; Int rank; Numbers consume, produce, read; bool internal() const { return event.empty(); } };
struct Net { std::vector<Place> places; std::vector<Transition> transitions; };

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
