// The Python side of explicit exploration: nets in, numpy arrays out.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <tuple>

#include "diagrams/store.hpp"
#include "markings/counted.hpp"
#include "markings/explorer.hpp"
#include "markings/passages.hpp"
#include "markings/settling.hpp"
#include "python/module.hpp"

namespace nb = nanobind;
using namespace mcpn;

namespace {

using Places = std::vector<std::uint32_t>;
using Arcs = std::vector<std::tuple<std::uint32_t, std::int64_t>>;
using Counted = std::tuple<Arcs, Arcs, std::uint16_t>;          // need, change, rank
using Field = std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>;  // word, shift, width
using Given = std::tuple<Places, Places, Places, std::uint16_t, bool>;  // need, take, put, rank, overflow

// The values of a vector as an array, which owns them from now on.
template <class T, class Where>
nb::ndarray<nb::numpy, T> array(std::vector<T, Where>&& values, std::uint64_t columns = 0) {
  auto* kept = new std::vector<T, Where>(std::move(values));
  const nb::capsule owner(kept, [](void* p) noexcept { delete static_cast<std::vector<T, Where>*>(p); });
  if (columns == 0) return {kept->data(), {kept->size()}, owner};
  return {kept->data(), {kept->size() / columns, std::size_t(columns)}, owner};
}

template <class T> nb::ndarray<nb::numpy, T> array(Appended<T>&& values) {
  const std::size_t size = values.size();
  values.reserve(size);
  T* data = values.release();
  return {data, {size}, nb::capsule(data, [](void* p) noexcept { std::free(p); })};
}

template <class T> using Column = nb::ndarray<const T, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

using Rows = nb::ndarray<const Word, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

template <class Explore> auto run(Explore body, std::uint64_t max_states, std::uint64_t max_bytes,
                                         const nb::object& progress) {
  auto due = std::chrono::steady_clock::now() + std::chrono::seconds(1);
  bool stopped = false;
  const Limits limits{max_states, max_bytes, [&](std::uint64_t states, std::uint64_t edges) {
    const auto now = std::chrono::steady_clock::now();
    if (now < due) return true;
    due = now + std::chrono::milliseconds(500);
    const nb::gil_scoped_acquire acquire;
    stopped = PyErr_CheckSignals() != 0;
    if (!stopped && !progress.is_none()) {
      PyObject* told = PyObject_CallFunction(progress.ptr(), "KK", static_cast<unsigned long long>(states),
                                             static_cast<unsigned long long>(edges));
      Py_XDECREF(told);
      stopped = told == nullptr;
    }
    return !stopped;
  }};
  try {
    const nb::gil_scoped_release release;
    return body(limits);
  } catch (const Interrupted&) {
    throw nb::python_error();
  }
}

// An exploration that goes on when it is asked to, and that another thread may end.
class PyExplorer {
 public:
  PyExplorer(const SafeNet& net, const Places& initial, std::uint64_t max_bytes, bool edges)
      : explorer_(net, initial, edges ? Edges::kIfRoom : Edges::kNone, {~std::uint64_t(0), max_bytes, [this](std::uint64_t, std::uint64_t) { return go_on(); }}) {}

  bool run(std::uint64_t max_firings) {
    if (taken_) throw std::invalid_argument("the exploration was taken");
    if (busy_.exchange(true)) throw std::invalid_argument("the exploration is under way on another thread");
    struct Rest {
      std::atomic<bool>& busy;
      ~Rest() { busy = false; }
    } rest{busy_};
    try {
      const nb::gil_scoped_release release;
      return explorer_.run(max_firings);
    } catch (const Interrupted&) {
      throw nb::python_error();
    }
  }
  Exploration take() {
    at_rest();
    taken_ = true;
    return explorer_.take();
  }
  const Explorer& at_rest() const {
    if (busy_) throw std::invalid_argument("the exploration is under way on another thread");
    if (taken_) throw std::invalid_argument("the exploration was taken");
    return explorer_;
  }
  void cancel() { cancelled_ = true; }

 private:
  bool go_on() {
    if (cancelled_) throw Cancelled();
    const auto now = std::chrono::steady_clock::now();
    if (now < due_) return true;
    due_ = now + std::chrono::milliseconds(500);
    const nb::gil_scoped_acquire acquire;
    return PyErr_CheckSignals() == 0;
  }

