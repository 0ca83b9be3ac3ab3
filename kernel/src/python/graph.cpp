// Steps and closures on a graph in compressed sparse rows: numpy arrays in, masks over its states out.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <tuple>
#include <utility>
#include <vector>

#include "python/module.hpp"
#include "python/numbers.hpp"
#include "python/signals.hpp"
#include "wide.hpp"

namespace nb = nanobind;
using mcpn::Wide;
using mcpn::WideWord;

namespace {

using State = std::uint32_t;
template <class T> using Column = nb::ndarray<const T, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
template <class T> using Array = nb::ndarray<nb::numpy, T, nb::ndim<1>>;
using Mask = Column<bool>;

template <class T> struct Values {  // an array that Python will own
  explicit Values(std::size_t count) : owned(new T[count]()), size(count) {}
  Array<T> array() {
    T* data = owned.release();
    return {data, {size}, nb::capsule(data, [](void* p) noexcept { delete[] static_cast<T*>(p); })};
  }
  T& operator[](std::size_t at) { return owned[at]; }
  std::unique_ptr<T[]> owned;
  std::size_t size;
};

class Bits {  // one state in 64 a word: closures look at random states, whose bits stay in the processor's cache
 public:
  explicit Bits(std::size_t size) : words_((size + 63) / 64) {}
  bool operator[](std::size_t at) const { return words_[at / 64] >> at % 64 & 1; }
  void set(std::size_t at) { words_[at / 64] |= std::uint64_t(1) << at % 64; }
  void clear(std::size_t at) { words_[at / 64] &= ~(std::uint64_t(1) << at % 64); }

