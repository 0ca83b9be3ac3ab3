// The product of a net and an automaton, marking by marking as it is asked for.
#pragma once

#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "diagrams/store.hpp"
#include "search/draw.hpp"
#include "search/lasso.hpp"
#include "search/packed.hpp"

namespace mcpn::search {

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
  Product(const PathTask& task, std::uint32_t bits, std::uint64_t seed)
      : net_(task.net), goals_(task.goals), roots_(task.roots), automaton_(task.automaton), seed_(seed),
        markings_(net_.places, bits), words_((roots_.size() + 63) / 64), slots_(1u << 12, kNone), draw_(seed),
        keys_(net_.rules.size()), tokens_(net_.places), seen_(net_.places) {
    std::iota(keys_.begin(), keys_.end(), 0u);
    if (seed)
      for (auto& key : keys_) key = std::uint32_t(draw_.next() >> 32);
  }

  std::uint32_t begin(const Marking& initial) {
    if (!markings_.fits(initial)) throw Limit{Lasso::tokens};
    return number({marking(markings_.packed(initial)), 0}).first;
  }
  std::size_t size() const { return pairs_.size(); }
  std::uint32_t state(std::uint32_t at) const { return pairs_[at].state; }
  // The marking that was expanded last, and what may fire there.
  const Marking& tokens() const { return tokens_; }
  const std::vector<Transition>& enabled() const { return enabled_; }
  void marking_of(std::uint32_t at, Marking& marking) { markings_.get(pairs_[at].marking, marking, row_); }
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
    if (seed_ % 2 == 0) {
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
  std::uint64_t seed_;
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

}  // namespace mcpn::search
