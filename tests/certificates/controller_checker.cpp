// A second checker of controllers, written from docs/certificates.md and docs/formats.md alone: it walks the states of a net
// and those of a controller in pairs. Of the forms it reads tables, hierarchical and flat; of rules it says that it does not.
//
// controller_checker CERTIFICATE CONTROLLER [--max-states N] [--seconds S]
#include <tuple>

#include "certificate.hpp"

using Names = std::set<std::string>;
using Modes = std::map<std::string, std::string>;

struct Refuted : std::runtime_error { using runtime_error::runtime_error; };

void agree(bool holds, const std::string& what) { if (!holds) throw Refuted(what); }

Names names_in(const Json& of) {
  const Texts all = texts(of);
  return {all.begin(), all.end()};
}
const Json& item(const Json& of, Int at) {
  require(at >= 0 && at < Int(list(of).size()), "a number of nothing");
  return of.items[std::size_t(at)];
}
std::string renamed(const Json& section, const char* kind, const std::string& name) {
  const auto of = section.at("names").members.find(kind);
  if (of == section.at("names").members.end()) return name;
  const auto own = of->second.members.find(name);
  return own == of->second.members.end() ? name : text(own->second);
}
Names renamed_all(const Json& section, const char* kind, const Json& of) {
  Names found;
  for (const std::string& name : texts(of)) found.insert(renamed(section, kind, name));
  return found;
}

// ---- what a controller is in, and what an event does to it

struct Position {
  std::string phase = "begin";  // or the name of a section after "in ", or an end
  Int state = 0;
  Names gone, happened, held;
  bool operator<(const Position& other) const {
    return std::tie(phase, state, gone, happened, held) < std::tie(other.phase, other.state, other.gone, other.happened, other.held);
  }
};

struct Order { std::string verb, activity, alternative, hardware, objective; };
struct Moved { Position to; std::vector<std::vector<Order>> orders; };
struct Shown { Names objectives, pending, done, refused, waiting; Modes mode; };