 private:
  std::vector<std::uint64_t> words_;
};

// Edges of state s: at offsets[s] to offsets[s + 1], those alone that `keep` names. Signals are looked for as rows are
// read.
struct Rows {
  Rows(const Column<std::int64_t>& begins, const Column<State>& ends, const std::optional<Mask>& kept = {})
      : offsets(begins.data()), targets(ends.data()), keep(kept ? kept->data() : nullptr), edges(ends.shape(0)) {
    if (begins.shape(0) == 0 || begins(0) != 0 || begins(begins.shape(0) - 1) != std::int64_t(edges))
      throw std::invalid_argument("one row of targets for each state");
    states = begins.shape(0) - 1;
    for (std::size_t s = 0; s < states; ++s)
      if (begins(s) > begins(s + 1)) throw std::invalid_argument("one row of targets for each state");
    if (kept) expect(*kept, edges);
  }
  static const bool* expect(const Mask& mask, std::size_t size) {
    if (mask.shape(0) != size) throw std::invalid_argument("a mask of another size");
    return mask.data();
  }
  State target(std::int64_t edge) const {
    const State found = targets[edge];
    if (found >= states) throw std::invalid_argument("no such state");
    return found;
  }
  template <class F> void each(std::size_t state, F body) {
    signals.after(std::size_t(offsets[state + 1] - offsets[state]) + 1);
    for (std::int64_t e = offsets[state]; e < offsets[state + 1]; ++e)
      if (!keep || keep[e]) body(target(e));
  }
  bool any(std::size_t state, const Bits& among) {
    signals.after(std::size_t(offsets[state + 1] - offsets[state]) + 1);
    for (std::int64_t e = offsets[state]; e < offsets[state + 1]; ++e)
      if ((!keep || keep[e]) && among[target(e)]) return true;
    return false;
  }
  const std::int64_t* offsets;
  const State* targets;
  const bool* keep;
  std::size_t edges, states = 0;
  Signals signals;
};

std::tuple<Array<std::int64_t>, Array<State>> incoming(const Column<std::int64_t>& offsets, const Column<State>& targets,
                                                       const std::optional<Mask>& keep) {
  Rows rows(offsets, targets, keep);
  Values<std::int64_t> begin(rows.states + 1);
  std::optional<Values<State>> sources;
  {
    const nb::gil_scoped_release release;
    std::int64_t kept = 0;
    for (std::size_t s = 0; s < rows.states; ++s) rows.each(s, [&](State t) { ++begin[t], ++kept; });
    for (std::size_t s = 0, before = 0; s <= rows.states; ++s) {  // where the row of each state ends
      before += std::size_t(begin[s]);
      begin[s] = std::int64_t(before);
    }
    sources.emplace(std::size_t(kept));
    for (std::size_t s = rows.states; s-- > 0;)
      rows.each(s, [&](State t) { (*sources)[std::size_t(--begin[t])] = State(s); });
  }
  return {begin.array(), sources->array()};
}

Array<bool> spread(const Column<std::int64_t>& offsets, const Column<State>& targets, const Mask& begin,
                   const std::optional<Mask>& along, const std::optional<Mask>& keep) {
  Rows rows(offsets, targets, keep);
  const bool* start = Rows::expect(begin, rows.states);
  const bool* allowed = along ? Rows::expect(*along, rows.states) : nullptr;
  Values<bool> found(rows.states);
  {
    const nb::gil_scoped_release release;
    Bits closed(rows.states);
    std::vector<State> queue;
    for (std::size_t s = 0; s < rows.states; ++s) {
      if (start[s] || (allowed && !allowed[s])) closed.set(s);
      if (start[s]) queue.push_back(State(s));
      found[s] = start[s];
    }
    for (std::size_t next = 0; next < queue.size(); ++next)
      rows.each(queue[next], [&](State t) {
        if (closed[t]) return;
        closed.set(t);
        found[t] = true;
        queue.push_back(t);
      });
  }
  return found.array();
}

Array<bool> staying(const Column<std::int64_t>& offsets, const Column<State>& targets,
                    const Column<std::int64_t>& incoming_offsets, const Column<State>& sources, const Mask& along) {
  Rows rows(offsets, targets), back(incoming_offsets, sources);
  const bool* inside = Rows::expect(along, rows.states);
  if (back.states != rows.states) throw std::invalid_argument("rows of another graph");
  Values<bool> left(rows.states);
  {
    const nb::gil_scoped_release release;
    Bits within(rows.states);
    for (std::size_t s = 0; s < rows.states; ++s) {
      left[s] = inside[s];
      if (inside[s]) within.set(s);
    }
    std::vector<State> onward(rows.states), queue;
    for (std::size_t s = 0; s < rows.states; ++s) {
      if (!inside[s]) continue;
      rows.each(s, [&](State t) { onward[s] += within[t]; });
      if (!onward[s] && rows.offsets[s] != rows.offsets[s + 1]) queue.push_back(State(s));
    }
    for (std::size_t next = 0; next < queue.size(); ++next) {
      left[queue[next]] = false;
      back.each(queue[next], [&](State s) {
        if (within[s] && --onward[s] == 0) queue.push_back(s);
      });
    }
  }
  return left.array();
}

constexpr int kMostSweeps = 64;  // about as many take the time in which the edges of a large graph are turned round

// Looks at all states again and again, from the last to the first and back: most edges of a graph that was explored
// breadth first lead to later states, so that few sweeps do. `decide` says of a state by its targets whether it
// changes. Whether in the end none does.
template <class Decide> bool swept(std::size_t states, Decide decide) {
  Signals signals;
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    bool changed = false;
    for (std::size_t i = 0; i < states; ++i) {
      signals.after(1);
      changed |= decide(sweep % 2 ? i : states - 1 - i);
    }
    if (!changed) return true;
  }
  return false;
}

std::tuple<Array<bool>, bool> sweep_reaching(const Column<std::int64_t>& offsets, const Column<State>& targets,
                                             const Mask& goal, const std::optional<Mask>& along,
                                             const std::optional<Mask>& keep) {
  Rows rows(offsets, targets, keep);
  const bool* wanted = Rows::expect(goal, rows.states);
  const bool* allowed = along ? Rows::expect(*along, rows.states) : nullptr;
  Values<bool> found(rows.states);
  bool ended = false;
  {
    const nb::gil_scoped_release release;
    Bits there(rows.states);
    for (std::size_t s = 0; s < rows.states; ++s)
      if ((found[s] = wanted[s])) there.set(s);
    ended = swept(rows.states, [&](std::size_t s) {
      if (found[s] || (allowed && !allowed[s]) || !rows.any(s, there)) return false;
      there.set(s);
      return found[s] = true;
    });
  }
  return {found.array(), ended};
}

