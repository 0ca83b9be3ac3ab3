// A section of a core mission taken out of it, with what it needs, so that sections that are alike but for names are the same.
#pragma once

#include "core.hpp"

// What a robot has, by its names.
struct Equipment {
  explicit Equipment(const Json& of) {
    for (const Json& each : of.at("activities").items) activities.emplace(each.at("name").string, &each);
    for (const Json& each : of.at("hardware").items) hardware.emplace(each.at("name").string, &each);
    for (const Json& each : of.at("software").items) software.emplace(each.at("name").string, &each);
  }
  std::map<std::string, const Json*> activities, hardware, software;
};

// A section alone, with what its activities need, and all names but those of reasons replaced in the order in which they are met.
class Alone {
 public:
  Alone(const Json& section, const Core& of, const Equipment& robot) : of_(of), whole_(robot) {
    core.kind = Json::object;
    core.members["format"] = word("mcpn-certificate");
    core.members["version"] = number(1);
    Json& graph = core.members["graph"];
    graph.kind = Json::object;
    for (const char* key : {"facts", "events", "hardware", "software", "activities"}) robot_.members[key].kind = Json::list;
    robot_.kind = Json::object;
    Json alone = of_section(section, true);
    graph.members["entry"] = alone.at("name");
    Json& sections = graph.members["sections"];
    sections.kind = Json::list;
    sections.items.push_back(std::move(alone));
    core.members["robot"] = std::move(robot_);
  }

  Json core;
  Texts targets;  // by number, in the mission's words
  Texts hardware;  // by number
  std::map<std::string, std::map<std::string, std::string>> names;  // those here, by kind and by those of the mission
  std::map<std::string, Texts> alternatives;  // those here, by "activity.alternative" of the mission
  std::set<std::string> contended;  // in the words here

  // What two sections of one type have in common.
  std::string type() const {
    std::string made;
    write(core, made);
    for (const std::string& each : contended) made += each + ' ';
    return made;
  }

 private:
  static Json word(const std::string& of) { Json made; made.kind = Json::text; made.string = of; return made; }
  static Json number(Int of) { Json made; made.kind = Json::number; made.value = of; return made; }
  static void write(const Json& of, std::string& to) {
    switch (of.kind) {
      case Json::text: to += std::to_string(of.string.size()) + ':' + of.string; break;
      case Json::number: to += std::to_string(of.value) + ','; break;
      case Json::boolean: to += of.truth ? 't' : 'f'; break;
      case Json::list: to += '['; for (const Json& each : of.items) write(each, to); to += ']'; break;
      case Json::object: to += '{'; for (const auto& [key, each] : of.members) { to += std::to_string(key.size()) + ':' + key; write(each, to); } to += '}'; break;
      case Json::null: to += 'n'; break;
    }
  }
  // The name here of something of a kind, and whether it is new.
  std::pair<std::string, bool> known(const char* kind, const std::string& name) {
    auto& of_kind = names[kind];
    const auto [at, fresh] = of_kind.emplace(name, kind + std::to_string(of_kind.size()));
    return {at->second, fresh};
  }
  Json named(const char* kind, const Json& of) { return word(known(kind, of.string).first); }

  Json target(const Json& of, bool outside) {
    if (!outside) {
      const auto section = names["section"].find(of.string);
      return section == names["section"].end() ? of : word(section->second);
    }
    const auto [name, fresh] = known("target", of.string);
    if (fresh) targets.push_back(of.string);
    return word(name);
  }
  Json cases(Json of, bool outside) {
    for (Json& each : of.items) each.members["to"] = target(each.at("to"), outside);
    return of;
  }
  Json handlers(Json of, bool outside) {
    for (Json& each : of.items) {
      each.members["event"] = named("event", each.at("event"));
      each.members["to"] = cases(each.at("to"), outside);
    }
    return of;
  }
  Json graph(Json of) {
    for (const Json& each : of.at("sections").items) known("section", each.at("name").string);
    of.members["entry"] = target(of.at("entry"), false);
    for (Json& each : of.members["sections"].items) each = of_section(each, false);
    return of;
  }
  Json of_section(Json of, bool outside) {
    of.members["name"] = named("section", of.at("name"));
    for (auto& [_, to] : of.members["routes"].members) to = cases(to, outside);
    of.members["handlers"] = handlers(of.at("handlers"), outside);
    for (Json& each : of.members["left"].items) each.members["to"] = cases(each.at("to"), outside);
    if (!of.members.count("branches")) {
      for (Json& each : of.members["activities"].items) each = activity(each.string);
      return of;
    }
    for (Json& each : of.members["branches"].items) {
      each.members["name"] = named("branch", each.at("name"));
      each.members["graph"] = graph(each.at("graph"));
    }
    for (Json& each : of.members["pauses"].items) {
      each.members["graph"] = graph(each.at("graph"));
      each.members["handlers"] = handlers(each.at("handlers"), false);
    }
    return of;
  }

  // Adds an activity, and all that may produce for it.
  Json activity(const std::string& name) {
    const auto [own, fresh] = known("activity", name);
    if (!fresh) return word(own);
    Json made = *whole_.activities.at(name);
    made.members["name"] = word(own);
    made.members["detects"].items.clear();  // no loss is noticed late
    for (Json& each : made.members["produces"].items) each = resource(each.string);
    Int ways = 0;
    for (Json& each : made.members["alternatives"].items) {
      const std::string way = std::to_string(ways++);
      alternatives[name + '.' + each.at("name").string].push_back(own + '.' + way);
      each.members["name"] = word(way);
      for (Json& consumed : each.members["consumes"].items) consumed = resource(consumed.string);
    }
    robot_.members["activities"].items.push_back(std::move(made));
    return word(own);
  }
  Json resource(const std::string& name) {
    const auto [own, fresh] = known("resource", name);
    if (!fresh) return word(own);
    if (of_.contended[of_.resources.at(name)]) contended.insert(own);
    if (const auto found = whole_.hardware.find(name); found != whole_.hardware.end()) {
      Json made = *found->second;
      made.members["name"] = word(own);
      hardware.push_back(name);
      robot_.members["hardware"].items.push_back(std::move(made));
      return word(own);
    }
    if (const auto found = whole_.software.find(name); found != whole_.software.end()) {
      Json made = *found->second;
      made.members["name"] = word(own);
      robot_.members["software"].items.push_back(std::move(made));
    }
    if (const auto found = of_.producers.find(of_.resources.at(name)); found != of_.producers.end()) activity(of_.activities[found->second].name);
    return word(own);
  }

  const Core& of_;
  const Equipment& whole_;
  Json robot_;
};
