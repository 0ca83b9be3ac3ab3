// Formulas that sections prove: that some state satisfies something, and that a run without some events leads to an end.
#pragma once

#include "section_words.hpp"

class SectionFormulas {
 public:
  explicit SectionFormulas(const Sections& sections)
      : sections_(sections), reached_(sections.reached()), surely_(sections.reached_without_losses()) {}

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
    Truth made = truth_in(Words(std::string("begin")).asked(of), nullptr, 0);
    for (const std::string& name : reached_) {
      if (made == Truth::yes) break;
      const bool surely = surely_.count(name) > 0;
      const auto so = [&](Truth found) { return found == Truth::yes && !surely ? Truth::open : found; };
      if (!sections_.has(name)) {
        made = std::max(made, so(truth_in(Words(ends().at(name)).asked(of), nullptr, 0)));
        continue;
      }
      const Placed& placed = sections_.placed(name);
      const Asked asked = Words(placed).asked(of);
      const auto [at, fresh] = states_.emplace(std::make_pair(placed.type, asked.key()), Truth::no);
      if (fresh) at->second = some_of(asked, sections_.type(placed));
      made = std::max(made, so(at->second));
    }
    return made;
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
    for (std::size_t i = 1; i < happens.size(); ++i) {
      events.push_back(texts(happens[i]));
      const Texts& of = events.back();
      if (of.size() < 2 || (of[0] != "success" && of[0] != "failure" && of[0] != "timeout")) return Truth::open;
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

  const Sections& sections_;
  std::set<std::string> reached_, surely_;
  mutable std::map<std::pair<std::size_t, std::string>, Truth> states_;
};
