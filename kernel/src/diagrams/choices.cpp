// One event of many: a decision diagram over what they do to each level, whose branches end where ways are told apart.
#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "diagrams/store.hpp"

namespace mcpn {

namespace {

using Members = std::vector<std::uint32_t>;  // rests of ways, sorted

struct Hash {
  std::size_t operator()(const Members& members) const {
    std::uint64_t hash = members.size();
    for (const std::uint32_t member : members) hash = (hash ^ member) * 0x9E3779B97F4A7C15ull, hash ^= hash >> 29;
    return std::size_t(hash);
  }
};

class Choice {
 public:
  Choice(Store& store, std::size_t most) : store_(store), left_(most), rests_(1) {}

  // The rest of a way behind each of its levels; rests that do the same are the same one, 0 does nothing more.
  std::uint32_t rest(const std::vector<Touched>& way) {
    std::uint32_t behind = 0;
    for (auto at = way.rbegin(); at != way.rend(); ++at) {
      const std::uint64_t key = std::uint64_t(behind) << 32 | std::uint64_t(at->level) << 2 | std::uint64_t(at->touch);
      const auto [known, fresh] = index_.try_emplace(key, std::uint32_t(rests_.size()));
      if (fresh) rests_.push_back({*at, behind});
      behind = known->second;
    }
    return behind;
  }

  // What any of some rests does. Where one does nothing more the others are of no marking that comes here: what enables
  // them enabled that one, too.
  std::optional<std::uint32_t> any(const Members& of) {
    if (of.front() == 0) return 0;
    if (const auto known = made_.find(of); known != made_.end()) return known->second;
    if (left_ == 0) return std::nullopt;
    --left_;
    const Level top = rests_[*std::min_element(of.begin(), of.end(), [&](std::uint32_t a, std::uint32_t b) {
      return rests_[a].touched.level < rests_[b].touched.level;
    })].touched.level;
    std::array<Members, 4> behind;
    const auto read = std::size_t(Touch::read), zero = std::size_t(Touch::zero);
    for (const std::uint32_t n : of)
      if (const Rest& rest = rests_[n]; rest.touched.level == top) behind[std::size_t(rest.touched.touch)].push_back(rest.next);
      else behind[read].push_back(n), behind[zero].push_back(n);
    std::array<std::optional<std::uint32_t>, 4> next;
    for (std::size_t touch = 0; touch < next.size(); ++touch) {
      if (behind[touch].empty()) continue;
      std::sort(behind[touch].begin(), behind[touch].end());
      behind[touch].erase(std::unique(behind[touch].begin(), behind[touch].end()), behind[touch].end());
      if (!(next[touch] = any(behind[touch]))) return std::nullopt;
    }
    std::uint32_t made = 0;
    if (!next[0] && !next[1] && next[read] == next[zero]) made = *next[read];  // the level is left alone
    else
      for (std::size_t touch = next.size(); touch-- > 0;)
        if (next[touch]) made = store_.suffix(top, Touch(touch), *next[touch], made);
    made_.emplace(of, made);
    return made;
  }

 private:
  struct Rest { Touched touched; std::uint32_t next; };

  Store& store_;
  std::size_t left_;  // branches that may still be made
  std::vector<Rest> rests_;
  std::unordered_map<std::uint64_t, std::uint32_t> index_;
  std::unordered_map<Members, std::uint32_t, Hash> made_;
};

}  // namespace

std::optional<std::uint32_t> Store::choice(std::span<const std::vector<Touched>> ways, std::size_t most) {
  Choice choice(*this, most);
  Members all;
  for (const std::vector<Touched>& way : ways) all.push_back(choice.rest(way));
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return choice.any(all);
}

}  // namespace mcpn