std::tuple<Array<bool>, bool> sweep_staying(const Column<std::int64_t>& offsets, const Column<State>& targets,
                                            const Mask& along) {
  Rows rows(offsets, targets);
  const bool* inside = Rows::expect(along, rows.states);
  Values<bool> left(rows.states);
  bool ended = false;
  {
    const nb::gil_scoped_release release;
    Bits within(rows.states);
    for (std::size_t s = 0; s < rows.states; ++s)
      if ((left[s] = inside[s])) within.set(s);
    ended = swept(rows.states, [&](std::size_t s) {
      if (!left[s] || rows.offsets[s] == rows.offsets[s + 1] || rows.any(s, within)) return false;
      within.clear(s);
      left[s] = false;
      return true;
    });
  }
  return {left.array(), ended};
}

// Depth first: a state that is met again on the way to itself is on a cycle.
bool stays(const Column<std::int64_t>& offsets, const Column<State>& targets, const Mask& begin, const Mask& along) {
  Rows rows(offsets, targets);
  const bool* start = Rows::expect(begin, rows.states);
  const bool* inside = Rows::expect(along, rows.states);
  const nb::gil_scoped_release release;
  Bits met(rows.states), done(rows.states);
  std::vector<std::pair<State, std::int64_t>> path;  // with the edge that is looked at next
  for (std::size_t first = 0; first < rows.states; ++first) {
    if (!start[first] || !inside[first] || met[first]) continue;
    met.set(first);
    path.emplace_back(State(first), rows.offsets[first]);
    while (!path.empty()) {
      rows.signals.after(1);
      const State at = path.back().first;
      if (rows.offsets[at] == rows.offsets[at + 1]) return true;
      if (path.back().second == rows.offsets[at + 1]) {
        done.set(at);
        path.pop_back();
        continue;
      }
      const State next = rows.target(path.back().second++);
      if (!inside[next] || done[next]) continue;
      if (met[next]) return true;
      met.set(next);
      path.emplace_back(next, rows.offsets[next]);
    }
  }
  return false;
}

Array<bool> before(const Column<std::int64_t>& offsets, const Column<State>& targets, const Mask& into,
                   const std::optional<Mask>& keep) {
  Rows rows(offsets, targets, keep);
  const bool* wanted = Rows::expect(into, rows.states);
  Values<bool> found(rows.states);
  {
    const nb::gil_scoped_release release;
    Bits goal(rows.states);
    for (std::size_t s = 0; s < rows.states; ++s)
      if (wanted[s]) goal.set(s);
    for (std::size_t s = 0; s < rows.states; ++s) found[s] = rows.any(s, goal);
  }
  return found.array();
}

using Term = std::tuple<std::uint32_t, std::uint32_t, std::uint32_t, std::int64_t>;  // word, shift, width, weight

using Sum = std::vector<Term>;
using Markings = nb::ndarray<const std::uint64_t, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

void check(const Markings& markings, const Sum& sum) {
  for (const auto& [word, shift, width, weight] : sum)
    if (word >= markings.shape(1) || width < 1 || width > 63 || shift > 64 - width)
      throw std::invalid_argument("no such field");
}

std::uint64_t most_in(std::uint32_t width) { return (std::uint64_t(1) << width) - 1; }

// Whether no marking's sum is beyond 64 bits.
bool is_narrow(const Sum& sum) {
  constexpr Wide most = std::numeric_limits<std::int64_t>::max();
  Wide farthest = 0;
  for (const auto& [word, shift, width, weight] : sum) {
    farthest += (weight < 0 ? -Wide(weight) : Wide(weight)) * most_in(width);
    if (farthest > most) return false;
  }
  return true;
}

