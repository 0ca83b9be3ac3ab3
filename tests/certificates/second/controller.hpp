// A controller as it runs, of tables or of rules: what it is in, what that says, and what an event does to it.
#pragma once

#include <tuple>

#include "rules.hpp"

struct Position {
  std::string phase = "begin";  // or the name of a section after "in ", or an end
  Int state = 0;  // of a table
  Bits bits;  // of rules
  Names gone, happened, held;
  bool operator<(const Position& other) const {
    return std::tie(phase, state, bits, gone, happened, held) < std::tie(other.phase, other.state, other.bits, other.gone, other.happened, other.held);
  }
};

struct Order { std::string verb, activity, alternative, hardware, objective; };
struct Moved { Position to; std::vector<std::vector<Order>> orders; std::string outcome = {}; };  // by which outcome a section is left
struct NotEntered : Refuted { NotEntered() : Refuted("a section that cannot be entered") {} };
struct Shown { Names objectives, pending, done, refused, waiting; Modes mode; };

inline std::string started_with(const std::string& text, const std::string& suffix) {
  if (text.size() <= suffix.size() || text.compare(text.size() - suffix.size(), suffix.size(), suffix) != 0) return "";
  return text.substr(0, text.size() - suffix.size());
}

inline std::string event_text(const Texts& event) {
  static const Modes tails{{"success", "_EV_OK"}, {"failure", "_EV_FAIL"}, {"timeout", "_EV_TIMEOUT"}};
  static const Modes hardware{{"out of service", "_EV_OOS"}, {"repaired", "_EV_RD"}, {"detected", "_EV_DETECTED"}};
  if (event[0] == "start") return "MISSION_EV_START";
  if (const auto tail = tails.find(event[0]); tail != tails.end())
    return "OBJ_" + event[1] + tail->second + (event.size() == 3 ? "_" + event[2] : "");
  if (const auto tail = hardware.find(event[0]); tail != hardware.end()) return event[1] + tail->second;
  return event[1];
}

class Controller {
 public:
  explicit Controller(Json document) : of(std::move(document)) {
    require(of.kind == Json::object, "a controller that is no object");
    require(text(of.at("format")) == "mcpn-controller" && whole(of.at("version")) == 1, "another format or version");
    for (const Json& each : list(of.at("sections"))) {
      require(sections_.emplace(text(each.at("name")), &each).second, "two sections of one name");
      item(of.at("types"), whole(each.at("type")));
    }
    for (const Json& each : list(of.at("types"))) {
      if (text(of.at("form")) == "modular") {
        rules_.emplace_back(each);
        continue;
      }
      edges_.emplace_back();
      for (const Json& edge : list(each.at("edges"))) {
        edges_.back()[{whole(edge.at("from")), whole(edge.at("event"))}].push_back(&edge);
        for (const char* key : {"open", "happened"}) within(edge.at(key), each.at("once"));
        for (const char* key : {"gained", "lost"}) within(edge.at(key), each.at("facts"));
      }
      for (const Json& entry : list(each.at("entries")))
        if (entry.kind != Json::null)
          for (const char* key : {"gained", "lost"}) within(entry.at(key), each.at("facts"));
    }
    hardware = names_in(of.at("hardware"));
    unrepairable = names_in(of.at("unrepairable"));
    crashing = names_in(of.at("crashing"));
    const Names causes = names_in(of.at("common_causes"));
    for (const std::string& each : names_in(of.at("all_hardware"))) if (!crashing.count(each) && !causes.count(each)) held.insert(each);
    for (const auto& [name, said] : of.at("late").members) late[name] = text(said);
    for (const auto& [name, each] : of.at("activities").members)
      for (const std::string& software : texts(each.at("produces"))) makers[software].insert(name);
    const Names hardware_of_all = names_in(of.at("all_hardware"));
    for (const auto& [_, each] : of.at("activities").members)
      for (const auto& [__, way] : each.at("alternatives").members)
        for (const std::string& consumed : texts(way.at("consumes")))
          require(hardware_of_all.count(consumed) || makers.count(consumed), "neither hardware nor produced: " + consumed);
    for (const auto& [name, each] : of.at("objectives").members)
      if (each.at("timeout").kind != Json::null) timed[name] = {};
    if (of.members.count("blocks"))
      for (const auto& [name, each] : of.at("blocks").members) timed[name] = names_in(each.at("objectives"));
  }

