// Is a path of a net accepted by an automaton? Asked of the product of both, marking by marking as it is needed.
//
// A depth-first search in a drawn order, which ends at the first component that meets all marks (J.-M. Couvreur,
// On-the-fly verification of linear temporal logic, FM 1999): it closes a lasso as a walk does, and has seen that
// there is none where it comes to its end. A marking in which nothing may fire repeats for ever.
#pragma once

#include <optional>
#include <vector>

#include "search/tokens.hpp"

namespace mcpn::search {

// An edge of a generalised Büchi automaton: what holds in the marking that it reads, and what fires.
struct AutomatonEdge {
  std::vector<std::uint32_t> literals;  // numbers of roots among the goals
  std::uint64_t marks;
  std::uint32_t target;
  bool any, rests;                 // whether anything may fire along it; whether it is taken where nothing fires
  std::vector<Transition> fired;   // what may, in ascending order, if not anything
};

struct Automaton {
  std::vector<std::vector<AutomatonEdge>> edges;  // by state; the initial one is 0
  std::uint64_t marks;                            // those that an accepted path meets again and again
  std::vector<bool> accepting_all;                // states from which every path is accepted
};

struct LassoOptions {
  std::uint64_t max_steps, max_bytes, seed;
};

struct Lasso {
  enum Outcome : std::uint8_t { found, none, steps, bytes, tokens } outcome;
  std::uint64_t states = 0;                 // of the product
  std::vector<Transition> run{};            // of an accepted path, up to where it repeats or is decided, or ends
  std::optional<std::size_t> cycle{};       // where the part begins that repeats, if one does
};

Lasso find_lasso(const TokenNet& net, const Marking& initial, const Goals& goals,
                 const std::vector<std::uint32_t>& roots, const Automaton& automaton, const LassoOptions& options,
                 const GoOn& go_on);

}  // namespace mcpn::search
