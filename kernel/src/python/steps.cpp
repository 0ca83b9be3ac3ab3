// Big steps for Python: bytes for each event, from which a store makes one event of its own.
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <span>
#include <string>
#include <tuple>

#include "diagrams/relation.hpp"
#include "markings/big_steps.hpp"
#include "markings/set_evolution.hpp"
#include "python/module.hpp"
#include "python/sets.hpp"

namespace nb = nanobind;
using namespace mcpn;

namespace {

constexpr std::size_t kBranches = 100;  // of an event, for each level that its ways touch, before it is made in parts

constexpr std::size_t kMostParts = 16'000'000;  // of a function

using Ways = std::vector<BigSteps::Way>;
using Numbers = std::vector<std::uint32_t>;

constexpr std::uint32_t kFunction = ~std::uint32_t(0);  // stands before how many numbers the table of a function has

constexpr Level kNoLevel = ~Level(0);

struct BigStepsOf { Ways ways; std::vector<Numbers> functions; };

nb::bytes bytes_of(const Numbers& rows) {
  return nb::bytes(reinterpret_cast<const char*>(rows.data()), rows.size() * sizeof(rows[0]));
}

// A row for each way: how many levels it touches, and for each the level with the touch in its two lowest bits.
nb::bytes packed(const Ways& ways) {
  Numbers rows;
  for (const BigSteps::Way& way : ways) {
    rows.push_back(std::uint32_t(way.size()));
    for (const Touched& at : way) rows.push_back(at.level << 2 | std::uint32_t(at.touch));
  }
  return bytes_of(rows);
}

BigStepsOf unpacked(const nb::bytes& data, Level levels) {
  const Numbers rows = numbers_of(data, "no big steps");
  const std::size_t size = rows.size();
  BigStepsOf found;
  for (std::size_t at = 0; at < size;) {
    const bool function = rows[at] == kFunction;
    at += function;
    if (at == size) throw std::invalid_argument("no big steps");
    const std::size_t count = rows[at++];
    if (count > size - at) throw std::invalid_argument("no big steps");
    if (function) {
      const std::span table(rows.data() + at, count);
      if (!Relations::is_table(table, levels)) throw std::invalid_argument("no function on these levels");
      found.functions.emplace_back(table.begin(), table.end());
      at += count;
      continue;
    }
    BigSteps::Way& way = found.ways.emplace_back();
    for (const std::size_t end = at + count; at < end; ++at) {
      const Touched touched{rows[at] >> 2, Touch(rows[at] & 3)};
      if (touched.level >= levels || (!way.empty() && way.back().level >= touched.level))
        throw std::invalid_argument("levels of another store, or not in their order");
      way.push_back(touched);
    }
  }
  return found;
}

Touch undone(Touch touch) {
  return touch == Touch::consume ? Touch::produce : touch == Touch::produce ? Touch::consume : touch;
}

// Events of all ways together, as few as that is quick: where one of some ways branches often, two halves are two.
std::vector<std::uint64_t> events_of(PyStore& s, std::span<const BigSteps::Way> ways) {
  std::vector<std::uint64_t> events;
  std::vector<std::span<const BigSteps::Way>> left{ways};
  while (!left.empty()) {
    const auto some = left.back();
    left.pop_back();
    std::size_t touched = 0;
    for (const BigSteps::Way& way : some) touched += way.size();
    if (const auto made = s.store.choice(some, kBranches * (touched + 1))) {
      events.push_back(s.id(*made));
    } else {
      left.push_back(some.first(some.size() / 2));
      left.push_back(some.subspan(some.size() / 2));
    }
  }
  return events;
}

// The event of a function, each way to touch a level changed, and some levels that it does not touch marked.
template <class Change> std::uint32_t event_of(Store& store, const Numbers& table, Change change, const std::vector<Level>& also) {
  Relations relations(kMostParts);
  BigSteps::Way marked;
  for (const Level level : also) marked.push_back({level, Touch::read});
  const Relations::Id whole = relations.then(relations.way(marked), relations.from_table(table, change));
  return relations.suffix(store, whole);
}

// Events that do what some ways do, or undo it, or conditions that one of them is enabled; some more levels are marked.
std::vector<std::uint64_t> choices(PyStore& s, const nb::bytes& data, const std::string& as,
                                   const std::vector<std::int64_t>& marked) {
  if (as != "ahead" && as != "back" && as != "where") throw std::invalid_argument("ahead, back or where");
  BigStepsOf steps = unpacked(data, s.store.levels);
  Ways& ways = steps.ways;
  const std::vector<Numbers>& functions = steps.functions;
  const std::vector<Level> also = s.sorted(marked);
  const auto changed = [&](Touch touch) {
    return as == "ahead" ? touch : as == "back" ? undone(touch) : Touched{0, touch}.asked();
  };
  for (BigSteps::Way& way : ways) {
    for (Touched& at : way) at.touch = changed(at.touch);
    for (const Level level : also) {
      const auto at = std::lower_bound(way.begin(), way.end(), level, [](const Touched& a, Level b) { return a.level < b; });
      if (at != way.end() && at->level == level) throw std::invalid_argument("a level is named twice");
      way.insert(at, {level, Touch::read});
    }
  }
  if (ways.empty() && functions.empty()) throw std::invalid_argument("no way is given");
  std::vector<std::uint64_t> made;
  s.run([&] {
    if (!ways.empty()) made = events_of(s, ways);
    for (const Numbers& table : functions) made.push_back(s.id(event_of(s.store, table, changed, also)));
  });
  return made;
}

struct Firings { const SafeNet* net; std::uint32_t event; std::shared_ptr<const SetEvolution::Evolved> evolved; Handle begun; };

class PyBigSteps {
 public:
  PyBigSteps(const SafeNet& net, const Numbers& initial, const std::vector<std::int64_t>& places,
             const std::vector<std::tuple<std::uint32_t, Level>>& partners, std::uint64_t max_bytes, std::uint64_t max_transient,
             std::size_t few_cases)
      : net_(with_priorities(net)), levels_(places.size()), steps_(net, checked(initial), levelled(places), partnered(partners), max_bytes, max_transient),
        evolution_(net, checked(initial), by_place(net.places(), levelled(places), partnered(partners)), few_cases) {}

