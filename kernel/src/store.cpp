#include "store.hpp"

#include <algorithm>

namespace mcpn {

namespace {

constexpr std::uint64_t kFirstBuckets = 1u << 14, kFirstCache = 1u << 16, kMostCache = 1u << 23;
constexpr std::uint64_t kFirstCollection = 1u << 20;
constexpr Node kNone = 0;

std::uint64_t mix(std::uint64_t a, std::uint64_t b) {
  std::uint64_t x = a * 0x9E3779B97F4A7C15ull ^ (b + 0x7F4A7C159E3779B9ull) * 0xC2B2AE3D27D4EB4Full;
  x ^= x >> 29;
  x *= 0xBF58476D1CE4E5B9ull;
  return x ^ x >> 32;
}

}  // namespace

Store::Store(Level levels, std::uint64_t memory_limit) : levels(levels), memory_limit_(memory_limit) {
  nodes_ = {{levels, 0, 0, kNone}, {levels, 1, 1, kNone}};
  buckets_.assign(kFirstBuckets, kNone);
  cache_.assign(kFirstCache, {});
  suffixes_.push_back({levels, Touch::read, 0});
  collect_at_ = kFirstCollection;
  declare({});
}

std::uint64_t Store::bytes() const {
  return nodes_.capacity() * sizeof(Cell) + buckets_.capacity() * sizeof(Node) + cache_.capacity() * sizeof(Cached);
}

void Store::require(std::uint64_t more) {
  if (bytes() + more > memory_limit_)
    throw MemoryLimit("the store's memory limit of " + std::to_string(memory_limit_) + " bytes was hit at " +
                      std::to_string(used_) + " nodes");
}

void Store::check() {
  if (stop.load(std::memory_order_relaxed) || (asked_to_stop && asked_to_stop())) throw Interrupted();
}

Node Store::make(Level level, Node lo, Node hi) {
  if (hi == 0) return lo;
  const std::uint64_t key = mix(std::uint64_t(lo) << 32 | hi, level);
  for (Node n = buckets_[key & (buckets_.size() - 1)]; n != kNone; n = nodes_[n].next)
    if (nodes_[n].lo == lo && nodes_[n].hi == hi && nodes_[n].level == level) return n;
  if ((++steps_ & 0xFFFF) == 0) check();
  if (budget_ && used_ >= budget_end_)
    throw BudgetExceeded("the budget of " + std::to_string(budget_) + " nodes was exceeded");
  Node fresh;
  if (free_ != kNone) {
    fresh = free_;
    free_ = nodes_[fresh].next;
  } else {
    if (nodes_.size() >= 0xFFFFFFF0u) throw MemoryLimit("more nodes than 32 bits can name");
    if (nodes_.size() == nodes_.capacity()) {
      require(nodes_.capacity() * sizeof(Cell) * 3 / 2);  // both copies live while a vector moves
      nodes_.reserve(nodes_.capacity() + nodes_.capacity() / 2 + 1024);
    }
    fresh = Node(nodes_.size());
    nodes_.push_back({});
  }
  if (++used_ > buckets_.size()) grow_table();
  Node& bucket = buckets_[key & (buckets_.size() - 1)];
  nodes_[fresh] = {level, lo, hi, bucket};
  bucket = fresh;
  peak_ = std::max(peak_, used_);
  return fresh;
}

void Store::grow_table() {
  require(buckets_.size() * 2 * sizeof(Node));
  std::vector<Node> wider(buckets_.size() * 2, kNone);
  for (Node bucket : buckets_)
    for (Node n = bucket; n != kNone;) {
      const Node next = nodes_[n].next;
      Node& slot = wider[mix(std::uint64_t(nodes_[n].lo) << 32 | nodes_[n].hi, nodes_[n].level) & (wider.size() - 1)];
      nodes_[n].next = slot;
      slot = n;
      n = next;
    }
  buckets_.swap(wider);
}

void Store::grow_cache() {
  overwritten_ = 0;
  const std::uint64_t wanted = std::min(kMostCache, cache_.size() * 2);
  if (wanted <= cache_.size() || bytes() + wanted * sizeof(Cached) > memory_limit_) return;
  std::vector<Cached> wider(wanted);
  for (const Cached& entry : cache_)
    if (entry.a != ~0ull) wider[mix(entry.a, entry.b) & (wanted - 1)] = entry;
  cache_.swap(wider);
}

bool Store::recall(Op op, std::uint32_t x, std::uint32_t y, std::uint32_t z, Node& result) {
  const std::uint64_t a = std::uint64_t(op) << 32 | x, b = std::uint64_t(y) << 32 | z;
  const Cached& entry = cache_[mix(a, b) & (cache_.size() - 1)];
  if (entry.a != a || entry.b != b) return false;
  result = entry.result;
  return true;
}

void Store::remember(Op op, std::uint32_t x, std::uint32_t y, std::uint32_t z, Node result) {
  const std::uint64_t a = std::uint64_t(op) << 32 | x, b = std::uint64_t(y) << 32 | z;
  Cached& entry = cache_[mix(a, b) & (cache_.size() - 1)];
  if (entry.a != ~0ull && ++overwritten_ > cache_.size()) {
    grow_cache();
    return remember(op, x, y, z, result);
  }
  entry = {a, b, result};
}

// Garbage is collected between operations only: within one, every node made may still be needed.
void Store::begin(std::uint64_t budget) {
  stop.store(false);
  if (used_ > collect_at_) {
    collect();
    collect_at_ = std::max(kFirstCollection, used_ * 2);
  }
  peak_ = used_;
  budget_ = budget;
  budget_end_ = used_ + budget;
}

void Store::collect() {
  std::vector<bool> marked(nodes_.size());
  std::vector<Node> stack;
  for (const auto& [node, count] : kept_) stack.push_back(node);
  while (!stack.empty()) {
    const Node n = stack.back();
    stack.pop_back();
    if (n < 2 || marked[n]) continue;
    marked[n] = true;
    stack.push_back(nodes_[n].lo);
    stack.push_back(nodes_[n].hi);
  }
  std::fill(buckets_.begin(), buckets_.end(), kNone);
  free_ = kNone;
  used_ = 0;
  for (Node n = Node(nodes_.size()); n-- > 2;) {
    if (marked[n]) {
      Node& bucket =
          buckets_[mix(std::uint64_t(nodes_[n].lo) << 32 | nodes_[n].hi, nodes_[n].level) & (buckets_.size() - 1)];
      nodes_[n].next = bucket;
      bucket = n;
      ++used_;
    } else {
      nodes_[n] = {levels, 0, 0, free_};
      free_ = n;
    }
  }
  std::fill(cache_.begin(), cache_.end(), Cached{});
  ++collections_;
}

Node Store::join(Node a, Node b) {
  if (a == b || b == 0) return a;
  if (a == 0) return b;
  if (a > b) std::swap(a, b);
  Node result;
  if (recall(op_join, 0, a, b, result)) return result;
  const Level at = std::min(level(a), level(b));
  const Branches x = split(a, at), y = split(b, at);
  const Node low = join(x.lo, y.lo);
  result = make(at, low, join(x.hi, y.hi));
  remember(op_join, 0, a, b, result);
  return result;
}

Node Store::meet(Node a, Node b) {
  if (a == b) return a;
  if (a == 0 || b == 0) return 0;
  if (a > b) std::swap(a, b);
  Node result;
  if (recall(op_meet, 0, a, b, result)) return result;
  const Level at = std::min(level(a), level(b));
  if (at == levels) return 0;  // two different terminals: one is empty
  const Branches x = split(a, at), y = split(b, at);
  const Node low = meet(x.lo, y.lo);
  result = make(at, low, meet(x.hi, y.hi));
  remember(op_meet, 0, a, b, result);
  return result;
}

Node Store::minus(Node a, Node b) {
  if (a == 0 || a == b) return 0;
  if (b == 0) return a;
  Node result;
  if (recall(op_minus, 0, a, b, result)) return result;
  const Level at = std::min(level(a), level(b));
  const Branches x = split(a, at), y = split(b, at);
  const Node low = minus(x.lo, y.lo);
  result = make(at, low, minus(x.hi, y.hi));
  remember(op_minus, 0, a, b, result);
  return result;
}

Node Store::filter(Node a, std::uint32_t literals) {
  if (a == 0 || literals == 0) return a;
  const Suffix wanted = suffixes_[literals];
  Node result;
  if (level(a) > wanted.level)  // skipped, so unmarked
    return wanted.touch == Touch::zero ? filter(a, wanted.next) : 0;
  if (recall(op_filter, literals, a, 0, result)) return result;
  if (level(a) < wanted.level) {
    const Node low = filter(lo(a), literals);
    result = make(level(a), low, filter(hi(a), literals));
  } else if (wanted.touch == Touch::zero) {
    result = filter(lo(a), wanted.next);
  } else {
    result = make(level(a), 0, filter(hi(a), wanted.next));
  }
  remember(op_filter, literals, a, 0, result);
  return result;
}

Node Store::image(Node a, std::uint32_t event) {
  if (a == 0 || event == 0) return a;
  const Suffix head = suffixes_[event];
  const Level at = std::min(level(a), head.level);
  Node result;
  if (recall(op_image, event, a, 0, result)) return result;
  const Branches x = split(a, at);
  if (at < head.level) {
    const Node low = image(x.lo, event);
    result = make(at, low, image(x.hi, event));
  } else {
    switch (head.touch) {
      case Touch::consume: result = image(x.hi, head.next); break;
      case Touch::produce: result = make(at, 0, image(x.lo, head.next)); break;
      case Touch::read: result = make(at, 0, image(x.hi, head.next)); break;
      default: result = image(x.lo, head.next);
    }
  }
  remember(op_image, event, a, 0, result);
  return result;
}

Node Store::singleton(const std::vector<Level>& marked) {
  Node result = 1;
  for (auto at = marked.rbegin(); at != marked.rend(); ++at) result = make(*at, 0, result);
  return result;
}

std::uint32_t Store::suffix(Level level, Touch touch, std::uint32_t next) {
  const std::uint64_t key = std::uint64_t(next) << 32 | std::uint64_t(level) << 2 | std::uint64_t(touch);
  const auto [found, added] = suffix_index_.try_emplace(key, std::uint32_t(suffixes_.size()));
  if (added) suffixes_.push_back({level, touch, next});
  return found->second;
}

}  // namespace mcpn
