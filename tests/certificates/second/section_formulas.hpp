// Formulas that sections prove: that some state satisfies something, and that a run without some events leads to an end.
#pragma once

#include <optional>

#include "section_words.hpp"

class SectionFormulas {
 public:
  explicit SectionFormulas(const Sections& sections)
      : sections_(sections), reached_(sections.reached()), surely_(sections.reached_without_losses()) {
    for (const std::string& name : reached_) {
      if (!sections.has(name)) {
        alike_[name].push_back(name);
        continue;
      }
      const Placed& placed = sections.placed(name);
      const bool surely = surely_.count(name) > 0;
      std::string shared = std::to_string(placed.type) + (surely ? "!" : "?");
      for (const auto& [kind, names] : placed.names) {
        const bool everywhere = kind == "resource" || kind == "event";
        for (const auto& [word, own] : names) {
          if (everywhere) shared += kind + ' ' + std::to_string(word.size()) + word + std::to_string(own.size()) + own;
          else having_[word].insert(name);
        }
      }
      for (const auto& [word, _] : placed.alternatives) having_[word].insert(name);
      alike_[shared].push_back(name);
    }
  }

  Truth truth(const Json& formula) const {
    const auto& parts = formula.items;
    const std::string& op = parts[0].string;
    if (op == "not") return !truth(parts[1]);
    if (op == "EU") return nothing(parts[1]) ? some_state(parts[2]) : Truth::open;
    if (op != "E" || parts[1].items[0].string != "U") return Truth::open;
    const Json &before = parts[1].items[1], &goal = parts[1].items[2];
    if (nothing(before)) return some_state(goal);
    if (before.items[0].string != "not" || before.items[1].items[0].string != "happens") return Truth::open;
    return run_without(before.items[1].items, goal);
  }

 private:
  static const std::map<std::string, std::string>& ends() {
    static const std::map<std::string, std::string> made{{"succeed", "success"}, {"fail", "failure"}, {"abort", "abort"}};
    return made;
  }
  static bool nothing(const Json& of) { return of.items.size() == 1 && of.items[0].string == "and"; }

  Truth some_state(const Json& of) const {
    std::set<std::string> asked;
    having(of, asked);
    Truth made = truth_in(Words(std::string("begin")).asked(of), nullptr, 0);
    for (const std::string& name : asked) made = std::max(made, in(name, of));
    for (const auto& [_, names] : alike_) {  // of which none has a word of the formula, but for hardware: one stands for all
      const auto one = std::find_if(names.begin(), names.end(), [&](const std::string& name) { return !asked.count(name); });
      if (made != Truth::yes && one != names.end()) made = std::max(made, in(*one, of));
    }
    return made;
  }
  // The sections that have a word of a formula among their names, but for those of hardware and declared events.
  void having(const Json& of, std::set<std::string>& found) const {
    if (const auto at = having_.find(of.string); of.kind == Json::text && at != having_.end()) found.insert(at->second.begin(), at->second.end());
    for (const Json& each : of.items) having(each, found);
  }
  // Whether some state of a section, or an end, satisfies something.
  Truth in(const std::string& name, const Json& of) const {
    const bool surely = surely_.count(name) > 0;
    const auto so = [&](Truth found) { return found == Truth::yes && !surely ? Truth::open : found; };
    if (!sections_.has(name)) return so(truth_in(Words(ends().at(name)).asked(of), nullptr, 0));
    const Placed& placed = sections_.placed(name);
    const Asked asked = Words(placed).asked(of);
    const auto [at, fresh] = states_.emplace(std::make_pair(placed.type, asked.key()), Truth::no);
    if (fresh) at->second = some_of(asked, sections_.type(placed));
    return so(at->second);
  }
  // Whether some state does for sure that is reached with hardware as it is at first, or some state may.
  static Truth some_of(const Asked& of, const Played& type) {
    const Played::Set first = type.from_first([](const Played::Way&) { return true; });
    Truth made = Truth::no;
    for (std::size_t s = 0; s < first.size(); ++s) {
      const Truth found = truth_in(of, &type, s);
      made = std::max(made, found == Truth::yes && !first[s] ? Truth::open : found);
    }
    return made;
  }

