// What formulas ask, in the words of a section: true, false, or not known of a state of its type, or of one outside of all sections.
#pragma once

#include "sections.hpp"

enum class Truth { no, open, yes };

// A formula in the words of one section.
struct Asked {
  enum Op { known, says, fires, negation, all, any } op = known;
  Truth truth = Truth::open;  // of what is known everywhere; of `fires` what is so where none of the events is possible
  std::set<Role> roles;
  std::set<Texts> events;
  std::vector<Asked> parts;

  std::string key() const {
    std::string made{char('a' + int(op)), char('a' + int(truth))};
    const auto add = [&](const std::string& word) { made += std::to_string(word.size()) + ':' + word; };
    for (const Role& role : roles) { add(role.first); add(role.second); }
    for (const Texts& event : events) { made += ';'; for (const std::string& word : event) add(word); }
    for (const Asked& each : parts) made += '(' + each.key() + ')';
    return made;
  }
};

inline Truth operator!(Truth of) { return of == Truth::yes ? Truth::no : of == Truth::no ? Truth::yes : Truth::open; }

// The words of a section, or of where no section is: before the start, and at ends, of which the role is said.
class Words {
 public:
  explicit Words(const Placed& of) : of_(&of) {}
  explicit Words(const std::string& role) : role_(role) {}

  Asked asked(const Json& formula) const {
    const auto& parts = formula.items;
    const std::string& op = parts[0].string;
    Asked made;
    if (op == "says") return says(parts[1].string, parts[2].string);
    if (op == "fires") return fires(parts);
    if (op == "E" && parts[1].items[0].string == "happens") return fires(parts[1].items);
    if (op != "not" && op != "and" && op != "or") return made;
    if (op == "not") {
      const Asked part = asked(parts[1]);
      return part.op == Asked::known ? is(!part.truth) : Asked{Asked::negation, Truth::open, {}, {}, {part}};
    }
    made.op = op == "and" ? Asked::all : Asked::any;
    const Truth decides = op == "and" ? Truth::no : Truth::yes;
    for (std::size_t i = 1; i < parts.size(); ++i) {  // most of what is asked is of other sections, and known
      Asked part = asked(parts[i]);
      if (part.op != Asked::known || part.truth == Truth::open) made.parts.push_back(std::move(part));
      else if (part.truth == decides) return part;
    }
    return made.parts.empty() ? is(!decides) : made;
  }
  // An event of the section in its own words; none where it has no such event.
  std::vector<Texts> event(Texts of) const {
    static const std::map<std::string, std::string> kinds{
        {"success", "section"}, {"failure", "section"}, {"timeout", "section"}, {"declared", "event"},
        {"out of service", "resource"}, {"repaired", "resource"}, {"detected", "resource"}};
    if (of.size() < 2) return {};
    if (!of_) return role_ == "begin" && of == Texts{"start", ""} ? std::vector<Texts>{of} : std::vector<Texts>{};
    const auto kind = kinds.find(of[0]);
    if (kind == kinds.end()) return {};
    for (const std::string& own : named(kind->second, of[1])) return {of.size() == 3 ? Texts{of[0], own, of[2]} : of.size() == 2 ? Texts{of[0], own} : Texts{}};
    return {};
  }

 private:
  static Asked is(Truth truth) { return {Asked::known, truth, {}, {}, {}}; }
  // The names here of what the mission has under a name.
  Texts named(const std::string& kind, const std::string& name) const {
    if (!of_) return {};
    const auto of_kind = of_->names.find(kind);
    if (of_kind == of_->names.end()) return {};
    const auto found = of_kind->second.find(name);
    return found == of_kind->second.end() ? Texts{} : Texts{found->second};
  }
  Asked says(const std::string& role, const std::string& element) const {
    static const std::map<std::string, std::string> kinds{
        {"objective", "section"}, {"pending", "section"}, {"done", "branch"}, {"refused", "activity"}, {"oos", "resource"}};
    static const std::set<std::string> others{"begin", "success", "failure", "abort"};
    Asked made;
    made.op = Asked::says;
    const bool alternative = role == "active" || role == "wait" || role == "want", ends = others.count(role) > 0;
    const auto kind = kinds.find(role);
    if (!alternative && !ends && kind == kinds.end()) return {};
    if (role == "oos" && named("resource", element).empty()) return {};
    if (ends && !of_ && role == role_) return is(Truth::yes);
    Texts own;
    if (kind != kinds.end()) own = named(kind->second, element);
    else if (alternative && of_)
      if (const auto found = of_->alternatives.find(element); found != of_->alternatives.end()) own = found->second;
    for (const std::string& each : own) made.roles.emplace(role == "want" ? "wait" : role, each);
    return own.empty() ? is(Truth::no) : made;
  }
  Asked fires(const std::vector<Json>& parts) const {
    Asked made;
    made.op = Asked::fires;
    made.truth = Truth::no;
    for (std::size_t i = 1; i < parts.size(); ++i) {
      const Texts of = texts(parts[i]);
      const bool hardware = of.size() > 1 && (of[0] == "out of service" || of[0] == "repaired" || of[0] == "detected");
      if (hardware && named("resource", of[1]).empty()) made.truth = Truth::open;
      for (const Texts& own : event(of)) {
        made.events.insert(own);
        if (!of_) return is(Truth::yes);
      }
    }
    return made.events.empty() ? is(made.truth) : made;
  }

  const Placed* of_ = nullptr;
  std::string role_;
};

// What a state of a type says, or, without one, what is so outside of all sections.
inline Truth truth_in(const Asked& of, const Played* type, std::size_t state) {
  switch (of.op) {
    case Asked::known: return of.truth;
    case Asked::says: {
      const auto is = [&](const Role& role) { return type->said[state].count(role) > 0; };
      return type && std::any_of(of.roles.begin(), of.roles.end(), is) ? Truth::yes : Truth::no;
    }
    case Asked::fires: {
      const auto is = [&](const Played::Way& way) { return of.events.count(way.event) > 0; };
      return type && std::any_of(type->ways[state].begin(), type->ways[state].end(), is) ? Truth::yes : of.truth;
    }
    case Asked::negation: return !truth_in(of.parts[0], type, state);
    case Asked::all: {
      Truth made = Truth::yes;
      for (const Asked& each : of.parts) made = std::min(made, truth_in(each, type, state));
      return made;
    }
    case Asked::any: {
      Truth made = Truth::no;
      for (const Asked& each : of.parts) made = std::max(made, truth_in(each, type, state));
      return made;
    }
  }
  return Truth::open;
}
