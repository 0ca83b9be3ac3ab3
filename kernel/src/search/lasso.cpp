#include "search/lasso.hpp"

#include <algorithm>
#include <numeric>
#include <unordered_map>

#include "diagrams/store.hpp"
#include "search/draw.hpp"
#include "search/packed.hpp"

namespace mcpn::search {

namespace {

struct Limit {
  Lasso::Outcome outcome;
};

// A step of the product; nothing fires where the transition is kNone.
struct Step {
  Transition transition;
  std::uint32_t edge;  // of the state of the automaton that it leaves
};

// Marking and state of the automaton, by number in the order in which they were found.
struct Pair {
  std::uint32_t marking, state;
};

class Product {
 public:
  Product(const TokenNet& net, const Goals& goals, const std::vector<std::uint32_t>& roots, const Automaton& automaton,
          std::uint32_t bits, const LassoOptions& options)
      : net_(net), goals_(goals), roots_(roots), automaton_(automaton), options_(options), markings_(net.places, bits),
        words_((roots.size() + 63) / 64), slots_(1u << 12, kNone), draw_(options.seed), keys_(net.rules.size()),
        tokens_(net.places), seen_(net.places) {
    std::iota(keys_.begin(), keys_.end(), 0u);
    if (options.seed)
      for (auto& key : keys_) key = std::uint32_t(draw_.next() >> 32);
  }

  std::uint32_t begin(const Marking& initial) {
    if (!markings_.fits(initial)) throw Limit{Lasso::tokens};
    return number({marking(markings_.packed(initial)), 0}).first;
  }
  std::size_t size() const { return pairs_.size(); }
  std::uint32_t state(std::uint32_t at) const { return pairs_[at].state; }
  const AutomatonEdge& edge(std::uint32_t at, const Step& step) const {
    return automaton_.edges[pairs_[at].state][step.edge];
  }

  // Appends the steps from a pair, those to be tried first last. Returns whether every path from it is accepted.
  bool expand(std::uint32_t at, std::vector<Step>& found) {
    const Pair pair = pairs_[at];
    markings_.get(pair.marking, tokens_, row_);
    net_.collect(tokens_, enabled_);
    const auto& edges = automaton_.edges[pair.state];
    const std::size_t first = found.size();
    for (std::uint32_t e = 0; e < edges.size(); ++e) {
      const AutomatonEdge& edge = edges[e];
      const bool holds = std::all_of(edge.literals.begin(), edge.literals.end(), [&](std::uint32_t literal) {
        return truths_[pair.marking * words_ + literal / 64] >> literal % 64 & 1;
      });
      if (!holds) continue;
      if (edge.any && edge.rests && automaton_.accepting_all[edge.target]) return true;
      if (enabled_.empty() && edge.rests) found.push_back({kNone, e});
      for (const Transition t : enabled_)
        if (edge.any || std::binary_search(edge.fired.begin(), edge.fired.end(), t)) found.push_back({t, e});
    }
    order(found, first);
    return false;
  }

  // The pair that a step leads to, and whether it is new.
  std::pair<std::uint32_t, bool> after(std::uint32_t at, const Step& step) {
    const Pair pair = pairs_[at];
    const std::uint32_t target = automaton_.edges[pair.state][step.edge].target;
    if (step.transition == kNone) return number({pair.marking, target});
    markings_.get(pair.marking, row_);
    if (!markings_.fire(row_, net_.rules[step.transition])) throw Limit{Lasso::tokens};
    return number({marking(row_), target});
  }

  std::uint64_t bytes() const {
    return markings_.bytes() + truths_.capacity() * 8 + pairs_.capacity() * sizeof(Pair) + slots_.capacity() * 4;
  }

 private:
  // Even seeds try transitions in one drawn order everywhere, which comes round soon; odd ones in a new one at
  // each marking. 0 keeps the order of the net.
  void order(std::vector<Step>& found, std::size_t first) {
    const auto begin = found.begin() + std::ptrdiff_t(first);
    if (options_.seed % 2 == 0) {
      std::stable_sort(begin, found.end(), [&](const Step& a, const Step& b) {
        const auto left = a.transition == kNone ? 0 : keys_[a.transition], right = b.transition == kNone ? 0 : keys_[b.transition];
        return left > right;
      });
      return;
    }
    for (std::size_t left = found.size() - first; left > 1; --left)
      std::swap(begin[std::ptrdiff_t(left - 1)], begin[std::ptrdiff_t(draw_.below(left))]);
  }