  std::optional<Handle> start(const std::shared_ptr<PyStore>& s) {
    check(*s);
    std::optional<std::vector<Level>> marked;
    const Handle found = computed(s, [&](Store& store) {
      marked = steps_.start(store);
      return marked ? store.singleton(*marked) : 0;
    });
    return open(marked.has_value()) ? std::optional(found) : std::nullopt;
  }
  std::optional<std::tuple<nb::bytes, std::size_t, bool>> cover(const Handle& markings, std::uint32_t event, std::size_t most) {
    check(*markings.owner);
    if (!net_.is_event(event)) throw std::invalid_argument("no such event");
    std::optional<std::pair<Ways, bool>> found;
    markings.owner->run([&] {
      markings.owner->store.begin();
      found = steps_.cover(markings.owner->store, markings.node, event, most);
    });
    if (!open(found.has_value())) return std::nullopt;
    return std::tuple(packed(found->first), found->first.size(), found->second);
  }
  using Behind = std::tuple<Handle, Firings>;
  std::optional<std::tuple<Handle, Handle, Firings>> after(const Handle& markings, std::uint32_t event) {
    auto found = after_together({{markings, event}}, 0);
    if (!found) return std::nullopt;
    auto& [left, firings] = std::get<1>(*found).front();
    return std::tuple(std::get<0>(*found), left, firings);
  }
  std::optional<std::tuple<Handle, std::vector<Behind>>> after_together(const std::vector<std::tuple<Handle, std::uint32_t>>& events,
                                                                        std::uint64_t most_steps) {
    if (events.empty()) throw std::invalid_argument("no event is given");
    const Handle& first = std::get<0>(events.front());
    check(*first.owner);
    std::vector<SetEvolution::Start> starts;
    for (const auto& [markings, event] : events) {
      first.same_store(markings);
      if (!net_.is_event(event)) throw std::invalid_argument("no such event");
      starts.push_back({markings.node, event});
    }
    std::shared_ptr<const SetEvolution::Evolved> evolved;
    std::vector<Handle> kept;  // where evolution began, and the markings that are left, by event
    const Handle made = computed(first.owner, [&](Store& store) {
      evolved_ = first.owner;
      std::optional<SetEvolution::Evolved> found = evolution_.after(store, starts);
      if (!found) return Node(0);
      evolved = std::make_shared<const SetEvolution::Evolved>(std::move(*found));
      kept.emplace_back(first.owner, evolved->begun);
      for (const Node left : evolved->left) kept.emplace_back(first.owner, left);
      return evolved->after;
    }, 0, most_steps);
    if (!evolved) return std::nullopt;
    std::vector<Behind> behind;
    for (std::size_t i = 0; i < starts.size(); ++i) behind.emplace_back(kept[i + 1], Firings{&net_, starts[i].event, evolved, kept[0]});
    return std::tuple(made, std::move(behind));
  }
  std::optional<nb::bytes> function(const Handle& markings, const Firings& firings, bool wide) {
    check(*markings.owner);
    if (firings.net != &net_) throw std::invalid_argument("firings of another net");
    markings.same_store(firings.begun);
    std::optional<Numbers> table;
    markings.owner->run([&] {
      evolved_ = markings.owner;
      table = evolution_.function(markings.owner->store, {markings.node, firings.event}, *firings.evolved, wide);
    });
    if (!table) return std::nullopt;
    table->insert(table->begin(), {kFunction, std::uint32_t(table->size())});
    return bytes_of(*table);
  }

