// The Python side of walks and searches.
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <chrono>
#include <iterator>
#include <string>
#include <tuple>

#include "diagrams/store.hpp"
#include "python/module.hpp"
#include "search/lasso.hpp"
#include "search/on_the_fly.hpp"
#include "search/tokens.hpp"

namespace nb = nanobind;
using namespace mcpn;
using namespace mcpn::search;

namespace {

using Given = std::tuple<std::vector<Arc>, std::vector<Arc>, std::uint16_t>;  // need, change, rank
// Literals, marks, target, what fires (anything where it is not said), whether nothing may.
using GivenEdge = std::tuple<std::vector<std::uint32_t>, std::uint64_t, std::uint32_t,
                             std::optional<std::vector<Transition>>, bool>;
using Spoken = std::tuple<std::string, std::vector<std::uint32_t>, std::vector<Arc>, Tokens>;

constexpr std::uint32_t kMostPlaces = 1u << 28;
constexpr std::uint32_t kDeepest = 1000;  // searches recurse into what is nested

constexpr const char* kKinds[] = {"all", "any", "at_most", "dead", "not_dead"};
constexpr const char* kOperators[] = {"goal", "not", "all", "any", "next", "until", "always"};
constexpr std::size_t kOperands[] = {1, 1, 0, 0, 1, 2, 1};  // 0: any number
constexpr const char* kAnswers[] = {"no", "yes", "steps", "bytes", "tokens", "pause"};
constexpr const char* kLassos[] = {"found", "none", "steps", "bytes", "tokens", "pause"};
constexpr const char* kOutcomes[] = {"reached", "unreachable", "states", "bytes", "tokens", "pause"};

void check(const std::vector<Arc>& arcs, std::uint32_t places) {
  for (const auto& [place, weight] : arcs) {
    if (place >= places) throw std::invalid_argument("no such place");
    if (weight > kMost || weight < -kMost) throw std::invalid_argument("a weight beyond what search follows");
  }
}

void check(const Marking& marking, const TokenNet& net) {
  if (marking.size() != net.places) throw std::invalid_argument("one number of tokens for each place");
  for (const Tokens tokens : marking)
    if (tokens < 0 || tokens > kMost) throw std::invalid_argument("tokens beyond what search follows");
}

// Some goals among those of a net.
void check(const Goals& goals, const std::vector<std::uint32_t>& roots, const TokenNet& net) {
  if (goals.watch.size() != net.places) throw std::invalid_argument("goals of another net");
  for (const std::uint32_t root : roots)
    if (root >= goals.nodes.size()) throw std::invalid_argument("no such goal");
}

// How deep a node is nested that stands on others, whose depths are given.
std::uint32_t nested(const std::vector<std::uint32_t>& inside, const std::vector<std::uint32_t>& depths) {
  std::uint32_t deepest = 0;
  for (const std::uint32_t node : inside) deepest = std::max(deepest, depths[node]);
  if (deepest >= kDeepest) throw std::invalid_argument("nested deeper than 1,000");
  return deepest + 1;
}

template <class Body> auto run(Body body) {
  auto due = std::chrono::steady_clock::now() + std::chrono::milliseconds(500);
  const GoOn go_on = [&] {
    const auto now = std::chrono::steady_clock::now();
    if (now < due) return true;
    due = now + std::chrono::milliseconds(500);
    const nb::gil_scoped_acquire acquire;
    return PyErr_CheckSignals() == 0;
  };
  try {
    const nb::gil_scoped_release release;
    return body(go_on);
  } catch (const Interrupted&) {
    throw nb::python_error();
  }
}

}  // namespace

