// Families of sets of levels, as decision diagrams with their zeros suppressed.
#pragma once

#include "certificate.hpp"

#include <optional>

using Node = std::uint32_t;  // 0 is the empty family, 1 holds the empty set alone

// What becomes of one level: which sets pass, and how they leave.
struct Change {
  enum Leaves { as_it_came, out, in, either };
  std::uint32_t level;
  int needed;  // 0: sets without it, 1: sets with it, -1: all
  Leaves leaves;
};
using Changes = std::vector<Change>;  // in the order of levels

class Families {
 public:
  Families(std::size_t most, const Clock& clock) : most_(most), clock_(clock) { rows_.resize(2, {kNone, 0, 0}); }

  Node node(std::uint32_t level, Node low, Node high) {
    if (!high) return low;
    const auto [found, fresh] = numbers_.emplace(Key{level, low, high}, Node(rows_.size()));
    if (fresh) {
      if (rows_.size() >= most_) throw Limit("more than " + std::to_string(most_) + " nodes");
      if (rows_.size() % 1024 == 0) clock_.look(0);
      rows_.push_back({level, low, high});
    }
    return found->second;
  }
  Node both(Node a, Node b) { return combined(kBoth, a, b); }
  Node any(Node a, Node b) { return combined(kAny, a, b); }
  Node less(Node a, Node b) { return combined(kLess, a, b); }
  bool within(Node a, Node b) { return less(a, b) == 0; }
  Node changed(Node of, const Changes& changes) {
    std::map<std::pair<Node, std::size_t>, Node> known;
    return changed(of, changes, 0, known);
  }
  // Those of a set without, or with a level, which is dropped.
  Node part(Node of, std::uint32_t level, bool with) { return changed(of, {{level, with ? 1 : 0, Change::out}}); }
  // Of pairs the first ones, with levels halved.
  Node firsts(Node pairs) {
    std::map<Node, Node> known;
    return firsts(pairs, known);
  }
  // Whether all pairs are of equals.
  bool equals(Node pairs) {
    std::map<Node, bool> known;
    return equals(pairs, known);
  }

 private:
  struct Row { std::uint32_t level; Node low, high; };
  using Key = std::array<std::uint32_t, 3>;
  struct Hash {
    std::size_t operator()(const Key& key) const {
      std::uint64_t hash = 0;
      for (const std::uint32_t part : key) hash = (hash ^ part) * 0x9E3779B97F4A7C15u, hash ^= hash >> 29;
      return std::size_t(hash);
    }
  };
  static constexpr std::uint32_t kNone = ~0u;
  enum Operation : std::uint32_t { kBoth, kAny, kLess };

  Node combined(Operation how, Node a, Node b) {
    if (!a) return how == kAny ? b : 0;
    if (!b) return how == kBoth ? 0 : a;
    if (a == b) return how == kLess ? 0 : a;
    const Key key{how, a, b};
    if (const auto found = combined_.find(key); found != combined_.end()) return found->second;
    if (combined_.size() % 4096 == 0) clock_.look(0);
    const Row one = rows_[a], other = rows_[b];
    Node made;
    if (one.level < other.level) {
      const Node low = combined(how, one.low, b);
      made = how == kBoth ? low : node(one.level, low, one.high);
    } else if (one.level > other.level) {
      const Node low = combined(how, a, other.low);
      made = how == kAny ? node(other.level, low, other.high) : low;
    } else {
      const Node low = combined(how, one.low, other.low), high = combined(how, one.high, other.high);
      made = node(one.level, low, high);
    }
    combined_.emplace(key, made);
    return made;
  }
  Node changed(Node of, const Changes& changes, std::size_t at, std::map<std::pair<Node, std::size_t>, Node>& known) {
    if (!of || at == changes.size()) return of;
    const auto key = std::make_pair(of, at);
    if (const auto found = known.find(key); found != known.end()) return found->second;
    const Row row = rows_[of];
    const Change& change = changes[at];
    Node made;
    if (row.level < change.level) {
      const Node low = changed(row.low, changes, at, known), high = changed(row.high, changes, at, known);
      made = node(row.level, low, high);
    } else {
      const bool here = row.level == change.level;
      const Node low = change.needed == 1 ? 0 : changed(here ? row.low : of, changes, at + 1, known);
      const Node high = change.needed == 0 || !here ? 0 : changed(row.high, changes, at + 1, known);
      switch (change.leaves) {
        case Change::as_it_came: made = node(change.level, low, high); break;
        case Change::out: made = any(low, high); break;
        case Change::in: made = node(change.level, 0, any(low, high)); break;
        default: { const Node all = any(low, high); made = node(change.level, all, all); }
      }
    }
    known.emplace(key, made);
    return made;
  }
  Node firsts(Node of, std::map<Node, Node>& known) {
    if (of < 2) return of;
    if (const auto found = known.find(of); found != known.end()) return found->second;
    const Row row = rows_[of];
    const Node low = firsts(row.low, known), high = firsts(row.high, known);
    const Node made = row.level % 2 ? any(low, high) : node(row.level / 2, low, high);
    known.emplace(of, made);
    return made;
  }
  bool equals(Node of, std::map<Node, bool>& known) {
    if (of < 2) return true;
    if (const auto found = known.find(of); found != known.end()) return found->second;
    const Row row = rows_[of], second = rows_[row.high];
    const bool made = row.level % 2 == 0 && second.level == row.level + 1 && second.low == 0 && equals(row.low, known) && equals(second.high, known);
    known.emplace(of, made);
    return made;
  }

  std::size_t most_;
  const Clock& clock_;
  std::vector<Row> rows_;
  std::unordered_map<Key, Node, Hash> numbers_, combined_;
};
