// What a set of markings tells: its heaviest marking, its size, its table, one member.
#include "diagrams/store.hpp"

#include <algorithm>

namespace mcpn {

namespace {

constexpr std::uint64_t kEntry = 64;  // bytes of a small value in a table found by hash, about

struct KeyHash {
  std::size_t operator()(std::uint64_t x) const {
    x *= 0x9E3779B97F4A7C15ull;
    return x ^ x >> 31;
  }
};
template <class T> using Memo = std::unordered_map<std::uint64_t, T, KeyHash>;

}  // namespace

Wide Store::largest(Node a, const std::vector<Wide>& weights) {
  Memo<Wide> memo;
  Scratch scratch(*this);
  auto visit = [&](auto&& self, Node n) -> Wide {
    if (n < 2) return 0;
    if (const auto found = memo.find(n); found != memo.end()) return found->second;
    Wide result = self(self, hi(n)) + weights[level(n)];
    if (lo(n) != 0) result = std::max(result, self(self, lo(n)));
    count_step();
    scratch.take(kEntry);
    return memo[n] = result;
  };
  return visit(visit, a);
}

std::uint64_t Store::size(Node a) {
  std::uint64_t count = 0;
  walk(a, [&](Node) { ++count; });
  return count;
}

std::vector<bool> Store::support(Node a) {
  std::vector<bool> marked(levels);
  walk(a, [&](Node n) { marked[level(n)] = true; });
  return marked;
}

bool Store::possible(std::uint32_t suffix, const std::vector<bool>& support) const {
  for (; suffix && !suffixes_[suffix].more; suffix = suffixes_[suffix].next) {
    const Touch touch = suffixes_[suffix].touch;
    if ((touch == Touch::consume || touch == Touch::read) && !support[suffixes_[suffix].level]) return false;
  }
  return true;
}

std::vector<std::uint32_t> Store::table(Node a) {
  Scratch scratch(*this);
  scratch.take(size(a) * (kEntry + 2 * sizeof(Node) + 6 * sizeof(std::uint32_t)));
  std::vector<Node> nodes;
  walk(a, [&](Node n) { nodes.push_back(n); });
  std::stable_sort(nodes.begin(), nodes.end(), [&](Node x, Node y) { return level(x) > level(y); });
  std::unordered_map<Node, std::uint32_t, KeyHash> number{{0, 0}, {1, 1}};
  std::vector<std::uint32_t> rows;
  for (const Node n : nodes) {
    rows.insert(rows.end(), {level(n), number.at(lo(n)), number.at(hi(n))});
    number.emplace(n, std::uint32_t(number.size()));
  }
  if (nodes.empty()) rows = {levels, a, a};
  return rows;
}

Node Store::from_table(const std::vector<std::uint32_t>& rows) {
  const auto wrong = [](const char* what) { throw std::invalid_argument(std::string("no table of a set: ") + what); };
  if (rows.empty() || rows.size() % 3) wrong("rows are triples");
  if (rows[0] == levels) return rows.size() == 3 && rows[1] < 2 && rows[1] == rows[2] ? rows[1] : (wrong("a terminal"), 0);
  std::vector<Node> nodes{0, 1};
  const auto release = [&] {
    for (std::size_t i = 2; i < nodes.size(); ++i) drop(nodes[i]);
  };
  try {
    for (std::size_t i = 0; i < rows.size(); i += 3) {
      if (rows[i] >= levels) wrong("a level too many");
      if (rows[i + 1] >= nodes.size() || rows[i + 2] >= nodes.size()) wrong("children come first");
      const Node low = nodes[rows[i + 1]], high = nodes[rows[i + 2]];
      if (high == 0 || level(low) <= rows[i] || level(high) <= rows[i]) wrong("levels go down, and marked sides are not empty");
      nodes.push_back(make(rows[i], low, high));
      keep(nodes.back());
    }
  } catch (...) {
    release();
    throw;
  }
  release();
  return nodes.back();
}

bool Store::pick(Node a, std::vector<Level>& marking) {
  if (a == 0) return false;
  while (a != 1) {
    if (lo(a) != 0) {
      a = lo(a);
    } else {
      marking.push_back(level(a));
      a = hi(a);
    }
  }
  return true;
}

}  // namespace mcpn