void bind_search(nb::module_& module) {
  nb::class_<Goals>(module, "Goals")
      .def("__init__", [](Goals* self, std::uint32_t places, const std::vector<Spoken>& nodes) {
        if (places > kMostPlaces) throw std::invalid_argument("a net has at most 2^28 places");
        Goals goals(places);
        std::vector<std::uint32_t> depths;
        for (const auto& [kind, inside, terms, bound] : nodes) {
          const auto* known = std::find(std::begin(kKinds), std::end(kKinds), kind);
          if (known == std::end(kKinds)) throw std::invalid_argument("no such kind of goal");
          for (const std::uint32_t node : inside)
            if (node >= goals.nodes.size()) throw std::invalid_argument("a goal names a later one");
          check(terms, places);
          depths.push_back(nested(inside, depths));
          goals.add(Goals::Kind(known - kKinds), inside, terms, bound);
        }
        new (self) Goals(std::move(goals));
      }, nb::arg("places"), nb::arg("nodes"));

  nb::class_<TokenNet>(module, "TokenNet")
      .def("__init__", [](TokenNet* self, std::uint32_t places, const std::vector<Given>& transitions,
                          bool priorities) {
        if (places > kMostPlaces) throw std::invalid_argument("a net has at most 2^28 places");
        std::vector<Rule> rules;
        for (const auto& [need, change, rank] : transitions) {
          check(need, places);
          check(change, places);
          rules.push_back({need, change, rank});
        }
        new (self) TokenNet(places, std::move(rules), priorities);
      }, nb::arg("places"), nb::arg("transitions"), nb::arg("priorities"))
      .def("walk", [](const TokenNet& net, const Marking& initial, const Goals& goals,
                      const std::vector<std::uint32_t>& roots, std::uint64_t steps, std::uint64_t length,
                      std::uint64_t seed, bool unsafe, const std::vector<Tokens>& counts,
                      const std::vector<std::uint32_t>& order) {
        check(initial, net);
        check(goals, roots, net);
        if (!counts.empty() && counts.size() != net.rules.size())
          throw std::invalid_argument("one count for each transition");
        if (!order.empty() && order.size() != net.rules.size())
          throw std::invalid_argument("one number in the order for each transition");
        const std::vector<Reached> found = run([&](const GoOn& go_on) {
          return walk(net, initial, goals, roots, {steps, length, seed, unsafe, counts, order}, go_on);
        });
        std::vector<std::pair<std::uint32_t, std::vector<Transition>>> told;
        told.reserve(found.size());
        for (const Reached& reached : found) told.emplace_back(reached.goal, reached.run);
        return told;
      }, nb::arg("initial"), nb::arg("goals"), nb::arg("roots"), nb::arg("steps"), nb::arg("length"), nb::arg("seed"),
         nb::arg("unsafe") = false, nb::arg("counts") = std::vector<Tokens>{},
         nb::arg("order") = std::vector<std::uint32_t>{})
      .def("seek", [](const TokenNet& net, const Marking& initial, const Goals& goals, std::uint32_t root,
                      bool stubborn) {
        check(initial, net);
        check(goals, {root}, net);
        return seek(net, initial, goals, root, stubborn);
      }, nb::keep_alive<0, 1>(), nb::keep_alive<0, 3>(), nb::arg("initial"), nb::arg("goals"), nb::arg("root"),
         nb::arg("stubborn"))
      .def("plan", [](const TokenNet& net, const Marking& initial, const Goals& goals, std::uint32_t root,
                      std::uint64_t seed) {
        check(initial, net);
        check(goals, {root}, net);
        return plan(net, initial, goals, root, seed);
      }, nb::keep_alive<0, 1>(), nb::keep_alive<0, 3>(), nb::arg("initial"), nb::arg("goals"), nb::arg("root"),
         nb::arg("seed"));

  nb::class_<GoalSearch>(module, "GoalSearch")
      .def("search", [](GoalSearch& search, std::uint64_t max_states, std::uint64_t max_bytes) {
        const Search found = run([&](const GoOn& go_on) { return search.search(max_states, max_bytes, go_on); });
        return std::tuple(std::string(kOutcomes[int(found.outcome)]), found.states, found.run);
      }, nb::arg("max_states"), nb::arg("max_bytes"));

  nb::class_<PathFinder>(module, "PathFinder")
      .def("__init__", [](PathFinder* self, const TokenNet& net, const Marking& initial, const Goals& goals,
                          const std::vector<std::uint32_t>& roots, const std::vector<std::vector<GivenEdge>>& edges,
                          std::uint64_t marks, const std::vector<bool>& accepting_all,
                          const std::vector<std::uint32_t>& components) {
        check(initial, net);
        check(goals, roots, net);
        if (edges.empty() || edges.size() != accepting_all.size() || edges.size() != components.size())
          throw std::invalid_argument("an automaton without states, or not told of each what it accepts");
        Automaton automaton{{}, marks, accepting_all, components};
        for (const std::uint32_t number : components)
          if (number >= edges.size()) throw std::invalid_argument("no such component of the automaton");
        for (const auto& of : edges) {
          auto& told = automaton.edges.emplace_back();
          for (const auto& [literals, bears, target, fired, rests] : of) {
            if (target >= edges.size()) throw std::invalid_argument("no such state of the automaton");
            for (const std::uint32_t literal : literals)
              if (literal >= roots.size()) throw std::invalid_argument("no such literal");
            AutomatonEdge edge{literals, bears & marks, target, !fired, rests, fired.value_or(std::vector<Transition>{})};
            for (const Transition t : edge.fired)
              if (t >= net.rules.size()) throw std::invalid_argument("no such transition");
            std::sort(edge.fired.begin(), edge.fired.end());
            told.push_back(std::move(edge));
          }
        }
        new (self) PathFinder(net, initial, goals, roots, std::move(automaton));
      }, nb::arg("net"), nb::arg("initial"), nb::arg("goals"), nb::arg("roots"), nb::arg("edges"), nb::arg("marks"),
         nb::arg("accepting_all"), nb::arg("components"))
      .def("search", [](PathFinder& finder, std::uint64_t max_steps, std::uint64_t max_bytes, std::uint64_t seed,
                        bool guided, std::uint64_t pause) {
        const Lasso found = run([&](const GoOn& go_on) {
          return finder.search({max_steps, max_bytes, seed, guided}, pause, go_on);
        });
        return std::tuple(std::string(kLassos[int(found.outcome)]), found.run, found.cycle);
      }, nb::arg("max_steps"), nb::arg("max_bytes"), nb::arg("seed"), nb::arg("guided"), nb::arg("pause"));

  nb::class_<Checker>(module, "Checker")
      .def("__init__", [](Checker* self, const TokenNet& net, const Marking& initial, const Goals& goals,
                          const std::vector<std::pair<std::string, std::vector<std::uint32_t>>>& given,
                          std::uint64_t max_bytes) {
        check(initial, net);
        check(goals, {}, net);
        std::vector<Operator> operators;
        std::vector<std::uint32_t> depths;
        for (const auto& [kind, inside] : given) {
          const auto* found = std::find(std::begin(kOperators), std::end(kOperators), kind);
          if (found == std::end(kOperators)) throw std::invalid_argument("no such operator");
          const auto number = std::size_t(found - kOperators), known = number ? operators.size() : goals.nodes.size();
          if (kOperands[number] && inside.size() != kOperands[number])
            throw std::invalid_argument("a wrong number of operands");
          for (const std::uint32_t operand : inside)
            if (operand >= known) throw std::invalid_argument("an operator names a later one, or no goal");
          depths.push_back(number ? nested(inside, depths) : 1);
          operators.push_back({Operator::Kind(number), inside});
        }
        new (self) Checker(net, initial, goals, std::move(operators), max_bytes);
      }, nb::arg("net"), nb::arg("initial"), nb::arg("goals"), nb::arg("operators"), nb::arg("max_bytes"))
      .def("decide", [](Checker& checker, std::uint32_t root, std::uint64_t max_steps, std::uint64_t seed,
                        std::uint64_t pause) {
        if (root >= checker.operators()) throw std::invalid_argument("no such operator");
        const Local found = run([&](const GoOn& go_on) { return checker.decide(root, max_steps, seed, pause, go_on); });
        return std::string(kAnswers[int(found)]);
      }, nb::arg("root"), nb::arg("max_steps"), nb::arg("seed") = 0, nb::arg("pause") = kLook)
      .def_prop_ro("markings", [](const Checker& checker) { return checker.markings(); });
}
