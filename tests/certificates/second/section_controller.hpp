// A controller beside the types of a mission's sections: whether both tile the mission alike, and do the same in each section.
#pragma once

#include "robot.hpp"
#include "sections.hpp"

// The words of the mission for what a section that is played says, and the other way round.
class Wording {
 public:
  explicit Wording(const Placed& of) : of_(of) {
    for (const auto& [kind, names] : of.names) for (const auto& [name, own] : names) names_[kind][own] = name;
    for (const auto& [name, all] : of.alternatives) for (const std::string& own : all) names_["alternative"][own] = name;
  }

  Names said(const std::set<Role>& by, const char* role) const {
    static const std::map<std::string, std::string> kinds{{"objective", "section"}, {"pending", "section"}, {"done", "branch"}, {"refused", "activity"},
                                                          {"oos", "resource"}, {"active", "alternative"}, {"wait", "alternative"}};
    Names found;
    for (auto each = by.lower_bound({role, ""}); each != by.end() && each->first == role; ++each) found.insert(names_.at(kinds.at(role)).at(each->second));
    return found;
  }
  std::string name(const char* kind, const std::string& own) const { return names_.at(kind).at(own); }
  Texts event(Texts of) const {
    const bool hardware = of[0] == "out of service" || of[0] == "repaired" || of[0] == "detected";
    of[1] = name(hardware ? "resource" : of[0] == "declared" ? "event" : "section", of[1]);
    return of;
  }
  // What a name of the mission is here, if anything.
  std::string own(const char* kind, const std::string& of) const {
    const auto names = of_.names.find(kind);
    if (names == of_.names.end()) return "";
    const auto found = names->second.find(of);
    return found == names->second.end() ? "" : found->second;
  }
  Names all(const char* kind) const {
    Names found;
    if (const auto names = of_.names.find(kind); names != of_.names.end()) for (const auto& [name, _] : names->second) found.insert(name);
    return found;
  }
  const Placed& placed() const { return of_; }

 private:
  const Placed& of_;
  std::map<std::string, std::map<std::string, std::string>> names_;
};

class SectionController {
 public:
  SectionController(const Core& core, const Sections& sections, const Controller& controller, const Clock& clock)
      : core_(core), sections_(sections), of_(controller), clock_(clock) {
    for (const auto& [name, number] : core.resources) resources_[number] = name;
  }

  std::size_t count = 0, walked = 0, pairs = 0, events = 0;

  void all() {
    whole_robot();
    agree(text(of_.of.at("initial")) == sections_.entry(), "another section is the first one");
    std::set<std::string> known;
    for (const std::string& name : sections_.reached()) {
      if (!sections_.has(name)) continue;
      ++count;
      const Json* in = of_.section_named(name);
      agree(in, "the controller has no such section: " + name);
      const Wording words(sections_.placed(name));
      tiled(core_.graph->sections[core_.graph->numbers.at(name)], *in, words);
      if (known.insert(key(*in, words)).second) { ++walked; walk(name, *in, words); }
    }
  }

 private:
  void whole_robot() const {
    Names faulty, never, crashing, out;
    for (const Hardware& each : core_.hardware) {
      if (each.out && !each.faulty) throw Limit("hardware is out of service at first that never fails");
      if (each.out) out.insert(each.name);
      if (!each.faulty) continue;
      faulty.insert(each.name);
      if (!each.repairable) never.insert(each.name);
      if (each.crash) crashing.insert(each.name);
    }
    agree(of_.hardware == faulty, "other hardware may fail");
    agree(of_.unrepairable == never, "other hardware is never repaired");
    agree(of_.crashing == crashing, "other hardware fails only as it is used");
    agree(names_in(of_.of.at("out_of_service")) == out, "other hardware is out of service at first");
    agree(of_.late.empty() && of_.of.at("facts").members.empty() && of_.of.at("changing").members.empty(), "the controller asks facts");
  }