  Position first() const {
    Position at;
    at.gone = names_in(of.at("out_of_service"));
    for (const auto& [name, said] : late)
      if (at.gone.count(name)) at.held.insert(said);
    return at;
  }

  const Json* section(const Position& at) const {
    if (at.phase.rfind("in ", 0) != 0) return nullptr;
    const auto found = sections_.find(at.phase.substr(3));
    require(found != sections_.end(), "a section that is not there");
    return found->second;
  }

  Shown shown(const Position& at) const {
    Shown made;
    const Json* in = section(at);
    if (!in) return made;
    if (const Rules* of_type = rules(*in)) {
      agree(of_type->status(at.bits) == status(*in, at), "a state's bits say something else of hardware, handlers or facts");
      of_type->shown(at.bits, [&](const std::string& kind, const std::string& name) { shows(made, *in, kind, name); });
      return made;
    }
    const Json& state = item(type(*in).at("states"), at.state);
    Names out;
    for (const std::string& each : renamed_all(*in, "hardware", type(*in).at("hardware"))) if (at.gone.count(each)) out.insert(each);
    agree(renamed_all(*in, "hardware", state.at("out_of_service")) == out, "a state says that other hardware is out of service");
    made.objectives = renamed_all(*in, "objectives", state.at("objectives"));
    made.pending = renamed_all(*in, "objectives", state.at("pending"));
    made.done = renamed_all(*in, "objectives", state.at("done"));
    made.refused = renamed_all(*in, "activities", state.at("refused"));
    for (const auto& [activity, alternative] : state.at("mode").members) {
      const std::string whole_name = renamed(*in, "alternatives", activity + "." + text(alternative));
      const std::size_t dot = whole_name.find('.');
      require(dot != std::string::npos, "an alternative of nothing");
      made.mode[whole_name.substr(0, dot)] = whole_name.substr(dot + 1);
    }
    for (const auto& [activity, alternative] : state.at("waiting").members)
      made.waiting.insert(renamed(*in, "alternatives", activity + "." + text(alternative)));
    return made;
  }

  // The events that may be possible: of hardware, of the section, and of facts.
  Names known_events(const Position& at) const {
    Names found{"MISSION_EV_START"};
    for (const std::string& name : hardware) { found.insert(name + "_EV_OOS"); found.insert(name + "_EV_RD"); }
    for (const auto& [event, _] : of.at("changing").members) found.insert(event);
    if (const Json* in = section(at))
      for (const std::string& event : texts(in->at("events"))) found.insert(event);
    return found;
  }

  // What an event does; nothing where it cannot be taken.
  std::unique_ptr<Moved> after(const Position& at, const std::string& event) const {
    auto made = within_section(at, event);
    if (made && !made->outcome.empty()) enter(*made, route(*section(at), made->outcome));
    return made;
  }
  // The same, but that a section that is left leads nowhere yet.
  std::unique_ptr<Moved> within_section(const Position& at, const std::string& event) const {
    auto made = std::make_unique<Moved>();
    Position& to = made->to = at;
    if (event == "MISSION_EV_START") {
      if (at.phase != "begin") return nullptr;
      enter(*made, text(of.at("initial")));
      return made;
    }
    const std::string lost = started_with(event, "_EV_OOS"), back = started_with(event, "_EV_RD");
    const bool loses = hardware.count(lost) > 0, repairs = hardware.count(back) > 0;
    const bool was = at.gone.count(loses ? lost : back) > 0;
    if (loses) to.gone.insert(lost);
    if (repairs) to.gone.erase(back);
    if (const Json* in = section(at)) {  // what a section has is its own: nothing else is asked, and nothing else changes
      const Texts own = texts(in->at("events"));
      if (const auto found = std::find(own.begin(), own.end(), event); found != own.end()) return taken(std::move(made), *in, at, found - own.begin());
    }
    if (loses) return was || crashing.count(lost) ? nullptr : std::move(made);
    if (repairs) {
      if (!was || unrepairable.count(back)) return nullptr;
      const auto known = late.find(back);
      return known != late.end() && !to.held.erase(known->second) ? nullptr : std::move(made);
    }
    const auto changes = of.at("changing").members.find(event);
    if (changes == of.at("changing").members.end()) return nullptr;
    for (const std::string& each : texts(changes->second.at("true"))) to.held.insert(each);
    for (const std::string& each : texts(changes->second.at("false"))) to.held.erase(each);
    return to.held == at.held ? nullptr : std::move(made);
  }

