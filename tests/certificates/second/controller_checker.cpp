// A second checker of controllers, written from docs/certificates.md, docs/formats.md, docs/controller.md and what
// mcpn/events.py and mcpn/controller/document.py say of themselves: it walks the states of a net and those of a controller of
// any form in pairs.
//
// controller_checker CERTIFICATE CONTROLLER [--max-states N] [--seconds S]
#include "walked.hpp"

class Walk {
 public:
  Walk(const Net& net, const States& states, const Controller& of) : net_(net), states_(states), of_(of) {
    for (const Place& place : net.places)
      for (const Role& role : place.roles) roles_.insert(role);
  }

  // How many pairs there are, and how many events they take.
  std::pair<std::size_t, std::size_t> all(const Clock& clock) {
    using Pair = std::pair<std::size_t, Position>;
    std::set<Pair> met{{0, of_.first()}};
    std::vector<Pair> todo(met.begin(), met.end());
    std::size_t events = 0;
    for (std::size_t i = 0; i < todo.size(); ++i) {
      clock.look(todo.size());
      const auto [state, at] = todo[i];
      const Shown here = of_.shown(at);
      alike(state, at, here);
      std::map<std::string, std::pair<std::size_t, Texts>> edges;
      for (const Edge& edge : states_.edges[state]) {
        const Texts& event = net_.transitions[std::size_t(edge.transition)].event;
        const auto [found, fresh] = edges.emplace(event_text(event), std::make_pair(edge.to, event));
        agree(fresh || found->second.first == edge.to, "an event that leads to two states");
      }
      for (const std::string& event : of_.known_events(at))
        agree(edges.count(event) || !of_.after(at, event), "the controller alone takes " + event);
      for (const auto& [event, to] : edges) {
        const auto moved = of_.after(at, event);
        agree(bool(moved), "the net alone takes " + event);
        const Shown there = of_.shown(moved->to);
        Robot(of_, here, there, to.second).takes(moved->orders);
        ++events;
        if (met.emplace(to.first, moved->to).second) todo.emplace_back(to.first, moved->to);
      }
    }
    return {todo.size(), events};
  }

 private:
  Names said(std::size_t state, const char* role) const {
    Names found;
    for (std::size_t p = 0; p < net_.places.size(); ++p)
      if (states_.markings[state][p])
        for (const Role& each : net_.places[p].roles)
          if (each.first == role) found.insert(each.second);
    return found;
  }
  void alike(std::size_t state, const Position& at, const Shown& shown) const {
    const auto same = [&](const char* role, Names expected, const char* also = "") {
      for (auto each = expected.begin(); each != expected.end();)
        each = roles_.count({role, *each}) || roles_.count({also, *each}) ? std::next(each) : expected.erase(each);
      Names found = said(state, role), more = said(state, also);
      found.insert(more.begin(), more.end());
      agree(found == expected, std::string("another ") + role);
    };
    for (const char* phase : {"begin", "success", "failure", "abort"})
      agree(!said(state, phase).empty() == (at.phase == phase), std::string("another ") + phase);
    agree(said(state, "oos") == at.gone, "other hardware is out of service");
    Names known;
    for (const auto& [name, text_of] : of_.late)
      if (at.held.count(text_of)) known.insert(name);
    same("known", known);
    Names facts;
    for (const auto& [fact, values] : of_.of.at("facts").members) {
      Names now;
      for (const auto& [_, what] : values.members)
        for (const std::string& each : texts(what))
          if (at.held.count(each)) now.insert(each);
      for (const auto& [value, what] : values.members)
        if (names_in(what) == now) facts.insert(fact + "=" + value);
    }
    agree(said(state, "fact") == facts, "other facts");
    same("objective", shown.objectives);
    same("pending", shown.pending);
    same("done", shown.done);
    same("refused", shown.refused);
    Names active;
    for (const auto& [activity, alternative] : shown.mode) active.insert(activity + "." + alternative);
    agree(said(state, "active") == active, "other alternatives run");
    same("wait", shown.waiting, "want");
  }

  const Net& net_;
  const States& states_;
  const Controller& of_;
  std::set<Role> roles_;
};

// What has a timer in the controller is what the net has a timeout of.
void same_timers(const Net& net, const Controller& of) {
  Names of_net, its;
  for (const Transition& each : net.transitions)
    if (!each.internal() && each.event[0] == "timeout") of_net.insert(each.event[1]);
  for (const char* kind : {"objectives", "blocks"})
    if (of.of.members.count(kind))
      for (const auto& [name, each] : of.of.at(kind).members)
        if (each.at("timeout").kind != Json::null) its.insert(name);
  agree(of_net == its, "other timers than the net has timeouts");
}

// What its activities consume and produce is what the core mission says.
void same_robot(const Json& core, const Controller& of) {
  const Json& robot = core.at("robot");
  Names crash;
  for (const Json& each : list(robot.at("hardware")))
    if (each.at("crash").truth && each.at("faulty").truth) crash.insert(text(each.at("name")));
  agree(crash == of.crashing, "other hardware fails only as it is used");
  for (const Json& each : list(robot.at("activities"))) {
    const auto found = of.of.at("activities").members.find(text(each.at("name")));
    if (found == of.of.at("activities").members.end()) continue;  // so it never runs
    agree(names_in(found->second.at("produces")) == names_in(each.at("produces")), "an activity makes something else");
    std::map<std::string, Names> used, its;
    for (const Json& way : list(each.at("alternatives"))) used[text(way.at("name"))] = names_in(way.at("consumes"));
    for (const auto& [name, way] : found->second.at("alternatives").members) its[name] = names_in(way.at("consumes"));
    agree(used == its, "an activity uses something else");
  }
}

std::string walked(const std::string& certificate, const std::string& path, const Clock& clock) {
  const auto entries = unzipped(certificate);
  const Net net = net_of(parsed(entries.at("net.json")));
  const Controller controller = controller_of(path);
  same_timers(net, controller);
  if (entries.count("core.json")) same_robot(parsed(entries.at("core.json")), controller);
  const States states(net, clock);
  const auto [pairs, events] = Walk(net, states, controller).all(clock);
  return std::to_string(pairs) + " pairs of states, " + std::to_string(events) + " events";
}

int main(int count, char** words) { return verdict_on_controller(count, words, walked); }