  Truth run_without(const std::vector<Json>& happens, const Json& goal) const {
    std::set<std::string> goals;
    const auto add = [&](const Json& of) {
      if (of.items[0].string != "says") return false;
      for (const auto& [exit, role] : ends()) if (of.items[1].string == role) { goals.insert(exit); return true; }
      return false;
    };
    if (goal.items[0].string == "or") {
      for (std::size_t i = 1; i < goal.items.size(); ++i) if (!add(goal.items[i])) return Truth::open;
    } else if (!add(goal)) {
      return Truth::open;
    }
    std::vector<Texts> events;
    std::set<std::string> asked;
    for (std::size_t i = 1; i < happens.size(); ++i) {
      having(happens[i], asked);
      events.push_back(texts(happens[i]));
      const Texts& of = events.back();
      if (of.size() < 2 || (of[0] != "success" && of[0] != "failure" && of[0] != "timeout")) return Truth::open;
    }
    for (const std::string& goal : goals) {
      const Way& way = way_to(goal);
      if (way && std::none_of(asked.begin(), asked.end(), [&](const std::string& each) { return way->count(each) > 0; })) return Truth::yes;
    }
    const auto comes = [&](bool sure) {
      std::map<std::pair<std::size_t, std::set<Texts>>, std::set<std::size_t>> known;
      const std::set<std::string> led = sections_.led([&](const Placed& placed) {
        std::set<Texts> own;
        for (const Texts& each : events) for (const Texts& event : Words(placed).event(each)) own.insert(event);
        const auto [at, fresh] = known.emplace(std::make_pair(placed.type, own), std::set<std::size_t>());
        if (fresh) {
          const Played& type = sections_.type(placed);
          const auto taken = [&](const Played::Way& way) { return (way.quiet || !sure) && !own.count(way.event); };
          at->second = type.targets(sure ? type.from_first(taken) : type.from_any(taken), taken);
        }
        return at->second;
      });
      return std::any_of(goals.begin(), goals.end(), [&](const std::string& each) { return led.count(each) > 0; });
    };
    return comes(true) ? Truth::yes : comes(false) ? Truth::open : Truth::no;
  }

  // The sections of some way to an end on which no hardware fails and none is repaired.
  using Way = std::optional<std::set<std::string>>;
  const Way& way_to(const std::string& end) const {
    const auto [at, fresh] = ways_.emplace(end, Way());
    if (!fresh) return at->second;
    std::map<std::string, std::string> before{{sections_.entry(), ""}};
    std::vector<std::string> open{sections_.entry()};
    std::map<std::size_t, std::set<std::size_t>> quiet;  // by type
    for (std::size_t i = 0; i < open.size() && !before.count(end); ++i) {
      const std::string from = open[i];
      if (!sections_.has(from)) continue;
      const Placed& placed = sections_.placed(from);
      const auto [found, first] = quiet.emplace(placed.type, std::set<std::size_t>());
      if (first) found->second = sections_.type(placed).quiet_targets();
      for (const std::size_t each : found->second)
        if (before.emplace(placed.targets[each], from).second) open.push_back(placed.targets[each]);
    }
    if (before.count(end)) {
      at->second.emplace();
      for (std::string each = before.at(end); !each.empty(); each = before.at(each)) at->second->insert(each);
    }
    return at->second;
  }

  const Sections& sections_;
  std::set<std::string> reached_, surely_;
  std::map<std::string, std::set<std::string>> having_;       // by a word the sections that have it
  std::map<std::string, std::vector<std::string>> alike_;  // sections that are alike but for their own words
  mutable std::map<std::pair<std::size_t, std::string>, Truth> states_;
  mutable std::map<std::string, Way> ways_;
};