  // The objectives of a section, and of what it holds.
  static void objectives(const Section& of, Names& to) {
    if (!of.block) to.insert(of.name);
    for (const Branch& each : of.branches) for (const Section& inner : each.graph->sections) objectives(inner, to);
    for (const Pause& each : of.pauses) for (const Section& inner : each.graph->sections) objectives(inner, to);
  }
  void same_laws(const Section& of) const {
    const auto& blocks = of_.of.members.count("blocks") ? of_.of.at("blocks").members : std::map<std::string, Json>();
    if (of.block) {
      agree(blocks.count(of.name) == of.routed("timeout"), "another timeout of the block " + of.name);
      Names held;
      for (const Branch& each : of.branches) for (const Section& inner : each.graph->sections) objectives(inner, held);
      agree(!of.routed("timeout") || names_in(blocks.at(of.name).at("objectives")) == held, "a block with other objectives: " + of.name);
    } else {
      const auto found = of_.of.at("objectives").members.find(of.name);
      agree(found != of_.of.at("objectives").members.end() && !blocks.count(of.name), "the controller has no objective " + of.name);
      Names run;
      for (const std::size_t each : of.activities) run.insert(core_.activities[each].name);
      agree(names_in(found->second.at("activities")) == run, "an objective runs other activities: " + of.name);
      agree((found->second.at("timeout").kind != Json::null) == of.routed("timeout"), "another timeout of the objective " + of.name);
    }
    for (const Branch& each : of.branches) for (const Section& inner : each.graph->sections) same_laws(inner);
    for (const Pause& each : of.pauses) for (const Section& inner : each.graph->sections) same_laws(inner);
  }
  void same_activities(const Wording& words) {
    const Names used = words.all("activity");
    for (const Activity& each : core_.activities) {
      if (!used.count(each.name) || !compared_.insert(each.name).second) continue;
      const auto found = of_.of.at("activities").members.find(each.name);
      agree(found != of_.of.at("activities").members.end(), "the controller has no activity " + each.name);
      Names produced;
      for (const std::size_t resource : each.products) produced.insert(resources_.at(resource));
      agree(names_in(found->second.at("produces")) == produced, "an activity produces something else: " + each.name);
      for (const Alternative& way : each.alternatives) {
        const auto own = found->second.at("alternatives").members.find(way.name);
        agree(own != found->second.at("alternatives").members.end(), "an activity without the alternative " + way.name);
        Names consumed;
        for (const std::size_t resource : way.consumed) consumed.insert(resources_.at(resource));
        agree(names_in(own->second.at("consumes")) == consumed, "an activity consumes something else: " + each.name);
      }
    }
  }
  void tiled(const Section& section, const Json& in, const Wording& words) {
    same_laws(section);
    same_activities(words);
    const auto usable = [&](const std::string& name) { return !words.own("resource", name).empty(); };
    for (const std::string& event : texts(in.at("events")))
      for (const std::string& name : {started_with(event, "_EV_OOS"), started_with(event, "_EV_RD")})
        agree(!of_.hardware.count(name) || usable(name), "it waits for hardware that the section cannot use: " + name);
    const Json& type = of_.type(in);
    for (const std::string& name : renamed_all(in, "hardware", type.at("hardware"))) agree(usable(name), "it asks for hardware that the section cannot use: " + name);
    agree(texts(type.at("once")).empty() && texts(type.at("facts")).empty(), "it asks for a fact, or a handler that happens once");
  }

  // All texts in a document, keys too.
  static void texts_in(const Json& of, std::set<std::string>& to) {
    if (of.kind == Json::text) to.insert(of.string);
    for (const Json& each : of.items) texts_in(each, to);
    for (const auto& [key, each] : of.members) { to.insert(key); texts_in(each, to); }
  }

  // What a walk depends on: the section that is played, the type, and what the controller puts in its place, in the words of what is played.
  std::string key(const Json& in, const Wording& words) const {
    std::string made = std::to_string(words.placed().type) + ' ' + std::to_string(whole(in.at("type")));
    const auto add = [&](const std::string& of) { made += std::to_string(of.size()) + ':' + of; };
    const auto own = [&](const std::string& kind, const std::string& name) {
      std::string found;
      if (kind == "objectives") found = "s" + words.own("section", name) + "b" + words.own("branch", name);
      else if (kind == "activities") found = "a" + words.own("activity", name);
      else if (kind == "hardware") found = "r" + words.own("resource", name);
      else if (kind == "alternatives")
        if (const auto ways = words.placed().alternatives.find(name); ways != words.placed().alternatives.end()) for (const std::string& each : ways->second) found += ' ' + each;
      return found;
    };
    std::map<std::string, Names> here{{"objectives", words.all("section")}, {"activities", words.all("activity")}, {"hardware", words.all("resource")}, {"alternatives", {}}};
    for (const std::string& each : words.all("branch")) here["objectives"].insert(each);
    for (const auto& [name, _] : words.placed().alternatives) here["alternatives"].insert(name);
    const auto unknown = [](const std::string& found) { return found.empty() || found == "sb" || found == "a" || found == "r"; };
    std::set<std::string> spoken;
    texts_in(of_.type(in), spoken);
    std::map<std::pair<std::string, std::string>, std::string> put;  // by kind and name in the type
    for (const auto& [kind, names] : in.at("names").members)
      for (const auto& [name, to] : names.members) {
        if (here.count(kind) && kind != "alternatives" && !spoken.count(name)) continue;
        const std::string found = own(kind, text(to));
        put[{kind, name}] = unknown(found) ? '?' + text(to) : found;
      }
    for (const auto& [kind, names] : here)  // a name that has no other one says what it says
      for (const std::string& name : names) if (kind == "alternatives" || spoken.count(name)) put.emplace(std::make_pair(kind, name), own(kind, name));
    for (const auto& [at, to] : put) { add(at.first); add(at.second); add(to); }
    std::map<std::string, std::string> happens;
    const Played& type = sections_.type(words.placed());
    for (const auto& ways : type.ways) for (const auto& way : ways) happens[event_text(words.event(way.event))] = event_text(way.event);
    made += '|';
    for (const std::string& event : texts(in.at("events"))) { const auto found = happens.find(event); add(found == happens.end() ? '?' + event : found->second); }
    made += '|';
    for (const auto& [outcome, to] : in.at("routes").members) {
      const auto& targets = words.placed().targets;
      const auto at = std::find(targets.begin(), targets.end(), text(to));
      add(outcome);
      add(at == targets.end() ? '?' + text(to) : std::to_string(at - targets.begin()));
    }
    return made;
  }