  std::uint32_t marking(const Packed::Row& row) {
    const auto [number, fresh] = markings_.add(row);
    if (fresh) {
      if (number >= kNone - 1) throw Limit{Lasso::bytes};
      markings_.get(number, seen_, scratch_);
      const std::vector<Tokens> sums = goals_.sums(seen_);
      std::uint64_t enabled = 1;
      if (asks_dead()) {
        net_.collect(seen_, found_);
        enabled = found_.size();
      }
      truths_.resize(truths_.size() + words_, 0);
      for (std::uint32_t i = 0; i < roots_.size(); ++i)
        if (goals_.holds(roots_[i], sums, enabled)) truths_[number * words_ + i / 64] |= std::uint64_t(1) << i % 64;
    }
    return number;
  }
  bool asks_dead() {
    if (!asks_dead_)
      asks_dead_ = std::any_of(roots_.begin(), roots_.end(), [&](std::uint32_t r) { return goals_.asks_dead(r); });
    return *asks_dead_;
  }

  std::pair<std::uint32_t, bool> number(Pair pair) {
    std::uint64_t at = slot(pair);
    for (; slots_[at] != kNone; at = (at + 1) & (slots_.size() - 1))
      if (pairs_[slots_[at]].marking == pair.marking && pairs_[slots_[at]].state == pair.state) return {slots_[at], false};
    if (pairs_.size() >= kNone - 1) throw Limit{Lasso::bytes};
    slots_[at] = std::uint32_t(pairs_.size());
    pairs_.push_back(pair);
    if (pairs_.size() * 3 > slots_.size() * 2) {
      slots_.assign(slots_.size() * 2, kNone);
      for (std::uint32_t i = 0; i < pairs_.size(); ++i) {
        at = slot(pairs_[i]);
        while (slots_[at] != kNone) at = (at + 1) & (slots_.size() - 1);
        slots_[at] = i;
      }
    }
    return {std::uint32_t(pairs_.size() - 1), true};
  }
  std::uint64_t slot(Pair pair) const {
    const std::uint64_t key = std::uint64_t(pair.state) << 32 | pair.marking;
    return hash_words(&key, 1) & (slots_.size() - 1);
  }

  const TokenNet& net_;
  const Goals& goals_;
  const std::vector<std::uint32_t>& roots_;
  const Automaton& automaton_;
  const LassoOptions& options_;
  Packed markings_;
  std::size_t words_;                  // of the truths of the roots at one marking
  std::vector<std::uint64_t> truths_;
  std::vector<Pair> pairs_;
  std::vector<std::uint32_t> slots_;
  Draw draw_;
  std::vector<std::uint32_t> keys_;
  std::optional<bool> asks_dead_;
  Marking tokens_, seen_;
  Packed::Row row_, scratch_;
  std::vector<Transition> enabled_, found_;
};

class Finder {
 public:
  Finder(Product& product, const Automaton& automaton, const LassoOptions& options, const GoOn& go_on)
      : product_(product), automaton_(automaton), options_(options), go_on_(go_on) {}

  Lasso run(const Marking& initial) {
    const std::uint32_t first = product_.begin(initial);
    if (automaton_.accepting_all[0]) return {Lasso::found};
    if (enter(first, {kNone, 0}, 0)) return path();
    for (std::uint64_t count = 0; !frames_.empty(); ++count) {
      if (count >= options_.max_steps) throw Limit{Lasso::steps};
      if ((count & 0xFFF) == 0xFFF) watch();
      Frame& frame = frames_.back();
      if (steps_.size() == frame.begin) {
        leave();
        continue;
      }
      const Step step = steps_.back();
      steps_.pop_back();
      const AutomatonEdge& edge = product_.edge(frame.at, step);
      const auto [target, fresh] = product_.after(frame.at, step);
      if (automaton_.accepting_all[edge.target]) {
        Lasso decided = path();
        if (step.transition != kNone) decided.run.push_back(step.transition);
        return decided;
      }
      if (fresh) {
        if (enter(target, step, edge.marks)) return path();
      } else if (alive_[target]) {
        std::uint64_t marks = edge.marks;
        while (regions_.back().first > target) {
          marks |= regions_.back().marks | regions_.back().into;
          regions_.pop_back();
        }
        regions_.back().marks |= marks;
        if (regions_.back().marks == automaton_.marks) return closed();
      }
    }
    return {Lasso::none, product_.size()};
  }

 private:
  struct Frame {
    std::uint32_t at;
    std::size_t begin;  // of its steps
    Step by;            // that led to it
  };
  // A component as far as it is known: its first pair, the marks inside, those of the step that led to it.
  struct Region {
    std::uint32_t first;
    std::uint64_t marks, into;
  };

