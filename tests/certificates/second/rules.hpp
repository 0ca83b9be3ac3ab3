// The rules of a type of sections: a state is some bits, and the rules of an event that fit it have one effect and the parts that follow.
#pragma once

#include "document.hpp"

using Bits = std::vector<bool>;

// What an event has made of a state: its bits, the actions in order, and the outcome where the section is left.
struct Ruled { Bits bits; std::vector<const Json*> actions; std::string outcome; };

class Rules {
 public:
  explicit Rules(const Json& type) : of_(type), bits_(whole(type.at("bits"))) {
    require(bits_ >= 0 && bits_ < 1'000'000, "a state of no number of bits");
    for (const Json& each : list(type.at("rules"))) by_event_[whole(each.at("event"))].push_back(&each);
    for (const Json& each : list(type.at("entries"))) entries_.push_back(&each);
    const std::size_t known = list(type.at("hardware")).size() + list(type.at("once")).size() + list(type.at("facts")).size();
    require(list(type.at("status")).size() == known, "another number of what has a status");
    for (const Json& each : list(type.at("idle"))) bit(each);
    for (const Json& each : list(type.at("status"))) { bits_of(each.at("changes")); literals({whole(each.at("when"))}, 1); }
    static const std::set<std::string> kinds{"objectives", "pending", "done", "mode", "waiting", "refused"};
    for (const Json& each : list(type.at("shown"))) {
      require(kinds.count(text(each.at("kind"))), "something of no kind is shown");
      literals({whole(each.at("when"))}, 1);
    }
    for (const Json& each : list(type.at("effects"))) {
      bits_of(each.at("changes"));
      for (const Int part : numbers(each.at("then"))) item(type.at("parts"), part);
    }
    for (const char* key : {"entries", "rules"}) for (const Json& each : list(type.at(key))) rule(each, 1);
    for (const auto& [event, _] : by_event_) item(type.at("events"), event);
    for (const Json& part : list(type.at("parts")))
      for (const Json& each : list(part)) require(list(rule(each, 2).at("then")).empty(), "a part that goes on with parts");
  }

  // The state before the entry, of what is so of hardware, of handlers, and of facts.
  Bits idle(const std::vector<bool>& so) const {
    Bits made(std::size_t(bits_), false);
    for (const Json& each : list(of_.at("idle"))) made[bit(each)] = true;
    for (std::size_t i = 0; i < so.size(); ++i) if (so[i]) change(made, of_.at("status").items[i].at("changes"));
    return made;
  }
  // What a state says of hardware, of handlers, and of facts.
  std::vector<bool> status(const Bits& state) const {
    std::vector<bool> made;
    for (const Json& each : of_.at("status").items) made.push_back(is(whole(each.at("when")), state, nullptr));
    return made;
  }
  // Calls with the kind and the name of each thing that a state shows.
  template <class Visit> void shown(const Bits& state, const Visit& visit) const {
    for (const Json& each : list(of_.at("shown")))
      if (is(whole(each.at("when")), state, nullptr)) visit(text(each.at("kind")), text(each.at("name")));
  }
  std::unique_ptr<Ruled> entered(const Bits& idle) const { return taken(idle, entries_); }
  std::unique_ptr<Ruled> after(const Bits& state, Int event) const {
    const auto found = by_event_.find(event);
    return found == by_event_.end() ? nullptr : taken(state, found->second);
  }

 private:
  std::size_t bit(const Json& of) const {
    require(whole(of) >= 0 && whole(of) < bits_, "a bit that is not there");
    return std::size_t(whole(of));
  }
  std::set<std::size_t> bits_of(const Json& of) const {
    std::set<std::size_t> found;
    for (const Json& each : list(of)) found.insert(bit(each));
    return found;
  }
  void change(Bits& state, const Json& bits) const {
    for (const std::size_t each : bits_of(bits)) state[each] = !state[each];
  }
  // Questions to the bits of a state, or of two; to none of them twice.
  void literals(const Numbers& of, Int states) const {
    std::set<Int> asked;
    for (const Int each : of) {
      require(each >= 0 && each / 2 < states * bits_, "a question to a bit that is not there");
      require(asked.insert(each / 2).second, "a rule that asks a bit twice");
    }
  }
  // The effect of a rule that asks the bits of a state, or of two.
  const Json& rule(const Json& of, Int states) const {
    literals(numbers(of.at("if")), states);
    return item(of_.at("effects"), whole(of.at("do")));
  }
  // Whether a literal is true; those of bits from their number on ask what the effects so far have made of a state.
  bool is(Int literal, const Bits& before, const Bits* now) const {
    const Int asked = literal / 2;
    return (asked < bits_ ? before[std::size_t(asked)] : (*now)[std::size_t(asked - bits_)]) == (literal % 2 == 1);
  }
  bool fits(const Json& rule, const Bits& before, const Bits* now) const {
    const Numbers asked = numbers(rule.at("if"));
    return std::all_of(asked.begin(), asked.end(), [&](Int each) { return is(each, before, now); });
  }
  std::unique_ptr<Ruled> taken(const Bits& before, const std::vector<const Json*>& rules) const {
    const Json* effect = nullptr;
    for (const Json* rule : rules) {
      if (!fits(*rule, before, nullptr)) continue;
      const Json& its = item(of_.at("effects"), whole(rule->at("do")));
      agree(!effect || same(*effect, its), "two rules of one event have other effects");
      effect = &its;
    }
    if (!effect) return nullptr;
    auto made = std::make_unique<Ruled>(Ruled{before, {}, ""});
    does(*made, *effect);
    for (const Int part : numbers(effect->at("then"))) {
      for (const Json& rule : list(item(of_.at("parts"), part))) {
        if (!fits(rule, before, &made->bits)) continue;
        does(*made, item(of_.at("effects"), whole(rule.at("do"))));
        break;
      }
    }
    return made;
  }
  void does(Ruled& to, const Json& effect) const {
    change(to.bits, effect.at("changes"));
    for (const Json& each : list(effect.at("actions"))) to.actions.push_back(&each);
    if (effect.at("to").kind == Json::null) return;
    agree(to.outcome.empty() || to.outcome == text(effect.at("to")), "a section is left with two outcomes");
    to.outcome = text(effect.at("to"));
  }

  const Json& of_;
  Int bits_;
  std::map<Int, std::vector<const Json*>> by_event_;
  std::vector<const Json*> entries_;
};
