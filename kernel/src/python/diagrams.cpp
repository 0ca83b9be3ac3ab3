// Sets of markings and their store for Python: handles that keep nodes alive, ids of events and conditions.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <optional>

#include "diagrams/store.hpp"
#include "markings/explorer.hpp"
#include "python/module.hpp"
#include "python/numbers.hpp"
#include "python/sets.hpp"

namespace nb = nanobind;
using namespace mcpn;

namespace {

template <class F> auto measured(const Handle& set, F body) {
  decltype(body(set.store())) result{};
  set.owner->run([&] {
    set.store().begin();
    result = body(set.store());
  });
  return result;
}

// The markings of a set one by one, depth first: those without a level before those with it.
class Markings {
 public:
  explicit Markings(const Handle& set) : set_(set) { descend(set.node); }
  std::vector<Level> next() {
    if (!more_) throw nb::stop_iteration();
    std::vector<Level> found = marked_;
    more_ = false;
    while (!path_.empty() && !more_) {
      const Step step = path_.back();
      path_.pop_back();
      marked_.resize(step.marked);
      marked_.push_back(set_.store().level(step.node));
      descend(set_.store().hi(step.node));
    }
    return found;
  }

 private:
  struct Step {
    Node node;           // whose marked side is still to be walked
    std::size_t marked;  // levels marked above it
  };
  void descend(Node node) {
    const Store& store = set_.owner->at_rest();
    while (node > 1) {
      if (store.lo(node) != 0) {
        path_.push_back({node, marked_.size()});
        node = store.lo(node);
      } else {
        marked_.push_back(store.level(node));
        node = store.hi(node);
      }
    }
    more_ = node == 1;
  }
  Handle set_;
  std::vector<Step> path_;
  std::vector<Level> marked_;
  bool more_ = false;
};

void check_weights(const Handle& set, const std::vector<Wide>& weights) {
  if (weights.size() != set.store().levels) throw std::invalid_argument("one weight for each level");
  for (const Wide weight : weights)
    if (weight > kMostWeight || weight < -kMostWeight) throw std::invalid_argument("a weight is beyond 2^105");
}

nb::object to_int(const std::vector<std::uint64_t>& limbs) {
  const nb::bytes data(reinterpret_cast<const char*>(limbs.data()), limbs.size() * sizeof(std::uint64_t));
  return nb::module_::import_("builtins").attr("int").attr("from_bytes")(data, "little");
}

}  // namespace