  void alike(const Wording& words, const std::set<Role>& says, const Position& at, const Shown& shown) const {
    agree(words.said(says, "oos") == at.gone, "other hardware is out of service");
    agree(at.held.empty() && at.happened.empty(), "something is true besides");
    agree(words.said(says, "objective") == shown.objectives, "other objectives run");
    agree(words.said(says, "pending") == shown.pending, "other objectives wait");
    agree(words.said(says, "done") == shown.done, "other branches have ended");
    agree(words.said(says, "refused") == shown.refused, "other activities are refused");
    Names active;
    for (const auto& [activity, alternative] : shown.mode) active.insert(activity + '.' + alternative);
    agree(words.said(says, "active") == active, "other activities run");
    agree(words.said(says, "wait") == shown.waiting, "other activities wait");
  }

  void walk(const std::string& name, const Json& in, const Wording& words) {
    const Played& type = sections_.type(words.placed());
    using Pair = std::pair<std::size_t, Position>;
    std::set<Pair> met;
    std::vector<Pair> todo;
    const auto come = [&](std::size_t state, const Position& at) {
      if (met.emplace(state, at).second) { todo.emplace_back(state, at); clock_.look(++pairs); }
    };
    for (const auto& [out, entry] : type.entries) {
      Moved made;
      for (const std::string& each : out) made.to.gone.insert(words.name("resource", each));
      try {
        of_.enter(made, name);
      } catch (const NotEntered& why) {
        throw Limit(why.what());
      }
      Robot(of_, {}, of_.shown(made.to), {"start", ""}).takes(made.orders);
      come(entry, made.to);
    }
    Names asked = names_in(in.at("events"));
    for (const std::string& each : of_.hardware)
      if (!words.own("resource", each).empty()) { asked.insert(each + "_EV_OOS"); asked.insert(each + "_EV_RD"); }
    for (std::size_t i = 0; i < todo.size(); ++i) {
      const auto [state, at] = todo[i];
      const Shown here = of_.shown(at);
      alike(words, type.said[state], at, here);
      std::map<std::string, std::pair<const Played::Way*, Texts>> edges;
      for (const Played::Way& way : type.ways[state]) {
        const Texts event = words.event(way.event);
        const auto [found, fresh] = edges.emplace(event_text(event), std::make_pair(&way, event));
        agree(fresh || (found->second.first->to == way.to && found->second.first->leaves == way.leaves), "an event that leads to two states");
      }
      for (const std::string& event : asked) agree(edges.count(event) || !of_.within_section(at, event), "the controller alone takes " + event);
      for (const auto& [event, edge] : edges) {
        const auto moved = of_.within_section(at, event);
        agree(bool(moved), "the section alone takes " + event);
        ++events;
        const Played::Way& way = *edge.first;
        agree(way.leaves == !moved->outcome.empty(), "one of both leaves the section by " + event);
        Robot(of_, here, way.leaves ? Shown() : of_.shown(moved->to), edge.second).takes(moved->orders);
        if (!way.leaves) { come(way.to, moved->to); continue; }
        agree(Controller::route(in, moved->outcome) == words.placed().targets[way.to], "the controller leads elsewhere by " + event);
        agree(moved->to.held.empty() && moved->to.happened.empty(), "something is true behind the section");
      }
    }
  }

  const Core& core_;
  const Sections& sections_;
  const Controller& of_;
  const Clock& clock_;
  std::map<std::size_t, std::string> resources_;
  Names compared_;
};