  bool enter(std::uint32_t at, Step by, std::uint64_t marks) {
    alive_.push_back(true);  // pairs are numbered in the order in which they are entered
    stack_.push_back(at);
    frames_.push_back({at, steps_.size(), by});
    regions_.push_back({at, 0, marks});
    return product_.expand(at, steps_);
  }
  void leave() {
    const std::uint32_t at = frames_.back().at;
    frames_.pop_back();
    if (regions_.back().first != at) return;
    regions_.pop_back();
    while (!stack_.empty() && stack_.back() >= at) {
      alive_[stack_.back()] = false;
      stack_.pop_back();
    }
  }
  void watch() {
    const std::uint64_t own = steps_.capacity() * sizeof(Step) + frames_.capacity() * sizeof(Frame) +
                              stack_.capacity() * 4 + alive_.capacity() / 8;
    if (product_.bytes() + own > options_.max_bytes) throw Limit{Lasso::bytes};
    if (!go_on_()) throw Interrupted();
  }

  Lasso path(std::uint32_t last = kNone) const {
    Lasso found{Lasso::found, product_.size()};
    for (const Frame& frame : frames_) {
      if (frame.by.transition != kNone) found.run.push_back(frame.by.transition);
      if (frame.at == last) break;
    }
    return found;
  }
  // A run into the last component, and round it by all marks.
  Lasso closed() {
    const std::uint32_t first = regions_.back().first;
    Lasso found = path(first);
    const std::size_t cycle = found.run.size();
    std::uint64_t missing = automaton_.marks;
    std::uint32_t at = first;
    do {
      at = onward(at, found.run, [&](std::uint32_t, const AutomatonEdge& edge) {
        return automaton_.marks == 0 || (edge.marks & missing);
      }, first, missing);
    } while (missing);
    if (at != first)
      onward(at, found.run, [&](std::uint32_t target, const AutomatonEdge&) { return target == first; }, first, missing);
    if (found.run.size() > cycle) found.cycle = cycle;  // else nothing may fire
    return found;
  }
  // Appends a shortest run inside the last component to a step that is wanted, that one included.
  template <class Wanted>
  std::uint32_t onward(std::uint32_t from, std::vector<Transition>& run, Wanted wanted, std::uint32_t first,
                       std::uint64_t& missing) {
    std::unordered_map<std::uint32_t, std::pair<std::uint32_t, Transition>> came{{from, {from, kNone}}};
    std::vector<std::uint32_t> queue{from};
    std::vector<Step> steps;
    for (std::size_t i = 0; i < queue.size(); ++i) {
      const std::uint32_t at = queue[i];
      steps.clear();
      product_.expand(at, steps);
      if (i % 1024 == 1023) watch();
      for (const Step& step : steps) {
        const AutomatonEdge& edge = product_.edge(at, step);
        const std::uint32_t target = product_.after(at, step).first;
        if (target < first || target >= alive_.size() || !alive_[target]) continue;
        if (wanted(target, edge)) {
          std::vector<Transition> back;
          if (step.transition != kNone) back.push_back(step.transition);
          for (std::uint32_t q = at; q != from; q = came[q].first)
            if (came[q].second != kNone) back.push_back(came[q].second);
          run.insert(run.end(), back.rbegin(), back.rend());
          missing &= ~edge.marks;
          return target;
        }
        if (came.try_emplace(target, at, step.transition).second) queue.push_back(target);
      }
    }
    throw std::logic_error("a component leads to all of its steps");
  }

  Product& product_;
  const Automaton& automaton_;
  const LassoOptions& options_;
  const GoOn& go_on_;
  std::vector<Frame> frames_;
  std::vector<Step> steps_;            // of the frames, those of the last one at the end
  std::vector<std::uint32_t> stack_;   // pairs whose component may still grow
  std::vector<bool> alive_;            // by pair: whether it is among them
  std::vector<Region> regions_;
};

}  // namespace

Lasso find_lasso(const TokenNet& net, const Marking& initial, const Goals& goals,
                 const std::vector<std::uint32_t>& roots, const Automaton& automaton, const LassoOptions& options,
                 const GoOn& go_on) {
  Lasso found{Lasso::tokens};
  for (const std::uint32_t bits : kWidths) {  // wider where a place holds more than fits
    Product product(net, goals, roots, automaton, bits, options);
    try {
      return Finder(product, automaton, options, go_on).run(initial);
    } catch (const Limit& limit) {
      found = {limit.outcome, product.size()};
      if (limit.outcome != Lasso::tokens) break;
    }
  }
  return found;
}

}  // namespace mcpn::search
