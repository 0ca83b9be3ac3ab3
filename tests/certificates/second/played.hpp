// A type of sections played alone: its states, what they say, and what events lead to.
#pragma once

#include "alone.hpp"
#include "grown.hpp"
#include "play.hpp"

// The states of a type of sections, entered with each hardware that can be out of service.
class Played {
 public:
  Played(const Alone& alone, const Clock& clock, std::size_t& states)
      : core_(alone.core, exits_of(alone)), clock_(clock), states_(states) {
    for (const auto& [name, number] : core_.resources) core_.contended[number] = alone.contended.count(name) > 0;
    const Play play(core_, clock);
    std::vector<std::size_t> may;
    for (std::size_t h = 0; h < core_.hardware.size(); ++h) if (core_.hardware[h].faulty || core_.hardware[h].out) may.push_back(h);
    if (may.size() >= 40) throw Limit("a section with too much hardware");
    for (std::size_t set = 0; set < std::size_t(1) << may.size(); ++set) {
      State before = play.first();
      for (std::size_t i = 0; i < may.size(); ++i) before.hardware[may[i]] = set >> i & 1 ? Part{true, true, false} : Part{};
      std::set<std::string> out;
      for (std::size_t i = 0; i < may.size(); ++i) if (set >> i & 1) out.insert(core_.hardware[may[i]].name);
      const std::size_t entry = numbered(outcome(play, play.happened(before, {"start", ""})));
      entries.emplace_back(std::move(out), entry);
      entries_.insert(entry);
    }
    start_ = numbered(outcome(play, play.happened(play.first(), {"start", ""})));
    for (std::size_t s = 0; s < open_.size(); ++s) {
      const State state = open_[s];
      ways.emplace_back();
      said.push_back(play.look(state));
      for (const Texts& event : play.events(state)) {
        const State after = play.happened(state, event);
        const bool quiet = event[0] != "out of service" && event[0] != "repaired";
        if (after.root.empty()) {
          const auto idle = [](const Doing& each) { return each.does == Does::idle; };
          if (!std::all_of(after.activities.begin(), after.activities.end(), idle)) throw Limit("an activity goes on as a section is left");
          outcome(play, after);
          ways[s].push_back({event, std::size_t(std::stoul(after_target(after))), true, quiet});
        } else {
          ways[s].push_back({event, numbered(outcome(play, after)), false, quiet});
        }
      }
    }
    open_.clear();
  }

  struct Way { Texts event; std::size_t to; bool leaves, quiet; };
  std::vector<std::vector<Way>> ways;
  std::vector<std::set<Role>> said;  // what each state says
  std::vector<std::pair<std::set<std::string>, std::size_t>> entries;  // by what is out of service

  bool goes_on() const { return std::none_of(ways.begin(), ways.end(), [](const auto& each) { return each.empty(); }); }

  using Set = std::vector<bool>;
  using Taken = std::function<bool(const Way&)>;

  // The states that some ways lead to from entries, and from the one with hardware as it is at first.
  Set from_any(const Taken& taken) const { return from(entries_, taken); }
  Set from_first(const Taken& taken) const { return from({start_}, taken); }
  std::size_t first() const { return start_; }
  // The targets that some ways lead to from some states.
  std::set<std::size_t> targets(const Set& from, const Taken& taken) const {
    std::set<std::size_t> found;
    for (std::size_t s = 0; s < ways.size(); ++s)
      if (from[s]) for (const Way& way : ways[s]) if (way.leaves && taken(way)) found.insert(way.to);
    return found;
  }
  std::set<std::size_t> targets() const { return targets(Set(ways.size(), true), [](const Way&) { return true; }); }
  // Those that runs lead to on which no hardware fails and none is repaired, with hardware as it is at first.
  std::set<std::size_t> quiet_targets() const {
    const Taken quiet = [](const Way& way) { return way.quiet; };
    return targets(from_first(quiet), quiet);
  }
  // Whether from each state some run leads to one of these targets.
  bool always_leads_to(const std::set<std::size_t>& good) const {
    std::vector<std::vector<std::size_t>> before(ways.size());
    Set leads(ways.size());
    for (std::size_t s = 0; s < ways.size(); ++s)
      for (const Way& way : ways[s]) {
        if (!way.leaves) before[way.to].push_back(s);
        else if (good.count(way.to)) leads[s] = true;
      }
    leads = grown(std::move(leads), [&](std::size_t s, const auto& add) { for (const std::size_t each : before[s]) add(each); });
    return std::all_of(leads.begin(), leads.end(), [](bool each) { return each; });
  }

 private:
  Set from(const std::set<std::size_t>& some, const Taken& taken) const {
    Set seen(ways.size());
    for (const std::size_t s : some) seen[s] = true;
    return grown(std::move(seen), [&](std::size_t s, const auto& add) { for (const Way& way : ways[s]) if (!way.leaves && taken(way)) add(way.to); });
  }
  static std::set<std::string> exits_of(const Alone& alone) {
    std::set<std::string> found;
    for (std::size_t i = 0; i < alone.targets.size(); ++i) found.insert("target" + std::to_string(i));
    return found;
  }
  static std::string after_target(const State& of) { return of.end.substr(6); }
  static State outcome(const Play& play, State of) {
    auto ends = play.settled(std::move(of));
    if (ends.size() != 1) throw Limit("an entry or an event has no outcome, or several");
    return std::move(ends.begin()->second);
  }
  std::size_t numbered(State state) {
    const auto [at, fresh] = numbers_.emplace(key_of(state), open_.size());
    if (fresh) {
      clock_.look(++states_);
      open_.push_back(std::move(state));
    }
    return at->second;
  }

  Core core_;
  const Clock& clock_;
  std::size_t& states_;
  std::size_t start_ = 0;
  std::set<std::size_t> entries_;
  std::vector<State> open_;
  std::map<std::string, std::size_t> numbers_;
};