std::string started_with(const std::string& text, const std::string& suffix) {
  if (text.size() <= suffix.size() || text.compare(text.size() - suffix.size(), suffix.size(), suffix) != 0) return "";
  return text.substr(0, text.size() - suffix.size());
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
      edges_.emplace_back();
      for (const Json& edge : list(each.at("edges"))) edges_.back()[{whole(edge.at("from")), whole(edge.at("event"))}].push_back(&edge);
    }
    hardware = names_in(of.at("hardware"));
    unrepairable_ = names_in(of.at("unrepairable"));
    crashing_ = names_in(of.at("crashing"));
    for (const auto& [name, said] : of.at("late").members) late[name] = text(said);
    for (const auto& [name, each] : of.at("activities").members)
      for (const std::string& software : texts(each.at("produces"))) makers[software].insert(name);
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
    const Json& state = item(type(*in).at("states"), at.state);
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
    auto made = std::make_unique<Moved>();
    Position& to = made->to = at;
    if (event == "MISSION_EV_START") {
      if (at.phase != "begin") return nullptr;
      return enter(*made, text(of.at("initial"))) ? std::move(made) : nullptr;
    }
    const std::string lost = started_with(event, "_EV_OOS"), back = started_with(event, "_EV_RD");
    const bool loses = hardware.count(lost) > 0, repairs = hardware.count(back) > 0;
    if (loses && !to.gone.insert(lost).second) return nullptr;
    if (repairs) {
      if (unrepairable_.count(back) || !to.gone.erase(back)) return nullptr;
      if (const auto text_of = late.find(back); text_of != late.end() && !to.held.erase(text_of->second)) return nullptr;
    }
    const Json* in = section(at);
    if (in) {
      const Texts own = texts(in->at("events"));
      const auto found = std::find(own.begin(), own.end(), event);
      const std::string touched = loses ? lost : repairs ? back : "";
      const bool of_section = !touched.empty() && renamed_all(*in, "hardware", type(*in).at("hardware")).count(touched) > 0;
      if (found != own.end() || of_section) return taken(std::move(made), *in, at, found - own.begin());
    }
    if (loses && crashing_.count(lost)) return nullptr;
    if (loses || repairs) return made;
    const auto changes = of.at("changing").members.find(event);
    if (changes == of.at("changing").members.end()) return nullptr;
    for (const std::string& each : texts(changes->second.at("false"))) to.held.erase(each);
    for (const std::string& each : texts(changes->second.at("true"))) to.held.insert(each);
    return to.held == at.held ? nullptr : std::move(made);
  }

  Json of;
  Names hardware;
  std::map<std::string, std::string> late;
  std::map<std::string, Names> makers, timed;

 private:
  const Json& type(const Json& section) const { return item(of.at("types"), whole(section.at("type"))); }

  std::unique_ptr<Moved> taken(std::unique_ptr<Moved> made, const Json& in, const Position& at, Int event) const {
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
    const auto route = in.at("routes").members.find(edge->at("to").string);
    agree(route != in.at("routes").members.end(), "an outcome without a route");
    return enter(*made, text(route->second)) ? std::move(made) : nullptr;
  }

  static void changed(Position& to, const Json& in, const Json& by) {
    for (const std::string& name : renamed_all(in, "facts", by.at("gained"))) to.held.insert(name);
    for (const std::string& name : renamed_all(in, "facts", by.at("lost"))) to.held.erase(name);
  }

  bool enter(Moved& made, const std::string& name) const {
    static const Modes ends{{"succeed", "success"}, {"fail", "failure"}, {"abort", "abort"}};
    made.to.state = 0;
    const auto found = sections_.find(name);
    if (found == sections_.end()) {
      const auto end = ends.find(name);
      agree(end != ends.end(), "a route to nothing");
      made.to.phase = end->second;
      return true;
    }
    const Json& in = *found->second;
    std::size_t number = 0, bit = 0;
    for (const std::string& each : texts(type(in).at("hardware")))
      number |= std::size_t(made.to.gone.count(renamed(in, "hardware", each))) << bit++;
    const Texts facts = texts(type(in).at("facts"));
    for (Int i = 0; i < whole(type(in).at("entering")); ++i)
      number |= std::size_t(made.to.held.count(renamed(in, "facts", facts.at(std::size_t(i))))) << bit++;
    require(bit < 40, "an entry of too many bits");
    const Json& entry = item(type(in).at("entries"), Int(number));
    agree(entry.kind != Json::null, "a section that cannot be entered");
    made.to.phase = "in " + name;
    made.to.state = whole(entry.at("to"));
    item(type(in).at("states"), made.to.state);
    changed(made.to, in, entry);
    made.orders.push_back(orders(in, entry.at("actions")));
    return true;
  }

  static std::vector<Order> orders(const Json& in, const Json& of_edge) {
    std::vector<Order> made;
    for (const Json& each : list(of_edge)) {
      const auto said = [&](const char* key) {
        const auto found = each.members.find(key);
        return found == each.members.end() || found->second.kind == Json::null ? std::string() : text(found->second);
      };
      Order order{text(each.at("do")), said("activity"), said("alternative"), said("hardware"), said("objective")};
      if (!order.alternative.empty()) {
        const std::string own = renamed(in, "alternatives", order.activity + "." + order.alternative);
        order.alternative = own.substr(own.find('.') + 1);
      }
      order.activity = renamed(in, "activities", order.activity);
      order.hardware = renamed(in, "hardware", order.hardware);
      order.objective = renamed(in, "objectives", order.objective);
      made.push_back(order);
    }
    return made;
  }

  std::map<std::string, const Json*> sections_;
  std::vector<std::map<std::pair<Int, Int>, std::vector<const Json*>>> edges_;  // of each type, by state and event
  Names unrepairable_, crashing_;
};

// ---- a robot that is given the orders of one event

