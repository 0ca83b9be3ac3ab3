#include "markings/big_steps.hpp"

#include <algorithm>
#include <limits>
#include <tuple>

namespace mcpn {

namespace {

constexpr Level kNoLevel = ~Level(0);

bool before(const Touched& a, const Touched& b) { return std::tie(a.level, a.touch) < std::tie(b.level, b.touch); }

}  // namespace

BigSteps::BigSteps(const SafeNet& net, const Places& initial, Places places,
                   std::vector<std::pair<std::uint32_t, Level>> partners, std::uint64_t max_bytes, std::uint64_t max_transient)
    : initial_(initial), places_(std::move(places)), partners_(std::move(partners)),
      level_of_(net.places(), {kNoLevel, false}),
      settling_(net, initial, Orders::kEnough,
                {std::numeric_limits<std::uint64_t>::max(), max_bytes,
                 [this](std::uint64_t, std::uint64_t) {
                   return !store_->stop && !(store_->asked_to_stop && store_->asked_to_stop());
                 }},
                max_transient) {
  for (Level at = 0; at < places_.size(); ++at)
    if (places_[at] != kNoPlace) level_of_[places_[at]] = {at, false};
  for (const auto& [place, at] : partners_) level_of_[place] = {at, true};
}

std::optional<std::vector<Level>> BigSteps::start(Store& store) {
  store_ = &store;
  const std::optional<BigStep> step = settling_.step(initial_, std::nullopt);
  if (!step) return std::nullopt;
  std::vector<bool> marked(level_of_.size());
  for (const std::uint32_t p : initial_) marked[p] = true;
  for (const std::uint32_t p : step->taken) marked[p] = false;
  for (const std::uint32_t p : step->put) marked[p] = true;
  std::vector<Level> levels;
  for (Level at = 0; at < places_.size(); ++at)
    if (places_[at] != kNoPlace && marked[places_[at]]) levels.push_back(at);
  return levels;
}

std::optional<std::pair<std::vector<BigSteps::Way>, bool>> BigSteps::cover(Store& store, Node markings, std::uint32_t event,
                                                                           std::size_t most) {
  store_ = &store;
  std::vector<Way> found;
  std::vector<Level> marked;
  std::vector<bool> held(store.levels);
  Places places;
  Held left(store, markings);
  while (left) {
    if (found.size() == most) return std::pair(std::move(found), false);
    marked.clear();
    store.pick(left, marked);
    std::fill(held.begin(), held.end(), false);
    for (const Level at : marked) held[at] = true;
    places.clear();
    for (Level at = 0; at < places_.size(); ++at)
      if (held[at] && places_[at] != kNoPlace) places.push_back(places_[at]);
    for (const auto& [place, at] : partners_)
      if (!held[at]) places.push_back(place);
    const std::optional<BigStep> step = settling_.step(places, event);
    if (!step) return std::nullopt;
    found.push_back(way(*step));
    std::uint32_t where = 0;
    for (auto at = found.back().rbegin(); at != found.back().rend(); ++at) where = store.suffix(at->level, at->asked(), where);
    const Held here(store, store.filter(left, where));
    left = store.minus(left, here);
  }
  return std::pair(std::move(found), true);
}

// Partners say the same of their level: it is named once.
BigSteps::Way BigSteps::way(const BigStep& step) const {
  Way found;
  const auto touch = [&](const Places& places, Touch as, Touch reversed) {
    for (const std::uint32_t p : places)
      if (level_of_[p].first != kNoLevel) found.push_back({level_of_[p].first, level_of_[p].second ? reversed : as});
  };
  touch(step.taken, Touch::consume, Touch::produce);
  touch(step.put, Touch::produce, Touch::consume);
  touch(step.marked, Touch::read, Touch::zero);
  touch(step.empty, Touch::zero, Touch::read);
  std::sort(found.begin(), found.end(), before);
  found.erase(std::unique(found.begin(), found.end(), [](const Touched& a, const Touched& b) { return a.level == b.level; }), found.end());
  return found;
}

}  // namespace mcpn
