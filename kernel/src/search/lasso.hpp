// Is a path of a net accepted by an automaton? Asked of the product of both, marking by marking as it is needed.
//
// A depth-first search in a drawn order, which ends at the first component that meets all marks (J.-M. Couvreur,
// On-the-fly verification of linear temporal logic, FM 1999): it closes a lasso as a walk does, and has seen that
// there is none where it comes to its end. A marking in which nothing may fire repeats for ever.
#pragma once

#include <memory>
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
  std::vector<std::uint32_t> components;          // by state: the number of its strongly connected component
};

// What is asked: a path from the initial marking that an automaton accepts, whose literals are roots among the goals.
struct PathTask {
  TokenNet net;
  Marking initial;
  Goals goals;
  std::vector<std::uint32_t> roots;
  Automaton automaton;
};

struct LassoOptions {
  std::uint64_t max_steps, max_bytes, seed;
  bool guided;  // greedily by the additive heuristic of planning, or depth first
  bool operator==(const LassoOptions&) const = default;
};

struct Lasso {
  enum Outcome : std::uint8_t { found, none, steps, bytes, tokens, pause } outcome;
  std::vector<Transition> run{};            // of an accepted path, up to where it repeats or is decided, or ends
  std::optional<std::size_t> cycle{};       // where the part begins that repeats, if one does
};

// A search under way.
class LassoSearch {
 public:
  virtual ~LassoSearch() = default;
  virtual Lasso go_on(std::uint64_t steps, const GoOn& still) = 0;
};

// Greedily, in legs: to where the automaton may accept, round by all marks, and back to where that began.
std::unique_ptr<LassoSearch> guided(const PathTask& task, std::uint32_t bits, const LassoOptions& options);

class PathFinder {
 public:
  PathFinder(TokenNet net, Marking initial, Goals goals, std::vector<std::uint32_t> roots, Automaton automaton);
  ~PathFinder();

  // Rests after so many steps to a pause: asked the same again, it goes on from there; asked otherwise, it begins anew.
  Lasso search(const LassoOptions& options, std::uint64_t pause, const GoOn& still);

 private:
  void begin(const LassoOptions& options, std::size_t width);

  PathTask task_;
  LassoOptions options_{};
  std::size_t width_ = 0;  // of kWidths
  std::unique_ptr<LassoSearch> search_;
};

}  // namespace mcpn::search
