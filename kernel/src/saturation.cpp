// Saturation (Ciardo, Lüttgen, Siminiscalchi 2001) on zero-suppressed diagrams of 1-safe markings.
//
// Every node is closed under the events that begin at its level or below before it is used above. A level that a
// diagram skips is a place without token: events that begin there by producing into it, or by testing that it is
// unmarked, must still be fired; `wakes_` says where such levels are, so that all others are passed over.
#include "store.hpp"

#include <algorithm>

namespace mcpn {

void Store::declare(const std::vector<std::uint32_t>& events) {
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
    if (entry.a >> 32 >= op_saturate) entry = {};
}

Node Store::saturate(Node a) { return saturate_from(0, a); }

Node Store::saturate_from(Level from, Node a) {
  if (a == 0) return 0;
  const Level at = std::min(level(a), wakes_[from]);
  if (at == levels) return a;
  Node result;
  if (recall(op_saturate, at, a, 0, result)) return result;
  const Branches x = split(a, at);
  const Node low = saturate_from(at + 1, x.lo);
  const Node high = saturate_from(at + 1, x.hi);
  result = close(at, low, high);
  remember(op_saturate, at, a, 0, result);
  return result;
}

// Fires an event from one of its levels on, and closes what it makes under the events at `from` and below.
Node Store::fire(std::uint32_t event, Level from, Node a) {
  if (a == 0 || event == 0) return a;  // children of closed nodes are closed
  const Suffix head = suffixes_[event];
  if (level(a) > head.level && (head.touch == Touch::consume || head.touch == Touch::read)) return 0;
  const Level at = std::min({level(a), head.level, wakes_[from]});
  Node result;
  if (recall(op_fire, event, at, a, result)) return result;
  const Branches x = split(a, at);
  if (at < head.level) {
    const Node low = fire(event, at + 1, x.lo);
    const Node high = fire(event, at + 1, x.hi);
    result = close(at, low, high);
  } else {
    switch (head.touch) {
      case Touch::consume: result = close(at, fire(head.next, at + 1, x.hi), 0); break;
      case Touch::produce: result = close(at, 0, fire(head.next, at + 1, x.lo)); break;
      case Touch::read: result = close(at, 0, fire(head.next, at + 1, x.hi)); break;
      default: result = close(at, fire(head.next, at + 1, x.lo), 0);
    }
  }
  remember(op_fire, event, at, a, result);
  return result;
}

// A node of two closed children, closed under the events that begin at its level.
Node Store::close(Level at, Node low, Node high) {
  if (low == 0 && high == 0) return 0;
  const auto& events = tops_[at];
  if (!events.empty()) {
    std::vector<Node> fired(events.size(), 0);  // what each event was last fired on
    for (bool changed = true; changed;) {
      changed = false;
      for (std::size_t i = 0; i < events.size(); ++i) {
        const Suffix head = suffixes_[events[i]];
        const bool from_high = head.touch == Touch::consume || head.touch == Touch::read;
        const bool into_high = head.touch == Touch::produce || head.touch == Touch::read;
        const Node source = from_high ? high : low;
        if (source == 0 || source == fired[i]) continue;
        fired[i] = source;
        Node& target = into_high ? high : low;
        const Node wider = join(target, fire(head.next, at + 1, source));
        if (wider != target) {
          target = wider;
          changed = true;
        }
      }
    }
  }
  return make(at, low, high);
}

}  // namespace mcpn