  std::atomic<bool> busy_{false}, cancelled_{false};
  bool taken_ = false;
  std::chrono::steady_clock::time_point due_ = std::chrono::steady_clock::now() + std::chrono::seconds(1);
  Explorer explorer_;
};

const Places& checked(const SafeNet& net, const Places& places) {
  for (const std::uint32_t p : places)
    if (p >= net.places()) throw std::invalid_argument("no such place");
  return places;
}

constexpr std::uint32_t kMostPlaces = 1u << 28;

// The places that a net is to have.
std::uint32_t checked(std::uint32_t places) {
  if (places > kMostPlaces) throw std::invalid_argument("a net has at most 2^28 places");
  return places;
}

// Markings of a net: their rows mark no bit beyond its places.
const Rows& checked(const SafeNet& net, const Rows& markings) {
  const std::size_t words = net.words();
  if (markings.shape(1) != words) throw std::invalid_argument("markings of another net");
  const std::size_t last = net.places() - std::min<std::size_t>(net.places(), (words - 1) * 64);
  for (std::size_t s = 0; s < markings.shape(0) && last < 64; ++s)
    if (markings(s, words - 1) >> last) throw std::invalid_argument("no such place");
  return markings;
}

Orders orders_named(const std::string& name) {
  if (name == "one") return Orders::kOne;
  if (name == "enough") return Orders::kEnough;
  if (name == "every") return Orders::kEvery;
  throw std::invalid_argument("orders: one, enough or every");
}

// What happens to activities on the edges of stable markings: by edge a number, and what each number stands for.
nb::tuple passages(const SafeNet& net, const Rows& markings, const Column<std::int64_t>& offsets,
                   const Column<std::int64_t>& targets, const Column<std::uint32_t>& events,
                   const std::vector<Places>& leaving, const std::vector<std::tuple<Places, Places>>& given) {
  const std::size_t states = markings.shape(0), edges = targets.shape(0);
  if (!net.priorities()) throw std::invalid_argument("a net with priorities");
  checked(net, markings);
  if (offsets.shape(0) != states + 1 || offsets(0) != 0 || offsets(states) != std::int64_t(edges))
    throw std::invalid_argument("one row of targets for each state");
  for (std::size_t i = 0; i < states; ++i)
    if (offsets(i) > offsets(i + 1)) throw std::invalid_argument("one row of targets for each state");
  if (events.shape(0) != edges) throw std::invalid_argument("one event for each edge");
  for (std::size_t i = 0; i < edges; ++i) {
    if (targets(i) < 0 || targets(i) >= std::int64_t(states)) throw std::invalid_argument("no such state");
    if (!net.is_event(events(i))) throw std::invalid_argument("no such event");
  }
  if (leaving.size() != net.transitions()) throw std::invalid_argument("one row of activities for each transition");
  std::vector<Passages::Control> control;
  control.reserve(given.size());
  for (const auto& [places, at_rest] : given) control.push_back({checked(net, places), checked(net, at_rest)});
  for (const Places& activities : leaving)
    for (const std::uint32_t activity : activities)
      if (activity >= control.size()) throw std::invalid_argument("no such activity");
  Passages found(net, leaving, control);
  std::vector<std::uint32_t> numbers = run([&](const Limits& limits) {
    return found.of(markings.data(), states, offsets.data(), targets.data(), events.data(), limits);
  }, 0, 0, nb::none());
  std::vector<std::tuple<Places, Places>> kinds;
  for (const Passages::Kind& kind : found.kinds()) kinds.emplace_back(kind.left, kind.idled);
  return nb::make_tuple(array(std::move(numbers)), kinds);
}

constexpr std::uint32_t kMostWords = 1u << 20;

// A net whose places hold several tokens, its numbers checked.
CountedNet counted(const std::vector<Field>& given, const std::vector<Counted>& transitions, bool priorities) {
  std::vector<CountedNet::Field> fields;
  std::uint32_t words = 1;
  for (const auto& [word, shift, width] : given) {
    if (word >= kMostWords || width < 1 || width > 62 || shift > 64 - width) throw std::invalid_argument("no such field");
    fields.push_back({word, shift, width});
    words = std::max(words, word + 1);
  }
  const auto arcs = [&](const Arcs& side, std::int64_t least) {
    std::vector<CountedNet::Arc> found;
    for (const auto& [place, tokens] : side) {
      if (place >= fields.size()) throw std::invalid_argument("no such place");
      if (tokens < least || tokens > std::int64_t(1) << 62) throw std::invalid_argument("no such weight");
      found.push_back({place, tokens});
    }
    return found;
  };
  std::vector<CountedNet::Rule> rules;
  for (const auto& [need, change, rank] : transitions) {
    CountedNet::Rule rule{arcs(need, 0), arcs(change, -(std::int64_t(1) << 62)), rank};
    for (const CountedNet::Arc& taken : rule.change) {  // what is taken is there
      std::int64_t wanted = 0;
      for (const CountedNet::Arc& arc : rule.need)
        if (arc.place == taken.place) wanted = arc.tokens;
      if (wanted + taken.tokens < 0) throw std::invalid_argument("a transition takes more than it needs");
    }
    rules.push_back(std::move(rule));
  }
  return {std::move(fields), words, std::move(rules), priorities};
}

}  // namespace