std::int64_t weighed(const std::uint64_t* marking, const Sum& sum) {
  std::int64_t found = 0;
  for (const auto& [word, shift, width, weight] : sum)
    found += weight * std::int64_t(marking[word] >> shift & most_in(width));
  return found;
}

// The same of any number of terms: 2^64 times the first, and the second.
std::pair<Wide, std::uint64_t> weighed_far(const std::uint64_t* marking, const Sum& sum) {
  Wide high = 0;
  WideWord low = 0;
  for (const auto& [word, shift, width, weight] : sum) {
    const Wide term = Wide(weight) * (marking[word] >> shift & most_in(width));
    high += term >> 64;
    low += std::uint64_t(term);
  }
  return {high + Wide(low >> 64), std::uint64_t(low)};
}

Array<std::int64_t> weigh(const Markings& markings, const Sum& sum) {
  check(markings, sum);
  const std::uint64_t* marking = markings.data();
  Values<std::int64_t> sums(markings.shape(0));
  {
    const nb::gil_scoped_release release;
    const bool narrow = is_narrow(sum);
    Signals signals;
    for (std::size_t s = 0; s < sums.size; ++s, marking += markings.shape(1)) {
      signals.after(1 + sum.size());
      if (narrow) {
        sums[s] = weighed(marking, sum);
        continue;
      }
      const auto [high, low] = weighed_far(marking, sum);
      sums[s] = std::int64_t(low);
      if (high != (sums[s] < 0 ? -1 : 0)) throw std::overflow_error("a sum of tokens is beyond 64 bits");
    }
  }
  return sums.array();
}

using Bounds = std::vector<std::tuple<Sum, Wide>>;

struct Bound { const Sum& sum; bool narrow; Wide most; };
struct ReadBits { std::size_t word; std::uint64_t read, marked; };  // those that are read, and which of them are set

// Conditions that hold together. Those on single bits are read together, a word at a time.
struct Conditions {
  std::vector<ReadBits> bits;
  std::vector<Bound> bounds;
  bool never = false;

  void add(const Sum& sum, Wide most) {
    if (sum.size() != 1 || std::get<2>(sum[0]) != 1) {
      bounds.push_back({sum, is_narrow(sum), most});
      return;
    }
    const auto& [word, shift, width, weight] = sum[0];
    const bool unmarked = most >= 0, marked = most >= weight;  // whether it holds of either
    if (unmarked && marked) return;
    never = never || (!unmarked && !marked);
    const auto same = [word = word](const ReadBits& known) { return known.word == word; };
    auto known = std::find_if(bits.begin(), bits.end(), same);
    if (known == bits.end()) known = bits.insert(bits.end(), {word, 0, 0});
    const std::uint64_t bit = std::uint64_t(1) << shift, set = marked ? bit : 0;
    never = never || ((known->read & bit) && (known->marked & bit) != set);
    known->read |= bit;
    known->marked |= set;
  }

  bool hold(const std::uint64_t* marking) const {
    for (const ReadBits& each : bits)
      if ((marking[each.word] & each.read) != each.marked) return false;
    return std::all_of(bounds.begin(), bounds.end(), [&](const Bound& bound) {
      if (bound.narrow) return weighed(marking, bound.sum) <= bound.most;
      return weighed_far(marking, bound.sum) <= std::pair(bound.most >> 64, std::uint64_t(bound.most));
    });
  }
};

// Conditions of which one is enough. Where a marked bit is enough, bits are read a word at a time; of others that want
// a bit marked, those alone are looked at whose rarest bit is.
class Alternatives {
 public:
  Alternatives(const std::vector<Bounds>& alternatives, std::size_t words)
      : enough_(words, 0), keys_(words, 0), keyed_(words * 64) {
    for (const Bounds& all : alternatives) {
      Conditions way;
      for (const auto& [sum, most] : all) way.add(sum, most);
      if (!way.never) ways_.push_back(std::move(way));
    }
    std::vector<std::size_t> wanted(words * 64, 0);
    for (const Conditions& way : ways_) each_wanted(way, [&](std::size_t bit) { ++wanted[bit]; });
    for (std::size_t i = 0; i < ways_.size(); ++i) place(i, wanted);
  }

