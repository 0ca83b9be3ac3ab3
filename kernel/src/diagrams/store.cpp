#include "diagrams/store.hpp"

#include <algorithm>

namespace mcpn {

namespace {

constexpr std::uint64_t kFirstBuckets = 1u << 10, kFirstLines = 1u << 10, kMostLines = 1u << 22;
constexpr std::uint64_t kFirstCollection = 1u << 22;
constexpr std::uint64_t kLook = 1u << 15;  // steps from one look at signals to the next
constexpr Node kNone = 0;

std::uint64_t mix(std::uint64_t a, std::uint64_t b) {
  std::uint64_t x = a * 0x9E3779B97F4A7C15ull ^ (b + 0x7F4A7C159E3779B9ull) * 0xC2B2AE3D27D4EB4Full;
  x ^= x >> 29;
  x *= 0xBF58476D1CE4E5B9ull;
  return x ^ x >> 32;
}

}  // namespace

Store::Store(Level number, std::uint64_t memory_limit) : levels(number), memory_limit_(memory_limit) {
  nodes_ = {{levels, 0, 0, kNone}, {levels, 1, 1, kNone}};
  buckets_.assign(kFirstBuckets, kNone);
  cache_.assign(kFirstLines, {});
  suffixes_.push_back({levels, Touch::read, 0, 0});
  is_condition_.push_back(true);
  collect_at_ = kFirstCollection;
  declare({});
  require(0);
}

std::uint64_t Store::bytes() const {
  return nodes_.capacity() * sizeof(Cell) + buckets_.capacity() * sizeof(Node) + cache_.capacity() * sizeof(Line) +
         (seen_.capacity() + number_.capacity()) * sizeof(std::uint32_t) + program_bytes_ + pending_bytes_ + scratch_;
}

void Store::require(std::uint64_t more) const {
  if (bytes() + more > memory_limit_)
    throw MemoryLimit("the store's memory limit of " + std::to_string(memory_limit_) + " bytes was hit at " +
                      std::to_string(used_) + " nodes");
}

void Store::check() {
  if (cancelled.load(std::memory_order_relaxed)) throw Cancelled();
  if (stop.load(std::memory_order_relaxed) || (asked_to_stop && asked_to_stop())) throw Interrupted();
}

void Store::look_up() {
  if (most_steps_ && steps_ >= most_steps_)
    throw BudgetExceeded("the budget of " + std::to_string(most_steps_) + " steps was exceeded");
  check();
  look_at_ = most_steps_ ? std::min(most_steps_, steps_ + kLook) : steps_ + kLook;
}

Node Store::make(Level level, Node lo, Node hi) {
  if (hi == 0) return lo;
  const std::uint64_t key = mix(std::uint64_t(lo) << 32 | hi, level);
  for (Node n = buckets_[key & (buckets_.size() - 1)]; n != kNone; n = nodes_[n].next)
    if (nodes_[n].lo == lo && nodes_[n].hi == hi && nodes_[n].level == level) return n;
  if (budget_ && made_ >= budget_)
    throw BudgetExceeded("the budget of " + std::to_string(budget_) + " nodes was exceeded");
  ++made_;
  make_room(lo, hi);
  Node fresh;
  if (free_ != kNone) {
    fresh = free_;
    free_ = nodes_[fresh].next;
  } else {
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

// Sees to it that one more node fits: by collecting garbage when there is much of it or when memory runs out.
void Store::make_room(Node lo, Node hi) {
  if (used_ > collect_at_) {
    collect({lo, hi});
    collect_at_ = std::max(kFirstCollection, used_ * 2);
  }
  if (free_ != kNone || nodes_.size() < nodes_.capacity()) return;
  const std::uint64_t wanted = nodes_.capacity() + nodes_.capacity() / 2 + 1024;
  const bool fits = bytes() + wanted * sizeof(Cell) <= memory_limit_;  // both copies live while a vector moves
  if (!fits || wanted >= kAnything) {
    collect({lo, hi});
    if (used_ > nodes_.size() / 3 * 2)  // hardly any garbage: collecting again and again would be no progress
      wanted >= kAnything ? throw MemoryLimit("more nodes than 32 bits can name") : require(wanted * sizeof(Cell));
    if (free_ != kNone) return;
  }
  nodes_.reserve(wanted);
}

void Store::grow_table() {
  // A table that cannot grow is slower, not wrong.
  if (bytes() + buckets_.size() * 2 * sizeof(Node) > memory_limit_) return;
  Table<Node> wider(buckets_.size() * 2, kNone);
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
  const std::uint64_t wanted = std::min(kMostLines, std::uint64_t(cache_.size() * 2));
  if (wanted <= cache_.size() || bytes() + wanted * sizeof(Line) > memory_limit_) return;
  Table<Line> narrower(wanted);
  cache_.swap(narrower);
  for (const Line& line : narrower)
    for (std::size_t way = std::size(line.ways); way-- > 0;)  // the newest last
      if (const Cached& entry = line.ways[way]; entry.tag) remember(entry.tag, entry.x, entry.y, entry.z, entry.result);
  overwritten_ = 0;
}

Store::Line& Store::line(std::uint32_t tag, std::uint32_t x, Node y, Node z) {
  return cache_[mix(std::uint64_t(tag) << 32 | x, std::uint64_t(y) << 32 | z) & (cache_.size() - 1)];
}

bool Store::recall(std::uint32_t tag, std::uint32_t x, Node y, Node z, Node& result) {
  for (const Cached& entry : line(tag, x, y, z).ways)
    if (entry.tag == tag && entry.x == x && entry.y == y && entry.z == z) {
      result = entry.result;
      return true;
    }
  count_step();
  return false;
}

void Store::remember(std::uint32_t tag, std::uint32_t x, Node y, Node z, Node result) {
  Cached* ways = line(tag, x, y, z).ways;
  if (ways[2].tag && ++overwritten_ > cache_.size() * 3) {
    grow_cache();
    ways = line(tag, x, y, z).ways;
  }
  ways[2] = ways[1];
  ways[1] = ways[0];
  ways[0] = {tag, x, y, z, result};
}

void Store::begin(std::uint64_t most_nodes, std::uint64_t most_steps) {
  stop.store(false);
  held_.clear();
  peak_ = used_;
  made_ = 0;
  budget_ = most_nodes;
  steps_ = 0;
  most_steps_ = most_steps;
  look_at_ = most_steps ? std::min(most_steps, kLook) : kLook;
  if (cancelled.load()) throw Cancelled();
}

void Store::collect(std::initializer_list<Node> also) {
  std::vector<bool> marked(nodes_.size());
  marked[0] = marked[1] = true;
  std::vector<Node> stack(held_);
  stack.insert(stack.end(), also);
  {
    const std::lock_guard lock(kept_mutex_);
    for (const auto& [node, count] : kept_) stack.push_back(node);
  }
  while (!stack.empty()) {
    const Node n = stack.back();
    stack.pop_back();
    if (marked[n]) continue;
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
  const auto lives = [&](Node n) { return n == kAnything || marked[n]; };
  for (Line& line : cache_)
    for (Cached& entry : line.ways)
      if (entry.tag && !(lives(entry.y) && lives(entry.z) && lives(entry.result))) entry = {};
  ++collections_;
}

Node Store::join(Node a, Node b) {
  if (a == b || b == 0) return a;
  if (a == 0) return b;
  if (a > b) std::swap(a, b);
  Node result;
  if (recall(tag(op_join), 0, a, b, result)) return result;
  const Level at = std::min(level(a), level(b));
  const Branches x = split(a, at), y = split(b, at);
  const Held low(*this, join(x.lo, y.lo));
  result = make(at, low, join(x.hi, y.hi));
  remember(tag(op_join), 0, a, b, result);
  return result;
}

Node Store::meet(Node a, Node b) {
  if (a == b) return a;
  if (a == 0 || b == 0) return 0;
  if (a > b) std::swap(a, b);
  Node result;
  if (recall(tag(op_meet), 0, a, b, result)) return result;
  const Level at = std::min(level(a), level(b));
  if (at == levels) return 0;  // two different terminals: one is empty
  const Branches x = split(a, at), y = split(b, at);
  const Held low(*this, meet(x.lo, y.lo));
  result = make(at, low, meet(x.hi, y.hi));
  remember(tag(op_meet), 0, a, b, result);
  return result;
}

Node Store::minus(Node a, Node b) {
  if (a == 0 || a == b) return 0;
  if (b == 0) return a;
  Node result;
  if (recall(tag(op_minus), 0, a, b, result)) return result;
  const Level at = std::min(level(a), level(b));
  const Branches x = split(a, at), y = split(b, at);
  const Held low(*this, minus(x.lo, y.lo));
  result = make(at, low, minus(x.hi, y.hi));
  remember(tag(op_minus), 0, a, b, result);
  return result;
}

Node Store::filter(Node a, std::uint32_t literals) {
  if (a == 0 || literals == 0) return a;
  const Suffix wanted = suffixes_[literals];
  Node result;
  if (level(a) > wanted.level) {  // skipped, so unmarked
    for (; literals; literals = suffixes_[literals].more)
      if (suffixes_[literals].touch == Touch::zero) return filter(a, suffixes_[literals].next);
    return 0;
  }
  if (recall(tag(op_filter), literals, a, 0, result)) return result;
  if (level(a) < wanted.level) {
    const Held low(*this, filter(lo(a), literals));
    result = make(level(a), low, filter(hi(a), literals));
  } else if (wanted.more) {  // first marked, then unmarked: that is their order
    const Held high(*this, filter(hi(a), wanted.next));
    const Held low(*this, filter(lo(a), suffixes_[wanted.more].next));
    result = make(level(a), low, high);
  } else if (wanted.touch == Touch::zero) {
    result = filter(lo(a), wanted.next);
  } else {
    result = make(level(a), 0, filter(hi(a), wanted.next));
  }
  remember(tag(op_filter), literals, a, 0, result);
  return result;
}

Node Store::onto(Node a, std::uint32_t kept) {
  if (a < 2) return a;
  while (kept && suffixes_[kept].level < level(a)) kept = suffixes_[kept].next;
  if (kept == 0) return 1;  // some marking is there, and nothing more is asked of it
  Node result;
  if (recall(tag(op_onto), kept, a, 0, result)) return result;
  const Held low(*this, onto(lo(a), kept));
  const Held high(*this, onto(hi(a), kept));
  result = level(a) == suffixes_[kept].level ? make(level(a), low, high) : join(low, high);
  remember(tag(op_onto), kept, a, 0, result);
  return result;
}

Node Store::image(Node a, std::uint32_t event, Node within) {
  if (a == 0 || within == 0) return 0;
  if (event == 0) return within == kAnything ? a : meet(a, within);
  const Suffix head = suffixes_[event];
  const Level at = std::min(level(a), head.level);
  within = below(within, at);
  Node result;
  if (recall(tag(op_image), event, a, within, result)) return result;
  const Branches x = split(a, at), w = limits(within, at);
  if (at < head.level) {
    const Held low(*this, image(x.lo, event, w.lo));
    result = make(at, low, image(x.hi, event, w.hi));
  } else if (head.more) {
    Held low(*this, 0), high(*this, 0);
    for (std::uint32_t each = event; each; each = suffixes_[each].more) {
      const Suffix way = suffixes_[each];
      const bool from_high = way.touch == Touch::consume || way.touch == Touch::read;
      const bool into_high = way.touch == Touch::produce || way.touch == Touch::read;
      const Held made(*this, image(from_high ? x.hi : x.lo, way.next, into_high ? w.hi : w.lo));
      Held& target = into_high ? high : low;
      target = join(target, made);
    }
    result = make(at, low, high);
  } else {
    switch (head.touch) {
      case Touch::consume: result = image(x.hi, head.next, w.lo); break;
      case Touch::produce: result = make(at, 0, image(x.lo, head.next, w.hi)); break;
      case Touch::read: result = make(at, 0, image(x.hi, head.next, w.hi)); break;
      default: result = image(x.lo, head.next, w.lo);
    }
  }
  remember(tag(op_image), event, a, within, result);
  return result;
}

void Store::begin_walk() {
  if (seen_.size() < nodes_.size()) {  // as many as nodes have room for: it grows as seldom as they do
    require((nodes_.capacity() + seen_.capacity()) * sizeof(seen_[0]));
    seen_.reserve(nodes_.capacity());
    seen_.resize(nodes_.capacity(), walk_);
  }
  if (++walk_ == 0) {  // numbers of walks begin anew
    std::fill(seen_.begin(), seen_.end(), 0);
    walk_ = 1;
  }
}

bool Store::meets(Node a, std::uint32_t literals) {
  begin_walk();
  return meets_from(a, literals);
}

// A node asks for the literals from its level on, however the walk comes to it: so once is enough.
bool Store::meets_from(Node a, std::uint32_t literals) {
  if (a == 0) return false;
  for (; literals && level(a) > suffixes_[literals].level; literals = suffixes_[literals].next)  // skipped, so unmarked
    if (suffixes_[literals].touch != Touch::zero) return false;
  if (literals == 0) return true;
  if (!visit(a)) return false;
  const Suffix wanted = suffixes_[literals];
  if (level(a) == wanted.level) return meets_from(wanted.touch == Touch::zero ? lo(a) : hi(a), wanted.next);
  return meets_from(hi(a), literals) || meets_from(lo(a), literals);
}

Node Store::singleton(const std::vector<Level>& marked) {
  Node result = 1;
  for (auto at = marked.rbegin(); at != marked.rend(); ++at) result = make(*at, 0, result);
  return result;
}

std::uint32_t Store::suffix(Level level, Touch touch, std::uint32_t next, std::uint32_t more) {
  const std::uint64_t key = std::uint64_t(next) << 32 | std::uint64_t(level) << 2 | std::uint64_t(touch);
  const auto number = std::uint32_t(suffixes_.size());
  const auto known = more ? choice_index_.try_emplace({key, more}, number).first->second
                          : suffix_index_.try_emplace(key, number).first->second;
  if (known == number) {
    suffixes_.push_back({level, touch, next, more});
    const bool looks = touch == Touch::read || touch == Touch::zero;
    is_condition_.push_back(looks && is_condition_[next] && is_condition_[more]);
  }
  return known;
}

}  // namespace mcpn
