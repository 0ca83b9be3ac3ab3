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
#include <cstring>
#include <functional>
#include <memory>
#include <numeric>
#include <optional>

#include "diagrams/store.hpp"
#include "markings/changes.hpp"
#include "python/module.hpp"
#include "python/operation.hpp"
#include "python/numbers.hpp"

namespace nb = nanobind;
using namespace mcpn;

namespace {

constexpr const char* kBusy = "the store is at work for another thread";
constexpr Level kMostLevels = 1u << 20;

using Ids = std::vector<std::uint64_t>;

// What Python calls an event or a condition: the store's number above, a suffix below.
std::atomic<std::uint32_t> stores_made{0};

class PyStore : public std::enable_shared_from_this<PyStore> {
 public:
  PyStore(std::uint64_t levels, std::uint64_t memory_limit) : store(checked(levels), memory_limit) {}
  Store store;
  nb::object progress = nb::none();

  // One operation at a time: the GIL is free meanwhile, so that another thread could ask for one.
  void run(std::function<void()> body) {
    if (busy_.exchange(true)) throw std::runtime_error(kBusy);
    const struct Done {
      std::atomic<bool>& busy;
      ~Done() { busy.store(false); }
    } done{busy_};
    run_operation(store, std::move(body), progress);
  }

  Store& at_rest() {
    if (busy_) throw std::runtime_error(kBusy);
    return store;
  }

  static Level checked(std::uint64_t levels) {
    if (levels > kMostLevels) throw std::invalid_argument("a store has at most 2^20 levels");
    return Level(levels);
  }
  void check_bits(const std::vector<std::int64_t>& bits, std::size_t words) const {
    if (bits.size() != store.levels) throw std::invalid_argument("one bit for each level");
    for (const std::int64_t bit : bits)
      if (bit < -1 || (bit >= 0 && std::size_t(bit) >= words * 64)) throw std::invalid_argument("no such bit");
  }
  std::vector<Level> sorted(std::vector<std::int64_t> levels) const {
    std::sort(levels.begin(), levels.end());
    for (std::size_t i = 0; i < levels.size(); ++i) {
      if (levels[i] < 0 || levels[i] >= std::int64_t(store.levels)) throw std::invalid_argument("no such level");
      if (i && levels[i] == levels[i - 1]) throw std::invalid_argument("a level is named twice");
    }
    return {levels.begin(), levels.end()};
  }
  std::uint64_t id(std::uint32_t suffix) {
    if (given_.size() <= suffix) given_.resize(std::size_t(suffix) * 2 + 64);
    given_[suffix] = true;
    return number_ << 32 | suffix;
  }
  std::vector<std::uint32_t> events(const Ids& ids) { return suffixes(ids, false); }
  std::vector<std::uint32_t> conditions(const Ids& ids) { return suffixes(ids, true); }
  std::uint32_t touches(const std::vector<std::pair<Touch, std::vector<std::int64_t>>>& sides) {
    std::vector<std::int64_t> all;
    std::vector<std::pair<std::int64_t, Touch>> each;
    for (const auto& [touch, levels] : sides)
      for (const std::int64_t at : levels) {
        all.push_back(at);
        each.emplace_back(at, touch);
      }
    sorted(all);  // checks range and repeats
    std::sort(each.begin(), each.end());
    std::uint32_t suffix = 0;
    for (auto at = each.rbegin(); at != each.rend(); ++at) suffix = at_rest().suffix(Level(at->first), at->second, suffix);
    return suffix;
  }

  // What goes on depending on a level: by what it was and becomes, the rest; none where that does not happen.
  std::uint32_t branch(std::int64_t level, const std::array<std::optional<std::uint64_t>, 4>& rests) {
    sorted({level});  // checks the range
    Store& at = at_rest();
    std::uint32_t more = 0;
    for (const Touch touch : {Touch::zero, Touch::read, Touch::produce, Touch::consume}) {
      const std::optional<std::uint64_t>& rest = rests[std::size_t(touch)];
      if (!rest) continue;
      const std::uint32_t next = suffixes({*rest}, false).front();
      if (at.first_level(next) <= Level(level)) throw std::invalid_argument("what comes next is on levels below");
      more = at.suffix(Level(level), touch, next, more);
    }
    if (more == 0) throw std::invalid_argument("nothing may happen to this level");
    return more;
  }

 private:
  std::vector<std::uint32_t> suffixes(const Ids& ids, bool conditions) {
    std::vector<std::uint32_t> found;
    found.reserve(ids.size());
    const Store& at = at_rest();
    for (const std::uint64_t id : ids) {
      const auto suffix = std::uint32_t(id);
      const bool known = id >> 32 == number_ && suffix < given_.size() && given_[suffix];
      if (!known || (conditions && !at.is_condition(suffix)))
        throw std::invalid_argument(std::to_string(id) + " is no " + (conditions ? "condition" : "event") +
                                    " of this store");
      found.push_back(suffix);
    }
    return found;
  }