Names timers(const Controller& of, const Shown& in) {
  Names found;
  for (const auto& [name, held] : of.timed) {
    const auto there = [&](const std::string& each) { return in.objectives.count(each) || in.pending.count(each); };
    if (of.of.at("objectives").members.count(name) && held.empty() ? in.objectives.count(name) > 0 : std::any_of(held.begin(), held.end(), there)) found.insert(name);
  }
  return found;
}

class Robot {
 public:
  Robot(const Controller& of, const Shown& before, const Shown& after, const Texts& event)
      : of_(of), after_(after), running_(before.mode), timers_(timers(of, before)), event_(event) {}

  void takes(const std::vector<std::vector<Order>>& all) {
    if ((event_[0] == "success" || event_[0] == "failure" || event_[0] == "timeout") && timers_.count(event_[1])) ends_ = event_[1];
    for (const auto& section : all) {
      std::size_t at = 0;
      left_.clear();
      released_.clear();
      for (const Order& order : section) {
        static const Texts verbs{"disarm", "stop", "release", "select", "start", "arm"};
        const std::size_t verb = std::size_t(std::find(verbs.begin(), verbs.end(), order.verb) - verbs.begin());
        require(verb < verbs.size(), "an order of no kind");
        agree(at <= verb, "orders are in another order");
        at = verb;
        take(order);
      }
      agree(left_ == released_, "other hardware is released than was held");
    }
    agree(ends_.empty(), "the timer of what ends is not disarmed");
    agree(running_ == after_.mode, "other activities run than the state says");
    agree(timers_ == timers(of_, after_), "other timers run than the state says");
  }

 private:
  Names consumed(const std::string& activity, const std::string& alternative) const {
    return names_in(of_.of.at("activities").at(activity).at("alternatives").at(alternative).at("consumes"));
  }
  // Whether all that it consumes and another activity produces is there.
  bool supplied(const std::string& activity, const std::string& alternative) const {
    for (const std::string& each : consumed(activity, alternative)) {
      const auto makers = of_.makers.find(each);
      if (makers == of_.makers.end()) continue;
      Names others = makers->second;
      others.erase(activity);
      if (!others.empty() && std::none_of(others.begin(), others.end(), [&](const std::string& who) { return running_.count(who); })) return false;
    }
    return true;
  }
  void gives_up(const std::string& activity) {
    for (const std::string& each : consumed(activity, running_.at(activity)))
      if (!of_.makers.count(each)) left_.insert(each);
  }
  void named(const Order& order) const {
    Names may;
    for (const std::string& each : after_.objectives)
      if (names_in(of_.of.at("objectives").at(each).at("activities")).count(order.activity)) may.insert(each);
    agree(may.empty() ? order.objective.empty() : may.count(order.objective) > 0, "an activity that is said to be of another objective");
  }
  void take(const Order& order) {
    const std::string& who = order.activity;
    if (order.verb == "disarm") {
      agree(timers_.erase(order.objective), "a timer is disarmed that does not run");
      agree(event_[0] != "out of service" && event_[0] != "repaired" && event_[0] != "detected", "hardware disarms a timer");
      if (order.objective == ends_) ends_.clear();
    } else if (order.verb == "arm") {
      agree(timers_.insert(order.objective).second, "a timer is armed that runs");
    } else if (order.verb == "stop") {
      agree(running_.count(who), "who does not run is stopped");
      agree(supplied(who, running_.at(who)), "who is stopped has lost what it consumes");
      gives_up(who);
      running_.erase(who);
    } else if (order.verb == "release") {
      agree(released_.insert(order.hardware).second, "hardware is released twice");
    } else if (order.verb == "select") {
      agree(selected_.emplace(who, order.alternative).second, "an activity is selected twice");
      agree(after_.mode.count(who) && after_.mode.at(who) == order.alternative, "an alternative is selected that does not run then");
      named(order);
      if (running_.count(who)) { gives_up(who); running_[who] = order.alternative; }
    } else {
      agree(!running_.count(who) && selected_.count(who), "who runs, or has no alternative, is started");
      agree(supplied(who, selected_.at(who)), "who is started has not what it consumes");
      named(order);
      running_[who] = selected_.at(who);
    }
  }

