#include "markings/set_clashes.hpp"

#include <algorithm>
#include <deque>

#include "markings/bits.hpp"

namespace mcpn {

std::vector<Word> SetClashes::marked_in(Store& store, Node markings) const {
  std::vector<Word> marked(levels_.size() / 64 + 1);
  const std::vector<bool> support = store.support(markings);
  for (std::uint32_t p = 0; p < levels_.size(); ++p) {
    const auto [at, reverse] = levels_[p];
    if (reverse ? store.filter(markings, store.suffix(at, Touch::zero, 0)) != 0 : support[at]) set_bit(marked.data(), p);
  }
  return marked;
}

void SetClashes::choose(std::uint32_t t) {
  if (has_bit(chosen_.data(), t)) return;
  set_bit(chosen_.data(), t);
  asked_.push_back(t);
}

Node SetClashes::of(Store& store, Node enabled, std::uint32_t t) {
  const std::uint32_t end = net_.rank_end_[t];
  const std::uint32_t waited_for = stubborn_.brings_about(t) ? kNoBit : t;
  std::vector<Word> may(chosen_.size());
  stubborn_.relax(marked_in(store, enabled).data(), end, may, waited_for);
  // What it brings about from some of the markings, and who may clash with that.
  const auto clash = [&](std::uint32_t u, auto found) {
    for (const Transitions* others : {&stubborn_.rivals(u), &stubborn_.crowders(u)})
      for (const std::uint32_t v : *others)
        if (v < end && has_bit(may.data(), v)) found(v);
  };
  asked_.clear();
  std::fill(chosen_.begin(), chosen_.end(), 0);
  choose(t);
  for (std::size_t at = 0; at < asked_.size(); ++at)
    for (const std::uint32_t u : net_.winners_[asked_[at]])
      if (net_.rank_end_[u] < end && has_bit(may.data(), u)) choose(u);
  const Transitions brought(asked_);
  bool any = false;
  for (const std::uint32_t u : brought)
    clash(u, [&](std::uint32_t v) {
      any = true;
      choose(v);
    });
  if (!any) return 0;
  // By place that tells of these, the markings from which it is in reach.
  const Held all(store, enabled);
  std::fill(number_.begin(), number_.end(), 0);
  std::vector<std::uint32_t> places{0};
  std::deque<Held> reach;
  reach.emplace_back(store, 0);
  for (std::size_t at = 0; at < asked_.size(); ++at)
    for (const std::uint32_t p : net_.firings_[asked_[at]].need) {
      if (number_[p]) continue;
      number_[p] = std::uint32_t(places.size());
      places.push_back(p);
      const auto [level, reverse] = levels_[p];
      reach.emplace_back(store, store.filter(all, store.suffix(level, reverse ? Touch::zero : Touch::read, 0)));
      if (reach.back() == all) continue;
      for (const std::uint32_t u : stubborn_.givers(p))
        if (u < end && has_bit(may.data(), u)) choose(u);
    }
  const auto in_reach = [&](std::uint32_t u) {
    Held from(store, all);
    for (const std::uint32_t p : net_.firings_[u].need)
      if (from) from = store.meet(from, reach[number_[p]]);
    return Node(from);
  };
  std::vector<Transitions> askers(places.size());
  for (const std::uint32_t u : asked_)
    for (const std::uint32_t p : net_.firings_[u].need) askers[number_[p]].push_back(u);
  std::deque<std::uint32_t> waiting(asked_.rbegin(), asked_.rend());
  std::vector<Word> queued(chosen_);
  while (!waiting.empty()) {
    const std::uint32_t u = waiting.front();
    waiting.pop_front();
    queued[u / 64] &= ~(Word(1) << u % 64);
    if (u == waited_for) continue;
    const Held from(store, in_reach(u));
    if (!from) continue;
    for (const std::uint32_t p : net_.firings_[u].put) {
      if (!number_[p] || reach[number_[p]] == all) continue;
      const Node wider = store.join(reach[number_[p]], from);
      if (wider == reach[number_[p]]) continue;
      reach[number_[p]] = wider;
      for (const std::uint32_t v : askers[number_[p]])
        if (!has_bit(queued.data(), v)) {
          set_bit(queued.data(), v);
          waiting.push_back(v);
        }
    }
  }
  // By what it brings about, the markings from which it does.
  std::vector<std::uint32_t> place_of(net_.transitions());
  std::deque<Held> from;
  for (const std::uint32_t u : brought) {
    place_of[u] = std::uint32_t(from.size());
    from.emplace_back(store, u == t ? enabled : 0);
  }
  Held clashing(store, 0);
  waiting.assign(1, t);
  while (!waiting.empty()) {
    const std::uint32_t u = waiting.front();
    waiting.pop_front();
    for (const std::uint32_t v : net_.winners_[u]) {
      if (net_.rank_end_[v] >= end || !has_bit(may.data(), v)) continue;
      Held& known = from[place_of[v]];
      const Held there(store, in_reach(v));
      const Held here(store, store.meet(from[place_of[u]], there));
      const Node wider = store.join(known, here);
      if (wider == known) continue;
      known = wider;
      waiting.push_back(v);
    }
  }
  for (const std::uint32_t u : brought)
    clash(u, [&](std::uint32_t v) {
      const Held there(store, in_reach(v));
      const Held here(store, store.meet(from[place_of[u]], there));
      clashing = store.join(clashing, here);
    });
  return clashing;
}

}  // namespace mcpn
