#include "markings/narrowed.hpp"

#include <bit>
#include <deque>
#include <unordered_map>
#include <unordered_set>

namespace mcpn {

Node Narrowed::covering(Level first) {
  while (cut() > first) widen();
  return at_;
}

Node Narrowed::from(Level first) {
  covering(first);
  for (Level next = cut() + kBetween; next <= first && next < store_.levels; next += kBetween)
    if (!narrow(next)) break;
  return at_;
}

// Sets the levels before a cut aside, unless they are too few to number the parts.
bool Narrowed::narrow(Level cut) {
  Above above{at_, cut, {}};
  std::unordered_set<Node> seen;
  std::vector<Node> stack{above.top};
  while (!stack.empty()) {
    const Node n = stack.back();
    stack.pop_back();
    if (n == 0 || !seen.insert(n).second) continue;
    if (store_.level(n) >= cut) {
      above.parts.push_back(n);
      continue;
    }
    stack.push_back(store_.hi(n));
    stack.push_back(store_.lo(n));
  }
  if (Level(std::bit_width(above.parts.size())) > cut) return false;
  at_ = above.parts.empty() ? Node(0) : numbered(above.parts, 0, 0, above.parts.size());
  store_.keep(above.top);
  above_.push_back(std::move(above));
  return true;
}

// Puts the levels on again that were set aside last.
void Narrowed::widen() {
  const Above above = std::move(above_.back());
  above_.pop_back();
  struct Dropped {
    Store& store;
    Node node;
    ~Dropped() { store.drop(node); }
  } const dropped{store_, above.top};
  std::vector<Node> parts(above.parts.size());
  if (!parts.empty()) unnumbered(at_, 0, parts, 0, parts.size());
  if (parts == above.parts) {
    at_ = above.top;
    return;
  }
  std::unordered_map<Node, Node> made{{0, 0}};
  for (std::size_t i = 0; i < parts.size(); ++i) made.emplace(above.parts[i], parts[i]);
  std::deque<Held> kept;  // the parts are, as this one is
  std::vector<Node> stack{above.top};
  while (!stack.empty()) {
    const Node n = stack.back();
    const auto low = made.find(store_.lo(n)), high = made.find(store_.hi(n));
    if (made.contains(n)) {
      stack.pop_back();
    } else if (low == made.end() || high == made.end()) {
      if (high == made.end()) stack.push_back(store_.hi(n));
      if (low == made.end()) stack.push_back(store_.lo(n));
    } else {
      const Node node = store_.make(store_.level(n), low->second, high->second);
      kept.emplace_back(store_, node);
      made.emplace(n, node);
      stack.pop_back();
    }
  }
  at_ = made.at(above.top);
}

// Some parts in one diagram: the first half of them has a bit unmarked, and the other half has it marked.
Node Narrowed::numbered(const std::vector<Node>& parts, Level bit, std::size_t first, std::size_t last) {
  if (last - first == 1) return parts[first];
  const std::size_t middle = (first + last) / 2;
  const Held low(store_, numbered(parts, bit + 1, first, middle));
  const Held high(store_, numbered(parts, bit + 1, middle, last));
  return store_.make(bit, low, high);
}

// The parts of such a diagram again, each of which may have become empty.
void Narrowed::unnumbered(Node node, Level bit, std::vector<Node>& parts, std::size_t first, std::size_t last) const {
  if (last - first == 1) {
    parts[first] = node;
    return;
  }
  const std::size_t middle = (first + last) / 2;
  const bool is_bit = node != 0 && store_.level(node) == bit;
  unnumbered(is_bit ? store_.lo(node) : node, bit + 1, parts, first, middle);
  unnumbered(is_bit ? store_.hi(node) : Node(0), bit + 1, parts, middle, last);
}

}  // namespace mcpn