  const std::uint64_t number_ = 1 + stores_made++ % 0x7FFFFFFE;  // ids fit 63 bits
  std::vector<bool> given_;  // by suffix, whether Python has an id of it
  std::atomic<bool> busy_ = false;
};

class Handle {
 public:
  Handle(std::shared_ptr<PyStore> of, Node held) : owner(std::move(of)), node(held) { owner->store.keep(node); }
  Handle(const Handle& other) : Handle(other.owner, other.node) {}
  Handle& operator=(const Handle&) = delete;
  ~Handle() { owner->store.drop(node); }
  Store& store() const { return owner->store; }
  void same_store(const Handle& other) const {
    if (owner != other.owner) throw std::invalid_argument("the sets belong to two stores");
  }
  std::shared_ptr<PyStore> owner;
  Node node;
};

template <class F> Handle computed(const std::shared_ptr<PyStore>& owner, F body, std::uint64_t most_nodes = 0,
                                   std::uint64_t most_steps = 0) {
  Node result = 0;
  owner->run([&] {
    owner->store.begin(most_nodes, most_steps);
    result = body(owner->store);
  });
  return {owner, result};
}

Handle from_rows(const std::shared_ptr<PyStore>& s, const std::uint64_t* rows, std::size_t count, std::size_t words,
                 const std::vector<std::int64_t>& bits) {
  std::vector<std::uint32_t> all(count);
  std::iota(all.begin(), all.end(), 0u);
  return computed(s, [&](Store& store) { return store.from_keys(store.keys_of(rows, count, words, bits), all); });
}

// An exploration whose markings Python has not taken.
const Exploration& checked(const Exploration& found) {
  if (found.markings.size() == found.states() * found.words) return found;
  throw std::invalid_argument("the markings were taken");
}

using ToldChange = std::tuple<std::uint32_t, std::vector<std::uint32_t>, std::vector<std::uint32_t>, Handle>;

// What events change in the markings of a listing, with the set of those in which they do.
std::optional<std::vector<ToldChange>> told_changes(const std::shared_ptr<PyStore>& s, const Exploration& found,
                                                    const std::vector<std::int64_t>& bits, std::size_t most) {
  s->check_bits(bits, found.words);
  const bool edges = found.offsets.size() == found.states() + 1 && found.labels.size() == found.edges;
  if (!edges || found.targets.size() != found.edges) throw std::invalid_argument("an exploration without its edges");
  auto all = changes(checked(found), most);
  if (!all) return std::nullopt;
  std::vector<std::uint64_t> keys;
  s->run([&] { s->store.begin(); keys = s->store.keys_of(found.markings.data(), found.states(), found.words, bits); });
  std::vector<ToldChange> told;
  for (Change& change : *all) {
    Handle sources = computed(s, [&](Store& store) { return store.from_keys(keys, change.sources); });
    told.emplace_back(change.label, std::move(change.lost), std::move(change.gained), sources);
  }
  return told;
}

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
        if (data.size() % sizeof(std::uint32_t)) throw std::invalid_argument("no table of a set: rows are triples");
        std::vector<std::uint32_t> rows(data.size() / sizeof(std::uint32_t));
        if (!rows.empty()) std::memcpy(rows.data(), data.c_str(), data.size());
        return computed(s, [&](Store& store) { return store.from_table(rows); });
      }, nb::arg("data"))
      .def("from_markings", [](const std::shared_ptr<PyStore>& s, const nb::ndarray<const std::uint64_t, nb::ndim<2>, nb::c_contig, nb::device::cpu>& rows,
                               const std::vector<std::int64_t>& bits) {
        const std::size_t count = rows.shape(0), words = rows.shape(1);
        s->check_bits(bits, words);
        if (count > 0xFFFFFFFFu) throw std::invalid_argument("more markings than 32 bits can name");
        return from_rows(s, rows.data(), count, words, bits);
      }, nb::arg("rows"), nb::arg("bits"))
      .def("from_exploration", [](const std::shared_ptr<PyStore>& s, const Exploration& found, const std::vector<std::int64_t>& bits) {
        s->check_bits(bits, found.words);
        return from_rows(s, checked(found).markings.data(), found.states(), found.words, bits);
      }, nb::arg("exploration"), nb::arg("bits"))
      .def("changes", &told_changes, nb::arg("exploration"), nb::arg("bits"), nb::arg("most"))
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
      .def_rw("progress", &PyStore::progress, nb::arg().none())
      .def_prop_ro("levels", [](const PyStore& s) { return s.store.levels; })
      .def_prop_ro("live_nodes", [](const PyStore& s) { return s.store.live(); })
      .def_prop_ro("peak_nodes", [](const PyStore& s) { return s.store.peak(); })
      .def_prop_ro("steps", [](const PyStore& s) { return s.store.steps(); })
      .def_prop_ro("closed", [](const PyStore& s) { return s.store.closed(); })
      .def_prop_ro("collections", [](const PyStore& s) { return s.store.collections(); })
      .def_prop_ro("bytes", [](const PyStore& s) { return s.store.bytes(); });
}
