// The markings of a set whose weighted tokens add up to something between two bounds.
#include "diagrams/store.hpp"

#include <algorithm>
#include <map>

namespace mcpn {

namespace {

constexpr std::uint64_t kEntry = 160;  // bytes of what is remembered of a node and a sum, and of what is kept, about

}  // namespace

Node Store::weighing(Node a, const std::vector<Wide>& weights, Wide least, Wide most) {
  // What the levels from each one on can add at least and at most.
  std::vector<Wide> lowest(levels + 1, 0), highest(levels + 1, 0);
  for (Level at = levels; at-- > 0;) {
    lowest[at] = lowest[at + 1] + std::min<Wide>(0, weights[at]);
    highest[at] = highest[at + 1] + std::max<Wide>(0, weights[at]);
  }
  std::map<std::pair<Node, Wide>, Node> memo;
  std::vector<Node> made;  // what the memo names must outlive any collection of garbage
  Scratch scratch(*this);
  auto visit = [&](auto&& self, Node n, Wide so_far) -> Node {
    const Level at = level(n);
    if (n == 0 || so_far + lowest[at] > most || so_far + highest[at] < least) return 0;
    if (so_far + lowest[at] >= least && so_far + highest[at] <= most) return n;
    const std::pair key(n, so_far);
    if (const auto found = memo.find(key); found != memo.end()) return found->second;
    count_step();
    scratch.take(kEntry);
    const Held low(*this, self(self, lo(n), so_far));
    const Node result = make(at, low, self(self, hi(n), so_far + weights[at]));
    keep(result);
    made.push_back(result);
    return memo[key] = result;
  };
  const auto release = [&] {
    for (const Node n : made) drop(n);
  };
  try {
    const Node result = visit(visit, a, 0);
    release();
    return result;
  } catch (...) {
    release();
    throw;
  }
}

}  // namespace mcpn