  const Controller& of_;
  const Shown& after_;
  Modes running_, selected_;
  Names timers_, left_, released_;
  Texts event_;
  std::string ends_;
};

// ---- pairs

std::string event_text(const Texts& event) {
  static const Modes tails{{"success", "_EV_OK"}, {"failure", "_EV_FAIL"}, {"timeout", "_EV_TIMEOUT"}};
  static const Modes hardware{{"out of service", "_EV_OOS"}, {"repaired", "_EV_RD"}, {"detected", "_EV_DETECTED"}};
  if (event[0] == "start") return "MISSION_EV_START";
  if (const auto tail = tails.find(event[0]); tail != tails.end())
    return "OBJ_" + event[1] + tail->second + (event.size() == 3 ? "_" + event[2] : "");
  if (const auto tail = hardware.find(event[0]); tail != hardware.end()) return event[1] + tail->second;
  return event[1];
}

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
      agree(states_.ends(state, {phase}) == (at.phase == phase), std::string("another ") + phase);
    agree(said(state, "oos") == at.gone, "other hardware is out of service");
    Names known;
    for (const auto& [name, text_of] : of_.late)
      if (at.held.count(text_of)) known.insert(name);
    same("known", known);
    for (const auto& [fact, values] : of_.of.at("facts").members) {
      Names mine, now;
      for (const auto& [_, what] : values.members)
        for (const std::string& each : texts(what))
          if (at.held.count(each)) now.insert(each);
      for (const auto& [value, what] : values.members)
        if (names_in(what) == now) mine.insert(fact + "=" + value);
      for (const std::string& value : said(state, "fact"))
        agree(value.rfind(fact + "=", 0) != 0 || mine.count(value), "another value of " + fact);
    }
    for (const std::string& value : said(state, "fact"))
      agree(of_.of.at("facts").members.count(value.substr(0, value.find('='))) > 0, "a fact that the controller has not");
    same("objective", shown.objectives);
    same("pending", shown.pending);
    same("done", shown.done);
    same("refused", shown.refused);
    Names active;
    for (const auto& [activity, alternative] : shown.mode) active.insert(activity + "." + alternative);
    same("active", active);
    same("wait", shown.waiting, "want");
  }

  const Net& net_;
  const States& states_;
  const Controller& of_;
  std::set<Role> roles_;
};

int checked(const std::string& certificate, const std::string& path, const Clock& clock) {
  const Net net = net_of(parsed(unzipped(certificate).at("net.json")));
  std::ifstream file(path, std::ios::binary);
  require(bool(file), "a controller that cannot be read");
  Json document = parsed(std::string((std::istreambuf_iterator<char>(file)), {}), true);
  require(document.kind == Json::object, "a controller that is no object");
  if (text(document.at("form")) == "modular") {
    std::cout << "not checked controller: rules are not read\n";
    return 2;
  }
  const Controller controller(std::move(document));
  try {
    const States states(net, clock);
    const auto [pairs, events] = Walk(net, states, controller).all(clock);
    std::cout << "proved controller: " << pairs << " pairs of states, " << events << " events\n";
    return 0;
  } catch (const Refuted& why) {
    std::cout << "refuted controller: " << why.what() << '\n';
    return 1;
  } catch (const Unsafe&) {
    std::cout << "not checked controller: the net is not safe\n";
  } catch (const NotConfluent&) {
    std::cout << "not checked controller: the net is not confluent\n";
  } catch (const Limit& limit) {
    std::cout << "not checked controller: " << limit.what() << '\n';
  }
  return 2;
}

int main(int count, char** words) {
  if (count < 3) {
    std::cerr << "usage: controller_checker CERTIFICATE CONTROLLER [--max-states N] [--seconds S]\n";
    return 2;
  }
  const std::string certificate = words[1];
  return answered(count - 1, words + 1, "--max-states",
                  [&](const std::string& path, const Clock& clock) { return checked(certificate, path, clock); });
}
