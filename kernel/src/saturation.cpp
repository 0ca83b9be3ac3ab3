// Saturation (Ciardo, Lüttgen, Siminiscalchi 2001) on zero-suppressed diagrams of 1-safe markings, inside a given
// set where one is given (constrained saturation: Zhao, Ciardo 2009).
//
// Every node is closed under the events that begin at its level or below before it is used above. A level that a
// diagram skips is a place without token: events that begin there by producing into it, or by testing that it is
// unmarked, must still be fired; `wakes_` says where such levels are, so that all others are passed over.
#include "store.hpp"

#include <algorithm>
#include <array>

namespace mcpn {

void Store::declare(const std::vector<std::uint32_t>& events) {
  if (events == declared_ && !tops_.empty()) return;
  declared_ = events;
  tops_.assign(levels + 1, {});
  wakes_.assign(levels + 2, levels);
  for (const std::uint32_t event : events)
    if (event) tops_[suffixes_[event].level].push_back(event);
  for (Level at = levels; at-- > 0;) {
    const bool wakes = std::any_of(tops_[at].begin(), tops_[at].end(), [&](std::uint32_t event) {
      return suffixes_[event].touch == Touch::produce || suffixes_[event].touch == Touch::zero;
    });
    wakes_[at] = wakes ? at : wakes_[at + 1];
  }
  for (Cached& entry : cache_)  // what was closed under other events
    if (entry.a != ~0ull && entry.a >> 52 >= op_saturate) entry = {};
}

Node Store::saturate(Node a, Node within) {
  if (within == kAnything) return saturate_from(0, a, within);
  const Held start(*this, meet(a, within));
  return saturate_from(0, start, within);
}

// Closes a set, which lies inside the limit, under the events at `from` and below.
Node Store::saturate_from(Level from, Node a, Node within) {
  if (a == 0) return 0;
  const Level at = std::min(level(a), wakes_[from]);
  if (at == levels) return a;
  within = below(within, at);
  Node result;
  if (recall(op_saturate, at, 0, a, within, result)) return result;
  const Branches x = split(a, at), w = limits(within, at);
  const Held low(*this, saturate_from(at + 1, x.lo, w.lo));
  const Held high(*this, saturate_from(at + 1, x.hi, w.hi));
  result = close(at, low, high, w);
  remember(op_saturate, at, 0, a, within, result);
  if (within != kAnything) remember(op_saturate, at, 0, result, within, result);
  return result;
}

// Fires an event from one of its levels on, and closes what it makes under the events at `from` and below.
Node Store::fire(std::uint32_t event, Level from, Node a, Node within) {
  if (a == 0 || within == 0) return 0;
  if (event == 0) {
    if (within == kAnything) return a;  // children of closed nodes are closed
    const Held inside(*this, meet(a, within));  // closed under another limit, perhaps
    return saturate_from(from, inside, within);
  }
  const Suffix head = suffixes_[event];
  if (level(a) > head.level && (head.touch == Touch::consume || head.touch == Touch::read)) return 0;
  const Level at = std::min({level(a), head.level, wakes_[from]});
  within = below(within, at);
  Node result;
  if (recall(op_fire, at, event, a, within, result)) return result;
  const Branches x = split(a, at), w = limits(within, at);
  if (at < head.level) {
    const Held low(*this, fire(event, at + 1, x.lo, w.lo));
    const Held high(*this, fire(event, at + 1, x.hi, w.hi));
    result = close(at, low, high, w);
  } else {
    const bool from_high = head.touch == Touch::consume || head.touch == Touch::read;
    const bool into_high = head.touch == Touch::produce || head.touch == Touch::read;
    const Held made(*this, fire(head.next, at + 1, from_high ? x.hi : x.lo, into_high ? w.hi : w.lo));
    result = into_high ? close(at, 0, made, w) : close(at, made, 0, w);
  }
  remember(op_fire, at, event, a, within, result);
  return result;
}

// A node of two closed children, closed under the events that begin at its level.
Node Store::close(Level at, Node lo, Node hi, Branches within) {
  if (lo == 0 && hi == 0) return 0;
  const auto& events = tops_[at];
  if (events.empty()) return make(at, lo, hi);
  Held low(*this, lo), high(*this, hi);
  // Which version of its source each event was last fired on; few events begin at most levels.
  std::array<std::uint32_t, 16> few{};
  std::vector<std::uint32_t> many(events.size() > few.size() ? events.size() : 0);
  std::uint32_t* fired = many.empty() ? few.data() : many.data();
  std::uint32_t low_version = 1, high_version = 1;
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < events.size(); ++i) {
      const Suffix head = suffixes_[events[i]];
      const bool from_high = head.touch == Touch::consume || head.touch == Touch::read;
      const bool into_high = head.touch == Touch::produce || head.touch == Touch::read;
      const Node source = from_high ? high : low;
      const std::uint32_t version = from_high ? high_version : low_version;
      if (source == 0 || fired[i] == version) continue;
      fired[i] = version;
      const Held made(*this, fire(head.next, at + 1, source, into_high ? within.hi : within.lo));
      Held& target = into_high ? high : low;
      const Node wider = join(target, made);
      if (wider != target) {
        target = wider;
        ++(into_high ? high_version : low_version);
        changed = true;
      }
    }
  }
  return make(at, low, high);
}

}  // namespace mcpn