void bind_diagrams(nb::module_& module) {
  using Levels = std::vector<std::int64_t>;

  nb::class_<Handle>(module, "Zdd")
      .def("__or__", [](const Handle& a, const Handle& b) {
        a.same_store(b);
        return computed(a.owner, [&](Store& s) { return s.join(a.node, b.node); });
      })
      .def("__and__", [](const Handle& a, const Handle& b) {
        a.same_store(b);
        return computed(a.owner, [&](Store& s) { return s.meet(a.node, b.node); });
      })
      .def("__sub__", [](const Handle& a, const Handle& b) {
        a.same_store(b);
        return computed(a.owner, [&](Store& s) { return s.minus(a.node, b.node); });
      })
      .def("__eq__", [](const Handle& a, const Handle& b) { return a.owner == b.owner && a.node == b.node; },
           nb::is_operator())
      .def("__hash__", [](const Handle& a) { return std::size_t(a.node); })
      .def("__bool__", [](const Handle& a) { return a.node != 0; })
      .def("subset", [](const Handle& a, const Levels& marked, const Levels& unmarked) {
        const std::uint32_t wanted = a.owner->touches({{Touch::read, marked}, {Touch::zero, unmarked}});
        return computed(a.owner, [&](Store& s) { return s.filter(a.node, wanted); });
      }, nb::arg("marked") = Levels{}, nb::arg("unmarked") = Levels{})
      .def("onto", [](const Handle& a, const Levels& levels) {
        const std::uint32_t kept = a.owner->touches({{Touch::read, levels}});
        return computed(a.owner, [&](Store& s) { return s.onto(a.node, kept); });
      }, nb::arg("levels"))
      .def("count", [](const Handle& a) {
        return to_int(measured(a, [&](Store& s) { return s.counts(a.node, {0}); }).front());
      })
      .def("largest", [](const Handle& a, const std::vector<Wide>& weights) {
        check_weights(a, weights);
        if (a.node == 0) throw std::invalid_argument("the empty set has no largest marking");
        return measured(a, [&](Store& s) { return s.largest(a.node, weights); });
      }, nb::arg("weights"))
      .def("nodes", [](const Handle& a) { return a.owner->at_rest().size(a.node); })
      .def("to_bytes", [](const Handle& a) {
        const std::vector<std::uint32_t> rows = measured(a, [&](Store& s) { return s.table(a.node); });
        return nb::bytes(reinterpret_cast<const char*>(rows.data()), rows.size() * sizeof(rows[0]));
      })
      .def("pick", [](const Handle& a) -> std::optional<std::vector<Level>> {
        std::vector<Level> marking;
        if (!a.owner->at_rest().pick(a.node, marking)) return std::nullopt;
        return marking;
      })
      .def("without", [](const Handle& a, const Ids& ids) {
        const auto conditions = a.owner->conditions(ids);
        return computed(a.owner, [&](Store& s) { return s.without(a.node, conditions); });
      }, nb::arg("conditions"))
      .def("counts", [](const Handle& a, const Ids& ids) {
        const auto conditions = a.owner->conditions(ids);
        const auto limbs = measured(a, [&](Store& s) { return s.counts(a.node, conditions); });
        nb::list result;
        for (const auto& number : limbs) result.append(to_int(number));
        return result;
      }, nb::arg("conditions"))
      .def("first", [](const Handle& a, const Ids& ids) {
        const auto conditions = a.owner->conditions(ids);
        return measured(a, [&](Store& s) { return s.first(a.node, conditions); });
      }, nb::arg("conditions"))
      .def("images", [](const Handle& a, const Ids& ids, const Handle* within) {
        const auto events = a.owner->events(ids);
        if (within) a.same_store(*within);
        const Node limit = within ? within->node : kAnything;
        return computed(a.owner, [&](Store& s) { return s.images(a.node, events, limit); });
      }, nb::arg("events"), nb::arg("within").none() = nb::none())
      .def("beyond", [](const Handle& a, const Handle& from, const Ids& ids) {
        a.same_store(from);
        const auto events = a.owner->events(ids);
        return computed(a.owner, [&](Store& s) { return s.beyond(a.node, from.node, events); });
      }, nb::arg("before"), nb::arg("events"))
      .def("saturate", [](const Handle& a, const Ids& ids, std::uint64_t max_nodes, const Handle* within,
                          std::uint64_t max_steps) {
        if (within) a.same_store(*within);
        const auto events = a.owner->events(ids);
        const auto body = [&](Store& s) {
          s.declare(events);
          return s.saturate(a.node, within ? within->node : kAnything);
        };
        return computed(a.owner, body, max_nodes, max_steps);
      }, nb::arg("events"), nb::arg("max_nodes") = 0, nb::arg("within").none() = nb::none(), nb::arg("max_steps") = 0)
      .def("weighing", [](const Handle& a, const std::vector<Wide>& weights, Wide least, Wide most) {
        check_weights(a, weights);
        return computed(a.owner, [&](Store& s) { return s.weighing(a.node, weights, least, most); });
      }, nb::arg("weights"), nb::arg("least"), nb::arg("most"))
      .def("__iter__", [](const Handle& a) { return Markings(a); });

  nb::class_<Markings>(module, "Markings")
      .def("__iter__", [](nb::handle self) { return nb::borrow(self); })
      .def("__next__", [](Markings& markings) { return markings.next(); });

  nb::class_<PyStore>(module, "Store")
      .def(nb::new_([](std::uint64_t levels, std::uint64_t memory_limit) {
        return std::make_shared<PyStore>(levels, memory_limit);
      }), nb::arg("levels"), nb::arg("memory_limit") = std::uint64_t(4) << 30)
      .def("empty", [](std::shared_ptr<PyStore> s) { return Handle(std::move(s), 0); })
      .def("singleton", [](const std::shared_ptr<PyStore>& s, const Levels& marked) {
        const std::vector<Level> levels = s->sorted(marked);
        return computed(s, [&](Store& store) { return store.singleton(levels); });
      }, nb::arg("marked"))
      .def("from_bytes", [](const std::shared_ptr<PyStore>& s, const nb::bytes& data) {
        const std::vector<std::uint32_t> rows = numbers_of(data, "no table of a set: rows are triples");
        return computed(s, [&](Store& store) { return store.from_table(rows); });
      }, nb::arg("data"))
      .def("from_markings", [](const std::shared_ptr<PyStore>& s, const nb::ndarray<const std::uint64_t, nb::ndim<2>, nb::c_contig, nb::device::cpu>& rows,
                               const std::vector<std::int64_t>& bits) {
        const std::size_t count = rows.shape(0), words = rows.shape(1);
        s->check_bits(bits, words);
        if (count > 0xFFFFFFFFu) throw std::invalid_argument("more markings than 32 bits can name");
        return computed(s, [&](Store& store) {
          return store.from_keys(store.keys_of(rows.data(), count, words, bits), count);
        });
      }, nb::arg("rows"), nb::arg("bits"))
      .def("event", [](PyStore& s, const Levels& consume, const Levels& produce, const Levels& read, const Levels& zero) {
        return s.id(s.touches(
            {{Touch::consume, consume}, {Touch::produce, produce}, {Touch::read, read}, {Touch::zero, zero}}));
      }, nb::arg("consume"), nb::arg("produce"), nb::arg("read") = Levels{}, nb::arg("zero") = Levels{})
      .def("condition", [](PyStore& s, const Levels& marked, const Levels& unmarked) {
        return s.id(s.touches({{Touch::read, marked}, {Touch::zero, unmarked}}));
      }, nb::arg("marked"), nb::arg("unmarked") = Levels{})
      .def("branch", [](PyStore& s, std::int64_t level, std::optional<std::uint64_t> consume,
                        std::optional<std::uint64_t> produce, std::optional<std::uint64_t> read,
                        std::optional<std::uint64_t> zero) {
        return s.id(s.branch(level, {consume, produce, read, zero}));
      }, nb::arg("level"), nb::arg("consume").none() = nb::none(), nb::arg("produce").none() = nb::none(),
         nb::arg("read").none() = nb::none(), nb::arg("zero").none() = nb::none())
      .def("collect", [](PyStore& s) { s.run([&] { s.store.collect(); }); })
      .def("cancel", [](PyStore& s) { s.store.cancelled.store(true); })
      .def_prop_rw("progress", [](const PyStore& s) { return s.progress.told(); },
                   [](PyStore& s, nb::object told) { s.progress.tell(std::move(told)); }, nb::arg().none())
      .def_prop_ro("levels", [](const PyStore& s) { return s.store.levels; })
      .def_prop_ro("live_nodes", [](const PyStore& s) { return s.store.live(); })
      .def_prop_ro("peak_nodes", [](const PyStore& s) { return s.store.peak(); })
      .def_prop_ro("steps", [](const PyStore& s) { return s.store.steps(); })
      .def_prop_ro("closed", [](const PyStore& s) { return s.store.closed(); })
      .def_prop_ro("collections", [](const PyStore& s) { return s.store.collections(); })
      .def_prop_ro("bytes", [](const PyStore& s) { return s.store.bytes(); });
}
