// Operations of a store keep what their callers hold, also where they give up their first way.
#include <cstdio>
#include <random>

#include "diagrams/store.hpp"

using namespace mcpn;

int main() {
  constexpr Level kLevels = 60;
  Store store(kLevels, std::uint64_t(1) << 32);
  store.begin();
  std::mt19937 draw(7);
  // So many conditions, and so many markings, that what is pending of the conditions is too much to go on together.
  std::vector<std::uint32_t> conditions, events;
  for (int i = 0; i < 3000; ++i) {
    std::uint32_t condition = 0, event = 0;
    for (Level at = kLevels; at-- > 0;)
      if (draw() % 6 == 0) {
        const bool marked = draw() % 2;
        condition = store.suffix(at, marked ? Touch::read : Touch::zero, condition);
        event = store.suffix(at, marked ? Touch::consume : Touch::produce, event);
      }
    conditions.push_back(condition), events.push_back(event);
  }
  const Held outer(store, store.singleton({1, 2, 3}));
  Held all(store, 0);
  for (int i = 0; i < 700; ++i) {
    std::vector<Level> marked;
    for (Level at = 0; at < kLevels; ++at)
      if (draw() % 2) marked.push_back(at);
    const Held one(store, store.singleton(marked));
    all = store.join(all, one);
  }
  const Node before = outer, whole = all;
  const Held left(store, store.without(all, conditions));
  const Held after(store, store.images(all, events));
  store.collect();
  // What is held stands where it did, and collection has left it alone.
  const bool kept = Node(outer) == before && Node(all) == whole && store.singleton({1, 2, 3}) == before;
  // The same one condition, one event at a time.
  Held one_by_one(store, all), fired(store, 0);
  for (const std::uint32_t condition : conditions) one_by_one = store.minus(one_by_one, Held(store, store.filter(all, condition)));
  for (const std::uint32_t event : events) fired = store.join(fired, Held(store, store.image(all, event)));
  std::printf("%d %d %d\n", kept, Node(left) == Node(one_by_one), Node(after) == Node(fired));
}