  std::size_t work() const { return 1 + always_.size(); }

  bool hold(const std::uint64_t* marking) const {
    for (std::size_t w = 0; w < enough_.size(); ++w)
      if (marking[w] & enough_[w]) return true;
    for (const std::size_t i : always_)
      if (ways_[i].hold(marking)) return true;
    for (std::size_t w = 0; w < keys_.size(); ++w)
      for (std::uint64_t left = marking[w] & keys_[w]; left; left &= left - 1)
        for (const std::size_t i : keyed_[w * 64 + std::size_t(std::countr_zero(left))])
          if (ways_[i].hold(marking)) return true;
    return false;
  }

 private:
  template <class F> static void each_wanted(const Conditions& way, F body) {
    for (const ReadBits& each : way.bits)
      for (std::uint64_t left = each.marked; left; left &= left - 1)
        body(each.word * 64 + std::size_t(std::countr_zero(left)));
  }

  void place(std::size_t i, const std::vector<std::size_t>& wanted) {
    const Conditions& way = ways_[i];
    std::size_t key = wanted.size();
    each_wanted(way, [&](std::size_t bit) {
      if (key == wanted.size() || wanted[bit] < wanted[key]) key = bit;
    });
    if (key == wanted.size()) {
      always_.push_back(i);
      return;
    }
    const std::uint64_t bit = std::uint64_t(1) << key % 64;
    if (way.bounds.empty() && way.bits.size() == 1 && way.bits[0].read == bit) {
      enough_[key / 64] |= bit;
      return;
    }
    keys_[key / 64] |= bit;
    keyed_[key].push_back(i);
  }

  std::vector<Conditions> ways_;
  std::vector<std::uint64_t> enough_, keys_;  // by word
  std::vector<std::vector<std::size_t>> keyed_;  // by bit
  std::vector<std::size_t> always_;
};

Array<bool> satisfying(const Markings& markings, const std::vector<Bounds>& alternatives) {
  for (const Bounds& all : alternatives)
    for (const auto& [sum, most] : all) check(markings, sum);
  const Alternatives ways(alternatives, markings.shape(1));
  const std::uint64_t* marking = markings.data();
  Values<bool> found(markings.shape(0));
  {
    const nb::gil_scoped_release release;
    Signals signals;
    for (std::size_t s = 0; s < found.size; ++s, marking += markings.shape(1)) {
      signals.after(ways.work());
      found[s] = ways.hold(marking);
    }
  }
  return found.array();
}

}  // namespace

void bind_graph(nb::module_& module) {
  module.def("incoming", &incoming, nb::arg("offsets"), nb::arg("targets"), nb::arg("keep").none() = nb::none());
  module.def("spread", &spread, nb::arg("offsets"), nb::arg("targets"), nb::arg("begin"),
             nb::arg("along").none() = nb::none(), nb::arg("keep").none() = nb::none());
  module.def("staying", &staying, nb::arg("offsets"), nb::arg("targets"), nb::arg("incoming_offsets"),
             nb::arg("sources"), nb::arg("along"));
  module.def("sweep_reaching", &sweep_reaching, nb::arg("offsets"), nb::arg("targets"), nb::arg("goal"),
             nb::arg("along").none() = nb::none(), nb::arg("keep").none() = nb::none());
  module.def("sweep_staying", &sweep_staying, nb::arg("offsets"), nb::arg("targets"), nb::arg("along"));
  module.def("stays", &stays, nb::arg("offsets"), nb::arg("targets"), nb::arg("begin"), nb::arg("along"));
  module.def("weigh", &weigh, nb::arg("markings"), nb::arg("terms"));
  module.def("satisfying", &satisfying, nb::arg("markings"), nb::arg("alternatives"));
  module.def("before", &before, nb::arg("offsets"), nb::arg("targets"), nb::arg("into"),
             nb::arg("keep").none() = nb::none());
}
