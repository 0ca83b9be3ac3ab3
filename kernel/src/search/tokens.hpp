// Nets with any number of tokens in a place, and goals on their markings, as walks and searches see them.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

namespace mcpn::search {

using Place = std::uint32_t;
using Transition = std::uint32_t;
using Tokens = std::int64_t;
using Marking = std::vector<Tokens>;
using Arc = std::pair<Place, Tokens>;  // a place, and a weight or a change

constexpr Tokens kMost = Tokens(1) << 31;  // more tokens in a place are not followed
// Weights of a sum, signs aside: a firing from at most kMost tokens leaves it below 2^61, and bounds are moved to 2^62.
constexpr Tokens kMostWeights = Tokens(1) << 29, kFarBound = Tokens(1) << 62;
constexpr Tokens kFar = Tokens(1) << 40;   // the distance to what can never hold

// A transition: enabled where each place holds what it needs; firing changes places by so much.
struct Rule {
  std::vector<Arc> need, change;
  std::uint16_t rank = 0;  // with priorities, those of the lowest rank that is enabled may fire
};

class TokenNet {
 public:
  TokenNet(std::uint32_t places, std::vector<Rule> rules, bool priorities);

  bool enabled(const Marking& marking, Transition t) const {
    for (const auto& [place, weight] : rules[t].need)
      if (marking[place] < weight) return false;
    return true;
  }
  // The transitions that may fire, priorities respected, in their order.
  void collect(const Marking& marking, std::vector<Transition>& found) const;

  std::uint32_t places;
  std::vector<Rule> rules;
  bool priorities;
  std::vector<std::uint16_t> order;  // by transition, the place of its rank among those that there are
  std::size_t ranks = 1;
  std::vector<std::vector<std::pair<Transition, Tokens>>> users;  // by place: who needs it, and how much
  std::vector<std::vector<Transition>> raisers, lowerers;         // by place

 private:
  std::vector<std::vector<Transition>> keyed_;  // by the least wanted of the places that they need
  std::vector<Transition> always_;              // those that need none
};

// Boolean combinations of bounds on weighted sums of tokens, and of "nothing may fire".
class Goals {
 public:
  enum Kind : std::uint8_t { all, any, at_most, dead, not_dead };
  struct Node {
    Kind kind;
    std::uint32_t atom;               // of at_most
    std::vector<std::uint32_t> inside;  // of all and any; they stand before this node
  };

  explicit Goals(std::uint32_t places) : watch(places) {}

  // Adds a node, and returns its number.
  std::uint32_t add(Kind kind, std::vector<std::uint32_t> inside, std::vector<Arc> terms, Tokens bound);

  // How far sums of tokens are from a goal; 0 where it holds. `enabled`: how many transitions may fire.
  Tokens distance(std::uint32_t node, const std::vector<Tokens>& sums, std::uint64_t enabled) const;
  bool holds(std::uint32_t node, const std::vector<Tokens>& sums, std::uint64_t enabled) const;
  std::vector<Tokens> sums(const Marking& marking) const;
  void atoms(std::uint32_t node, std::vector<std::uint32_t>& found) const;  // that a goal is made of
  bool asks_dead(std::uint32_t node) const;

  std::vector<Node> nodes;
  std::vector<Tokens> bounds;            // by atom
  std::vector<std::vector<Arc>> terms;   // by atom
  std::vector<std::vector<std::pair<std::uint32_t, Tokens>>> watch;  // by place: atoms that it counts in
};

using GoOn = std::function<bool()>;  // asked now and then; false ends the work by Interrupted

struct WalkOptions {
  std::uint64_t steps, length, seed;  // firings in all, those tried included; before a walk begins anew
  bool unsafe;                        // also look for a second token in a place
  std::vector<Tokens> counts;         // how often each transition should fire, if there is a proposal
  std::vector<std::uint32_t> order;   // a place for each transition, if walks to a deadlock are to begin by that order
};
struct Reached {
  std::uint32_t goal;  // its number in the list of roots; as many as there are roots: the unsafe firing
  std::vector<Transition> run;
};

// Walks from the initial marking, by turns random, towards one goal, and by a drawn order of transitions.
std::vector<Reached> walk(const TokenNet& net, const Marking& initial, const Goals& goals,
                          const std::vector<std::uint32_t>& roots, const WalkOptions& options, const GoOn& go_on);

enum class Outcome : std::uint8_t { reached, unreachable, states, bytes, tokens, pause };
struct Search {
  Outcome outcome;
  std::uint64_t states = 0;
  std::vector<Transition> run{};
};

// A search that rests now and then, and ends at a limit: asked again, it goes on from there.
class GoalSearch {
 public:
  virtual ~GoalSearch() = default;
  virtual Search search(std::uint64_t max_states, std::uint64_t max_bytes, const GoOn& go_on) = 0;
};

// Both keep the net and the goals by reference.
// Best first from the initial marking, nearest to the goal first; with stubborn sets where so asked.
std::unique_ptr<GoalSearch> seek(const TokenNet& net, const Marking& initial, const Goals& goals, std::uint32_t root,
                                 bool stubborn);

// Greedy best first by the additive heuristic of planning, with no stubborn sets: finds runs where `seek` is lost.
// `draws` orders what is equally near.
std::unique_ptr<GoalSearch> plan(const TokenNet& net, const Marking& initial, const Goals& goals, std::uint32_t root,
                                 std::uint64_t draws);

}  // namespace mcpn::search