void bind_explorer(nb::module_& module) {
  // NOLINTNEXTLINE(bugprone-throw-keyword-missing,bugprone-unused-raii): it declares a class of Python in the module.
  nb::exception<StateLimit>(module, "StateLimit", PyExc_RuntimeError);
  module.def("stable_ends", [](const Column<std::int64_t>& offsets, const Column<std::int64_t>& targets,
                               const Column<bool>& transient) {
    const std::size_t states = transient.shape(0);
    if (offsets.shape(0) != states + 1 || offsets(0) != 0 || offsets(states) != std::int64_t(targets.shape(0)))
      throw std::invalid_argument("one row of targets for each state");
    for (std::size_t i = 0; i < states; ++i)
      if (offsets(i) > offsets(i + 1)) throw std::invalid_argument("one row of targets for each state");
    for (std::size_t i = 0; i < targets.shape(0); ++i)
      if (targets(i) < 0 || targets(i) >= std::int64_t(states)) throw std::invalid_argument("no such state");
    std::vector<std::int64_t> ends(states);
    const std::int64_t clash = stable_ends(offsets.data(), targets.data(), transient.data(), states, ends.data());
    return nb::make_tuple(array(std::move(ends)), clash);
  }, nb::arg("offsets"), nb::arg("targets"), nb::arg("transient"));

  nb::class_<Exploration>(module, "Exploration")
      .def_prop_ro("states", &Exploration::states)
      .def_ro("edges", &Exploration::edges)
      .def_ro("dead", &Exploration::dead)
      .def_ro("stable", &Exploration::stable)
      .def_ro("most_tokens", &Exploration::most_tokens)
      .def_ro("transient", &Exploration::transient)
      .def_ro("parted", &Exploration::parted)
      .def_prop_ro("decided", [](const Exploration& found) {
        return std::vector<std::uint64_t>(found.decided.begin(), found.decided.end());
      })
      .def_ro("bounds", &Exploration::bounds)
      .def_prop_ro("trouble", [](const Exploration& e) -> std::optional<std::tuple<State, Places, const char*>> {
        if (!e.trouble) return std::nullopt;
        return std::tuple(e.trouble->state, e.trouble->firings, e.trouble->kind);
      })
      .def("run", [](const Exploration& e, State state) {
        std::vector<std::uint32_t> fired;
        if (state >= e.states()) throw std::out_of_range("no such state");
        for (; state != 0; state = e.parents[state]) fired.push_back(e.via[state]);
        return std::vector<std::uint32_t>(fired.rbegin(), fired.rend());
      }, nb::arg("state"))
      .def("lists", [](const Exploration& e) {
        const auto listed = [](const auto& of) {
          std::vector<std::uint64_t> values(of.size());
          for (std::size_t i = 0; i < values.size(); ++i) values[i] = of[i];
          return values;
        };
        return std::tuple(listed(e.markings), listed(e.offsets), listed(e.targets), listed(e.labels));
      })
      .def("take_markings", [](Exploration& e) { return array(std::move(e.markings), e.words); })
      .def("take_offsets", [](Exploration& e) { return array(std::move(e.offsets)); })
      .def("take_targets", [](Exploration& e) { return array(std::move(e.targets)); })
      .def("take_labels", [](Exploration& e) { return array(std::move(e.labels)); });

  nb::class_<PyExplorer>(module, "Explorer")
      .def("run", &PyExplorer::run, nb::arg("max_firings"))
      .def("take", &PyExplorer::take)
      .def("cancel", &PyExplorer::cancel)
      .def_prop_ro("states", [](const PyExplorer& e) { return e.at_rest().found().states(); })
      .def_prop_ro("explored", [](const PyExplorer& e) { return e.at_rest().explored(); })
      .def_prop_ro("edges", [](const PyExplorer& e) { return e.at_rest().found().edges; })
      .def_prop_ro("bytes", [](const PyExplorer& e) { return e.at_rest().bytes(); });

  nb::class_<SafeNet>(module, "SafeNet")
      .def("__init__", [](SafeNet* self, std::uint32_t places, const std::vector<Given>& transitions, bool priorities) {
        std::vector<Firing> firings;
        for (const auto& [need, take, put, rank, overflow] : transitions) {
          for (const Places* side : {&need, &take, &put})
            for (const std::uint32_t p : *side)
              if (p >= places) throw std::invalid_argument("no such place");
          if (priorities && !firings.empty() && rank < firings.back().rank)
            throw std::invalid_argument("transitions in the order of their ranks");
          firings.push_back({need, take, put, rank, overflow});
        }
        new (self) SafeNet(checked(places), std::move(firings), priorities);
      }, nb::arg("places"), nb::arg("transitions"), nb::arg("priorities"))
      .def("explore", [](const SafeNet& net, const Places& initial, bool edges, std::uint64_t max_states,
                         std::uint64_t max_bytes, const nb::object& progress) {
        return run([&](const Limits& limits) { return net.explore(checked(net, initial), edges, limits); }, max_states, max_bytes,
                   progress);
      }, nb::arg("initial"), nb::arg("edges"), nb::arg("max_states"), nb::arg("max_bytes"),
         nb::arg("progress").none() = nb::none())
      .def("explorer", [](const SafeNet& net, const Places& initial, std::uint64_t max_bytes, bool edges) {
        return new PyExplorer(net, checked(net, initial), max_bytes, edges);
      }, nb::arg("initial"), nb::arg("max_bytes"), nb::arg("edges") = false, nb::keep_alive<0, 1>())
      .def("labels", [](const SafeNet& net, const Rows& markings) {
        return array(net.labels(checked(net, markings).data(), markings.shape(0)));
      }, nb::arg("markings"))
      .def("passages", [](const SafeNet& net, const Rows& markings, const Column<std::int64_t>& offsets,
                          const Column<std::int64_t>& targets, const Column<std::uint32_t>& events,
                          const std::vector<Places>& leaving, const std::vector<std::tuple<Places, Places>>& control) {
        return passages(net, markings, offsets, targets, events, leaving, control);
      }, nb::arg("markings"), nb::arg("offsets"), nb::arg("targets"), nb::arg("events"), nb::arg("leaving"),
         nb::arg("control"))
      .def("units", [](const SafeNet& net, const Places& initial) { return net.units(checked(net, initial)); }, nb::arg("initial"))
      .def("settle", [](const SafeNet& net, const Places& initial, const std::string& orders, std::uint64_t max_states,
                        std::uint64_t max_transient, std::uint64_t max_bytes, const nb::object& progress,
                        std::uint64_t max_firings) {
        const Orders tried = orders_named(orders);
        if (!net.priorities()) throw std::invalid_argument("a net with priorities");
        return run([&](const Limits& limits) {
          return Settling(net, checked(net, initial), tried, limits, max_transient, max_firings).run();
        }, max_states, max_bytes, progress);
      }, nb::arg("initial"), nb::arg("orders"), nb::arg("max_states"), nb::arg("max_transient"),
         nb::arg("max_bytes"), nb::arg("progress").none() = nb::none(), nb::arg("max_firings") = ~std::uint64_t(0));

  nb::class_<CountedNet>(module, "CountedNet")
      .def("__init__", [](CountedNet* self, const std::vector<Field>& fields, const std::vector<Counted>& transitions,
                          bool priorities) {
        new (self) CountedNet(counted(fields, transitions, priorities));
      }, nb::arg("fields"), nb::arg("transitions"), nb::arg("priorities"))
      .def("explore", [](const CountedNet& net, const std::vector<std::int64_t>& initial, bool edges,
                         std::uint64_t max_states, std::uint64_t max_bytes, const nb::object& progress) {
        return run([&](const Limits& limits) { return net.explore(net.checked(initial), edges, limits); }, max_states,
                   max_bytes, progress);
      }, nb::arg("initial"), nb::arg("edges"), nb::arg("max_states"), nb::arg("max_bytes"),
         nb::arg("progress").none() = nb::none());
}
