// Sets of markings and their store as Python holds them.
#pragma once

#include <nanobind/nanobind.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "diagrams/store.hpp"
#include "python/operation.hpp"

namespace mcpn {

inline constexpr const char* kBusy = "the store is at work for another thread";
inline constexpr Level kMostLevels = 1u << 20;

using Ids = std::vector<std::uint64_t>;

// Numbers that Python holds as bytes. Nothing is copied from no bytes, which have no address.
inline std::vector<std::uint32_t> numbers_of(const nanobind::bytes& data, const char* otherwise) {
  if (data.size() % sizeof(std::uint32_t)) throw std::invalid_argument(otherwise);
  std::vector<std::uint32_t> found(data.size() / sizeof(std::uint32_t));
  if (!found.empty()) std::memcpy(found.data(), data.c_str(), data.size());
  return found;
}

// What Python calls an event or a condition: the store's number above, a suffix below.
inline std::atomic<std::uint32_t> stores_made{0};

class PyStore : public std::enable_shared_from_this<PyStore> {
 public:
  PyStore(std::uint64_t levels, std::uint64_t memory_limit) : store(checked(levels), memory_limit) {}
  Store store;
  Progress progress;

  // One operation at a time: the GIL is free meanwhile, so that another thread could ask for one.
  void run(std::function<void()> body) {
    if (busy_.exchange(true)) throw std::runtime_error(kBusy);
    const struct Done {
      std::atomic<bool>& busy;
      ~Done() { busy.store(false); }
    } done{busy_};
    run_operation(store, std::move(body), progress);
  }

  Store& at_rest() {
    if (busy_) throw std::runtime_error(kBusy);
    return store;
  }

  static Level checked(std::uint64_t levels) {
    if (levels > kMostLevels) throw std::invalid_argument("a store has at most 2^20 levels");
    return Level(levels);
  }
  void check_bits(const std::vector<std::int64_t>& bits, std::size_t words) const {
    if (bits.size() != store.levels) throw std::invalid_argument("one bit for each level");
    for (const std::int64_t bit : bits)
      if (bit < -1 || (bit >= 0 && std::size_t(bit) >= words * 64)) throw std::invalid_argument("no such bit");
  }
  std::vector<Level> sorted(std::vector<std::int64_t> levels) const {
    std::sort(levels.begin(), levels.end());
    for (std::size_t i = 0; i < levels.size(); ++i) {
      if (levels[i] < 0 || levels[i] >= std::int64_t(store.levels)) throw std::invalid_argument("no such level");
      if (i && levels[i] == levels[i - 1]) throw std::invalid_argument("a level is named twice");
    }
    return {levels.begin(), levels.end()};
  }
  std::uint64_t id(std::uint32_t suffix) {
    if (given_.size() <= suffix) given_.resize(std::size_t(suffix) * 2 + 64);
    given_[suffix] = true;
    return number_ << 32 | suffix;
  }
  std::vector<std::uint32_t> events(const Ids& ids) { return suffixes(ids, false); }
  std::vector<std::uint32_t> conditions(const Ids& ids) { return suffixes(ids, true); }
  std::uint32_t touches(const std::vector<std::pair<Touch, std::vector<std::int64_t>>>& sides) {
    std::vector<std::int64_t> all;
    std::vector<std::pair<std::int64_t, Touch>> each;
    for (const auto& [touch, levels] : sides)
      for (const std::int64_t at : levels) {
        all.push_back(at);
        each.emplace_back(at, touch);
      }
    sorted(all);  // checks range and repeats
    std::sort(each.begin(), each.end());
    std::uint32_t suffix = 0;
    for (auto at = each.rbegin(); at != each.rend(); ++at) suffix = at_rest().suffix(Level(at->first), at->second, suffix);
    return suffix;
  }

  // What goes on depending on a level: by what it was and becomes, the rest; none where that does not happen.
  std::uint32_t branch(std::int64_t level, const std::array<std::optional<std::uint64_t>, 4>& rests) {
    sorted({level});  // checks the range
    Store& at = at_rest();
    std::uint32_t more = 0;
    for (const Touch touch : {Touch::zero, Touch::read, Touch::produce, Touch::consume}) {
      const std::optional<std::uint64_t>& rest = rests[std::size_t(touch)];
      if (!rest) continue;
      const std::uint32_t next = suffixes({*rest}, false).front();
      if (at.first_level(next) <= Level(level)) throw std::invalid_argument("what comes next is on levels below");
      more = at.suffix(Level(level), touch, next, more);
    }
    if (more == 0) throw std::invalid_argument("nothing may happen to this level");
    return more;
  }

 private:
  std::vector<std::uint32_t> suffixes(const Ids& ids, bool conditions) {
    std::vector<std::uint32_t> found;
    found.reserve(ids.size());
    const Store& at = at_rest();
    for (const std::uint64_t id : ids) {
      const auto suffix = std::uint32_t(id);
      const bool known = id >> 32 == number_ && suffix < given_.size() && given_[suffix];
      if (!known || (conditions && !at.is_condition(suffix)))
        throw std::invalid_argument(std::to_string(id) + " is no " + (conditions ? "condition" : "event") +
                                    " of this store");
      found.push_back(suffix);
    }
    return found;
  }

  const std::uint64_t number_ = 1 + stores_made++ % 0x7FFFFFFE;  // ids fit 63 bits
  std::vector<bool> given_;  // by suffix, whether Python has an id of it
  std::atomic<bool> busy_ = false;
};

class Handle {
 public:
  Handle(std::shared_ptr<PyStore> of, Node held) : owner(std::move(of)), node(held) { owner->store.keep(node); }
  Handle(const Handle& other) : Handle(other.owner, other.node) {}
  Handle& operator=(const Handle&) = delete;
  ~Handle() { owner->store.drop(node); }
  Store& store() const { return owner->store; }
  void same_store(const Handle& other) const {
    if (owner != other.owner) throw std::invalid_argument("the sets belong to two stores");
  }
  std::shared_ptr<PyStore> owner;
  Node node;
};

template <class F> Handle computed(const std::shared_ptr<PyStore>& owner, F body, std::uint64_t most_nodes = 0,
                                   std::uint64_t most_steps = 0) {
  Node result = 0;
  owner->run([&] {
    owner->store.begin(most_nodes, most_steps);
    result = body(owner->store);
  });
  return {owner, result};
}

}  // namespace mcpn