 private:
  static const SafeNet& with_priorities(const SafeNet& net) {
    if (!net.priorities()) throw std::invalid_argument("a net with priorities");
    return net;
  }
  static SetEvolution::Levels by_place(std::size_t places, const Numbers& levelled, const std::vector<std::pair<std::uint32_t, Level>>& partners) {
    SetEvolution::Levels levels(places, {kNoLevel, false});
    for (Level at = 0; at < levelled.size(); ++at)
      if (levelled[at] != BigSteps::kNoPlace) levels[levelled[at]] = {at, false};
    for (const auto& [place, at] : partners) levels[place] = {at, true};
    for (const auto& [level, reverse] : levels)
      if (level == kNoLevel) throw std::invalid_argument("a place without a level");
    return levels;
  }
  Numbers checked(const Numbers& places) const {
    for (const std::uint32_t p : places)
      if (p >= net_.places()) throw std::invalid_argument("no such place");
    return places;
  }
  Numbers levelled(const std::vector<std::int64_t>& places) const {
    Numbers found;
    for (const std::int64_t p : places) {
      if (p < -1 || p >= std::int64_t(net_.places())) throw std::invalid_argument("no such place");
      found.push_back(p < 0 ? BigSteps::kNoPlace : std::uint32_t(p));
    }
    return found;
  }
  std::vector<std::pair<std::uint32_t, Level>> partnered(const std::vector<std::tuple<std::uint32_t, Level>>& partners) const {
    std::vector<std::pair<std::uint32_t, Level>> found;
    for (const auto& [place, level] : partners) {
      if (place >= net_.places() || level >= levels_) throw std::invalid_argument("no such place, or no such level");
      found.emplace_back(place, level);
    }
    return found;
  }
  void check(const PyStore& s) const {
    if (ended_) throw std::invalid_argument("it has come to trouble");
    if (s.store.levels != levels_) throw std::invalid_argument("a store with other levels");
  }
  bool open(bool more) { return !(ended_ = !more); }

  const SafeNet& net_;
  const std::size_t levels_;
  BigSteps steps_;
  SetEvolution evolution_;
  std::shared_ptr<PyStore> evolved_;  // kept, for the evolution knows the last store by its place in memory
  bool ended_ = false;
};

}  // namespace

void bind_steps(nb::module_& module) {
  nb::class_<Firings>(module, "Firings");
  nb::class_<PyBigSteps>(module, "BigSteps")
      .def(nb::init<const SafeNet&, const Numbers&, const std::vector<std::int64_t>&, const std::vector<std::tuple<std::uint32_t, Level>>&,
                    std::uint64_t, std::uint64_t, std::size_t>(),
           nb::arg("net"), nb::arg("initial"), nb::arg("places"), nb::arg("partners"), nb::arg("max_bytes"), nb::arg("max_transient"),
           nb::arg("few_cases"), nb::keep_alive<1, 2>())
      .def("start", &PyBigSteps::start, nb::arg("store"))
      .def("cover", &PyBigSteps::cover, nb::arg("markings"), nb::arg("event"), nb::arg("most"))
      .def("after", &PyBigSteps::after, nb::arg("markings"), nb::arg("event"))
      .def("after_together", &PyBigSteps::after_together, nb::arg("starts"), nb::arg("most_steps") = 0)
      .def("function", &PyBigSteps::function, nb::arg("markings"), nb::arg("firings"), nb::arg("wide") = false);
  module.def("choices", [](const std::shared_ptr<PyStore>& s, const nb::bytes& ways, const std::string& as,
                           const std::vector<std::int64_t>& marked) { return choices(*s, ways, as, marked); },
             nb::arg("store"), nb::arg("ways"), nb::arg("as_"), nb::arg("marked"));
}
