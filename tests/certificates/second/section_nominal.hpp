// Nominal success by sections: where successes, and failures that are meant, lead from one section to the next.
#pragma once

#include "sections.hpp"

// Whether steps from the first state never come back; `next` is given a state and calls back with those that a step leads to.
template <class Key, class Next> bool comes_to_an_end(const Key& first, const Next& next) {
  enum class Met { underway, done };
  std::map<Key, Met> met;
  struct Frame { Key at; std::vector<Key> left; };
  std::vector<Frame> stack;
  const auto enter = [&](const Key& at) {
    met.emplace(at, Met::underway);
    stack.push_back({at, {}});
    next(at, [&](const Key& to) { stack.back().left.push_back(to); });
  };
  enter(first);
  while (!stack.empty()) {
    Frame& top = stack.back();
    if (top.left.empty()) {
      met[top.at] = Met::done;
      stack.pop_back();
      continue;
    }
    const Key to = top.left.back();
    top.left.pop_back();
    const auto found = met.find(to);
    if (found == met.end()) enter(to);
    else if (found->second == Met::underway) return false;
  }
  return true;
}

class SectionNominal {
 public:
  explicit SectionNominal(const Sections& sections) : sections_(sections) {}

  bool holds(const Json& statement) const {
    if (!texts(statement.at("endless")).empty() || !texts(statement.at("repaired")).empty()) return false;
    const Texts named = texts(statement.at("fails")), meant = texts(statement.at("meant"));
    const std::set<std::string> fails(named.begin(), named.end());
    std::map<Key, Way> known;
    std::set<std::string> run;
    bool fine = true;
    const bool ends = comes_to_an_end(sections_.entry(), [&](const std::string& name, const auto& leads) {
      if (!sections_.has(name)) {
        fine = fine && name == "succeed";
        return;
      }
      const Placed& placed = sections_.placed(name);
      const auto& names = placed.names.at("section");
      std::set<std::string> own;
      for (const auto& [each, here] : names) if (fails.count(each)) own.insert(here);
      const auto [at, fresh] = known.emplace(Key{placed.type, own}, Way());
      if (fresh) at->second = way_through(sections_.type(placed), own);
      fine = fine && at->second.fine;
      for (const auto& [each, here] : names) if (at->second.run.count(here)) run.insert(each);
      for (const std::size_t each : at->second.targets) leads(placed.targets[each]);
    });
    return fine && ends && std::all_of(meant.begin(), meant.end(), [&](const std::string& each) { return run.count(each) > 0; });
  }

 private:
  using Key = std::pair<std::size_t, std::set<std::string>>;
  struct Way { bool fine = true; std::set<std::size_t> targets; std::set<std::string> run; };

  static Way way_through(const Played& type, const std::set<std::string>& fails) {
    const auto nominal = [&](const Played::Way& way) { return way.event[0] == "success" ? !fails.count(way.event[1]) : way.event[0] == "failure" && fails.count(way.event[1]); };
    Way made;
    made.fine = comes_to_an_end(type.first(), [&](std::size_t s, const auto& leads) { for (const auto& way : type.ways[s]) if (nominal(way) && !way.leaves) leads(way.to); });
    const Played::Set on_the_way = type.from_first(nominal);
    made.targets = type.targets(on_the_way, nominal);
    for (std::size_t s = 0; s < on_the_way.size(); ++s) {
      if (!on_the_way[s]) continue;
      made.fine = made.fine && std::any_of(type.ways[s].begin(), type.ways[s].end(), nominal);
      for (const Role& role : type.said[s]) if (role.first == "objective") made.run.insert(role.second);
    }
    return made;
  }

  const Sections& sections_;
};