  // Where a section's outcome leads.
  static std::string route(const Json& in, const std::string& outcome) {
    const auto found = in.at("routes").members.find(outcome);
    require(found != in.at("routes").members.end(), "an outcome without a route");
    return text(found->second);
  }
  void enter(Moved& made, const std::string& name) const {
    static const Modes ends{{"succeed", "success"}, {"fail", "failure"}, {"abort", "abort"}};
    made.to.state = 0;
    made.to.bits.clear();
    const auto found = sections_.find(name);
    if (found == sections_.end()) {
      const auto end = ends.find(name);
      require(end != ends.end(), "a route to nothing");
      made.to.phase = end->second;
      return;
    }
    const Json& in = *found->second;
    if (const Rules* of_type = rules(in)) {
      const auto by = of_type->entered(of_type->idle(status(in, made.to)));
      if (!by) throw NotEntered();
      agree(by->outcome.empty(), "a section that is left as it is entered");
      made.to.phase = "in " + name;
      ruled(made, in, *by);
      return;
    }
    std::size_t number = 0, bit = 0;
    for (const std::string& each : texts(type(in).at("hardware")))
      number |= std::size_t(made.to.gone.count(renamed(in, "hardware", each))) << bit++;
    const Texts facts = texts(type(in).at("facts"));
    for (Int i = 0; i < whole(type(in).at("entering")); ++i)
      number |= std::size_t(made.to.held.count(renamed(in, "facts", facts.at(std::size_t(i))))) << bit++;
    require(bit < 40, "an entry of too many bits");
    const Json& entry = item(type(in).at("entries"), Int(number));
    if (entry.kind == Json::null) throw NotEntered();
    made.to.phase = "in " + name;
    made.to.state = whole(entry.at("to"));
    item(type(in).at("states"), made.to.state);
    changed(made.to, in, entry);
    made.orders.push_back(orders(in, entry.at("actions")));
  }

  const Json* section_named(const std::string& name) const {
    const auto found = sections_.find(name);
    return found == sections_.end() ? nullptr : found->second;
  }
  const Json& type(const Json& section) const { return item(of.at("types"), whole(section.at("type"))); }

  Json of;
  Names hardware, unrepairable, crashing, held;  // what activities hold, which is neither a cause of failures nor a crash
  std::map<std::string, std::string> late;
  std::map<std::string, Names> makers, timed;

 private:
  static void within(const Json& some, const Json& all) {
    const Names there = names_in(all);
    for (const std::string& each : texts(some)) require(there.count(each) > 0, "a handler or a fact that the type has not: " + each);
  }
  // The rules of a section, if it has no table.
  const Rules* rules(const Json& section) const { return rules_.empty() ? nullptr : &rules_.at(std::size_t(whole(section.at("type")))); }
  // What is so of a section's hardware, handlers and facts.
  std::vector<bool> status(const Json& in, const Position& at) const {
    std::vector<bool> made;
    for (const std::string& each : texts(type(in).at("hardware"))) made.push_back(at.gone.count(renamed(in, "hardware", each)) > 0);
    for (const std::string& each : texts(type(in).at("once"))) made.push_back(at.happened.count(renamed(in, "once", each)) > 0);
    for (const std::string& each : texts(type(in).at("facts"))) made.push_back(at.held.count(renamed(in, "facts", each)) > 0);
    return made;
  }
  static void shows(Shown& made, const Json& in, const std::string& kind, const std::string& name) {
    if (kind == "objectives" || kind == "pending" || kind == "done") {
      (kind == "objectives" ? made.objectives : kind == "pending" ? made.pending : made.done).insert(renamed(in, "objectives", name));
    } else if (kind == "refused") {
      made.refused.insert(renamed(in, "activities", name));
    } else if (kind == "waiting") {
      made.waiting.insert(renamed(in, "alternatives", name));
    } else {
      require(kind == "mode", "something of no kind is shown");
      const std::string own = renamed(in, "alternatives", name);
      const std::size_t dot = own.find('.');
      require(dot != std::string::npos, "an alternative of nothing");
      agree(made.mode.emplace(own.substr(0, dot), own.substr(dot + 1)).second, "an activity runs in two ways");
    }
  }
  // Takes what rules have made of a section's state, and what it says then of handlers and facts.
  void ruled(Moved& made, const Json& in, const Ruled& by) const {
    made.to.bits = by.bits;
    const std::vector<bool> so = rules(in)->status(by.bits);
    std::size_t at = list(type(in).at("hardware")).size();
    for (const std::string& each : texts(type(in).at("once")))
      if (so[at++]) made.to.happened.insert(renamed(in, "once", each));
    for (const std::string& each : texts(type(in).at("facts"))) {
      const std::string name = renamed(in, "facts", each);
      if (so[at++]) made.to.held.insert(name);
      else made.to.held.erase(name);
    }
    made.orders.emplace_back();
    for (const Json* each : by.actions) made.orders.back().push_back(order(in, *each));
  }

