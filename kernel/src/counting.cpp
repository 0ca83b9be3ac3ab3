// Exact numbers about a set of markings, as limbs.
#include "store.hpp"

#include <algorithm>

namespace mcpn {

namespace {

using Limbs = std::vector<std::uint64_t>;

constexpr std::uint64_t kEntry = 64;  // bytes of a small value in a table found by hash, about

Limbs sum(const Limbs& a, const Limbs& b) {
  const Limbs& longer = a.size() < b.size() ? b : a;
  const Limbs& shorter = a.size() < b.size() ? a : b;
  Limbs result = longer;
  unsigned __int128 carry = 0;
  for (std::size_t i = 0; i < result.size() && (i < shorter.size() || carry); ++i) {
    carry += result[i];
    if (i < shorter.size()) carry += shorter[i];
    result[i] = std::uint64_t(carry);
    carry >>= 64;
  }
  if (carry) result.push_back(std::uint64_t(carry));
  return result;
}

Limbs product(const Limbs& a, const Limbs& b) {
  if (a.empty() || b.empty()) return {};
  Limbs result(a.size() + b.size(), 0);
  for (std::size_t i = 0; i < a.size(); ++i) {
    unsigned __int128 carry = 0;
    for (std::size_t j = 0; j < b.size() || carry; ++j) {
      carry += result[i + j];
      if (j < b.size()) carry += (unsigned __int128)a[i] * b[j];
      result[i + j] = std::uint64_t(carry);
      carry >>= 64;
    }
  }
  while (!result.empty() && result.back() == 0) result.pop_back();
  return result;
}

struct KeyHash {
  std::size_t operator()(std::uint64_t x) const {
    x *= 0x9E3779B97F4A7C15ull;
    return x ^ x >> 31;
  }
};
template <class T> using Memo = std::unordered_map<std::uint64_t, T, KeyHash>;

}  // namespace

// Calls a function on each node of a diagram, terminals aside, once.
template <class F> void Store::walk(Node a, F body) {
  if (seen_.size() < nodes_.size()) {
    if (seen_.capacity() < nodes_.size()) require((nodes_.size() + seen_.capacity()) * sizeof(seen_[0]));
    seen_.reserve(nodes_.size());
    seen_.resize(nodes_.size(), walk_);
  }
  if (++walk_ == 0) {  // numbers of walks begin anew
    std::fill(seen_.begin(), seen_.end(), 0);
    walk_ = 1;
  }
  std::vector<Node> stack{a};
  while (!stack.empty()) {
    const Node n = stack.back();
    stack.pop_back();
    if (n < 2 || seen_[n] == walk_) continue;
    seen_[n] = walk_;
    body(n);
    stack.push_back(lo(n));
    stack.push_back(hi(n));
  }
}

std::vector<std::vector<Node>> Store::nodes_by_level(Node a, Scratch& scratch) {
  std::uint64_t nodes = 0;
  walk(a, [&](Node) { ++nodes; });
  scratch.take(levels * sizeof(std::vector<Node>) + 2 * nodes * sizeof(Node));
  std::vector<std::vector<Node>> found(levels);
  walk(a, [&](Node n) { found[level(n)].push_back(n); });
  return found;
}

std::vector<std::vector<std::uint64_t>> Store::counts(Node a, const std::vector<std::uint32_t>& conditions) {
  Memo<Limbs> memo;  // shared: conditions have their ends in common, and every count ends in plain ones
  Scratch scratch(*this);
  auto visit = [&](auto&& self, Node n, std::uint32_t wanted) -> Limbs {
    while (wanted && suffixes_[wanted].level < level(n)) {
      if (suffixes_[wanted].more) wanted = suffixes_[wanted].more;  // the way of an unmarked level stands last
      if (suffixes_[wanted].touch != Touch::zero) return {};
      wanted = suffixes_[wanted].next;
    }
    if (n == 0) return {};
    if (n == 1) return {1};
    const std::uint64_t key = std::uint64_t(n) << 32 | wanted;
    if (const auto found = memo.find(key); found != memo.end()) return found->second;
    Limbs result;
    if (wanted && suffixes_[wanted].level == level(n)) {
      const Suffix literal = suffixes_[wanted];
      result = self(self, literal.touch == Touch::zero ? lo(n) : hi(n), literal.next);
      if (literal.more) result = sum(result, self(self, lo(n), suffixes_[literal.more].next));
    } else {
      result = sum(self(self, lo(n), wanted), self(self, hi(n), wanted));
    }
    count_step();
    scratch.take(kEntry + result.capacity() * sizeof(result[0]));
    return memo[key] = std::move(result);
  };
  // A condition that begins with a marked level is counted from that level's nodes on, each as often as paths
  // lead to it: nodes above are passed once for all conditions, not once for each.
  std::vector<std::vector<Node>> by_level = nodes_by_level(a, scratch);
  std::unordered_map<Node, Limbs, KeyHash> paths;
  paths[a] = {1};
  if (conditions.size() > 1)
    for (const auto& nodes : by_level)
      for (const Node n : nodes)
        for (const Node child : {lo(n), hi(n)})
          if (child > 1) {
            count_step();
            Limbs& known = paths[child];
            const std::uint64_t before = known.empty() ? 0 : kEntry + known.capacity() * sizeof(known[0]);
            known = sum(known, paths[n]);
            const std::uint64_t after = kEntry + known.capacity() * sizeof(known[0]);
            if (after > before) scratch.take(after - before);
          }
  const std::vector<bool> marked = support(a);
  std::vector<Limbs> results;
  for (const std::uint32_t condition : conditions) {
    Limbs total;
    if (possible(condition, marked)) {
      const Suffix top = suffixes_[condition];
      if (conditions.size() > 1 && condition && top.touch == Touch::read && !top.more)
        for (const Node n : by_level[suffixes_[condition].level])
          total = sum(total, product(paths[n], visit(visit, hi(n), suffixes_[condition].next)));
      else
        total = visit(visit, a, condition);
    }
    results.push_back(std::move(total));
  }
  return results;
}

std::int64_t Store::first(Node a, const std::vector<std::uint32_t>& conditions) {
  Memo<bool> memo;  // shared: conditions have their ends in common
  Scratch scratch(*this);
  auto visit = [&](auto&& self, Node n, std::uint32_t wanted) -> bool {
    if (n == 0) return false;
    if (wanted == 0) return true;
    const Suffix literal = suffixes_[wanted];
    if (level(n) > literal.level) {
      const Suffix last = literal.more ? suffixes_[literal.more] : literal;
      return last.touch == Touch::zero && self(self, n, last.next);
    }
    const std::uint64_t key = std::uint64_t(n) << 32 | wanted;
    if (const auto found = memo.find(key); found != memo.end()) return found->second;
    bool result;
    if (literal.level == level(n))
      result = self(self, literal.touch == Touch::zero ? lo(n) : hi(n), literal.next) ||
               (literal.more && self(self, lo(n), suffixes_[literal.more].next));
    else
      result = self(self, hi(n), wanted) || self(self, lo(n), wanted);
    count_step();
    scratch.take(kEntry);
    return memo[key] = result;
  };
  // As for counts: some path leads to every node, so a condition can be asked from its first level on.
  const std::vector<std::vector<Node>> by_level = nodes_by_level(a, scratch);
  auto holds = [&](std::uint32_t condition) {
    const Suffix head = suffixes_[condition];
    if (condition == 0 || head.touch == Touch::zero || head.more) return visit(visit, a, condition);
    for (std::uint32_t rest = condition; rest && !suffixes_[rest].more; rest = suffixes_[rest].next)
      if (suffixes_[rest].touch != Touch::zero && by_level[suffixes_[rest].level].empty()) return false;
    const std::vector<Node>& tops = by_level[suffixes_[condition].level];
    return std::any_of(tops.begin(), tops.end(), [&](Node n) { return visit(visit, hi(n), suffixes_[condition].next); });
  };
  const auto found = std::find_if(conditions.begin(), conditions.end(), holds);
  return found == conditions.end() ? -1 : found - conditions.begin();
}

std::int64_t Store::largest(Node a, const std::vector<std::int32_t>& weights) {
  Memo<std::int64_t> memo;
  Scratch scratch(*this);
  auto visit = [&](auto&& self, Node n) -> std::int64_t {
    if (n < 2) return 0;
    if (const auto found = memo.find(n); found != memo.end()) return found->second;
    std::int64_t result = self(self, hi(n)) + weights[level(n)];
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