  std::unique_ptr<Moved> taken(std::unique_ptr<Moved> made, const Json& in, const Position& at, Int event) const {
    if (const Rules* of_type = rules(in)) {
      const auto by = of_type->after(at.bits, event);
      if (!by) return nullptr;
      ruled(*made, in, *by);
      made->outcome = by->outcome;
      return made;
    }
    const Json* edge = nullptr;
    const auto& edges = edges_.at(std::size_t(whole(in.at("type"))));
    const auto some = edges.find({at.state, event});
    if (some == edges.end()) return nullptr;
    for (const Json* one : some->second) {
      const Json& each = *one;
      const Names open = renamed_all(in, "once", each.at("open")), happened = renamed_all(in, "once", each.at("happened"));
      const auto is = [&](const std::string& name) { return at.happened.count(name) > 0; };
      if (std::any_of(open.begin(), open.end(), is) || !std::all_of(happened.begin(), happened.end(), is)) continue;
      agree(!edge, "two edges of one event can be taken");
      edge = &each;
    }
    if (!edge) return nullptr;
    Position& to = made->to;
    for (const std::string& name : renamed_all(in, "once", edge->at("open"))) to.happened.insert(name);
    changed(to, in, *edge);
    made->orders.push_back(orders(in, edge->at("actions")));
    if (edge->at("to").kind != Json::text) {
      to.state = whole(edge->at("to"));
      item(type(in).at("states"), to.state);
      return made;
    }
    made->outcome = edge->at("to").string;
    agree(!made->outcome.empty(), "an outcome without a name");
    return made;
  }

  static void changed(Position& to, const Json& in, const Json& by) {
    for (const std::string& name : renamed_all(in, "facts", by.at("gained"))) to.held.insert(name);
    for (const std::string& name : renamed_all(in, "facts", by.at("lost"))) to.held.erase(name);
  }

  static std::vector<Order> orders(const Json& in, const Json& of_edge) {
    std::vector<Order> made;
    for (const Json& each : list(of_edge)) made.push_back(order(in, each));
    return made;
  }
  static Order order(const Json& in, const Json& of_action) {
    const auto said = [&](const char* key) {
      const auto found = of_action.members.find(key);
      return found == of_action.members.end() || found->second.kind == Json::null ? std::string() : text(found->second);
    };
    Order made{text(of_action.at("do")), said("activity"), said("alternative"), said("hardware"), said("objective")};
    if (!made.alternative.empty()) {
      const std::string own = renamed(in, "alternatives", made.activity + "." + made.alternative);
      made.alternative = own.substr(own.find('.') + 1);
    }
    made.activity = renamed(in, "activities", made.activity);
    made.hardware = renamed(in, "hardware", made.hardware);
    made.objective = renamed(in, "objectives", made.objective);
    return made;
  }

  std::map<std::string, const Json*> sections_;
  std::vector<Rules> rules_;  // of each type, if they have no tables
  std::vector<std::map<std::pair<Int, Int>, std::vector<const Json*>>> edges_;  // of each type, by state and event
};
