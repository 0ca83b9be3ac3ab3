// Walks: one marking at a time, what is enabled and how far the goals are kept up to date firing by firing.
#include <algorithm>
#include <set>
#include <utility>

#include "diagrams/store.hpp"
#include "search/draw.hpp"
#include "search/tokens.hpp"

namespace mcpn::search {

namespace {

constexpr std::uint32_t kSampled = 48, kSampledDead = 16;  // enabled transitions that a guided step compares
enum Mode { random, guided, ordered, counted };

// A marking that is changed in place, with the transitions that it enables and the sums that goals ask for.
class Walker {
 public:
  Walker(const TokenNet& net, const Marking& initial, const Goals& goals, const std::vector<std::uint32_t>& roots)
      : net_(net), goals_(goals), initial_(initial), missing0_(net.rules.size(), 0),
        sums0_(goals.sums(initial)), askers_(goals.bounds.size()), lists_(net.ranks),
        is_touched_(roots.size(), false) {
    std::vector<std::uint32_t> atoms;
    for (std::uint32_t g = 0; g < roots.size(); ++g) {
      atoms.clear();
      goals.atoms(roots[g], atoms);
      for (const std::uint32_t atom : atoms)
        if (askers_[atom].empty() || askers_[atom].back() != g) askers_[atom].push_back(g);
      if (goals.asks_dead(roots[g])) always_.push_back(g);
    }
    for (Transition t = 0; t < net.rules.size(); ++t)
      for (const auto& [place, weight] : net.rules[t].need) missing0_[t] += initial[place] < weight;
  }

  // From here on, what is enabled is kept sorted by these keys as well; by none where there are none.
  void sort_by(const std::vector<std::uint32_t>* keys) { keys_ = keys; }
  // The first of those that are enabled.
  Transition first() const { return sorted_.begin()->second; }

  void begin() {
    sorted_.clear();
    tokens_ = initial_;
    missing_ = missing0_;
    sums_ = sums0_;
    for (auto& list : lists_) list.clear();
    at_.assign(net_.rules.size(), 0);
    for (Transition t = 0; t < net_.rules.size(); ++t)
      if (missing_[t] == 0) insert(t);
  }

  const std::vector<Transition>& enabled() const {
    for (const auto& list : lists_)
      if (!list.empty()) return list;
    return lists_.back();
  }
  // Fires, or undoes with sign -1; whether some place holds more than one token, or too many to follow.
  void fire(Transition t, Tokens sign = 1) {
    for (const auto& [place, change] : net_.rules[t].change) {
      const Tokens before = tokens_[place], after = before + sign * change;
      tokens_[place] = after;
      crowded |= after > 1 && after > before;
      flooded |= after > kMost;
      for (const auto& [user, weight] : net_.users[place]) {
        if (before < weight && after >= weight) {
          if (--missing_[user] == 0) insert(user);
        } else if (before >= weight && after < weight) {
          if (missing_[user]++ == 0) remove(user);
        }
      }
      for (const auto& [atom, weight] : goals_.watch[place]) {
        const bool held = sums_[atom] <= goals_.bounds[atom];
        sums_[atom] += sign * weight * change;
        if (held != (sums_[atom] <= goals_.bounds[atom]))
          for (const std::uint32_t g : askers_[atom]) touch(g);
      }
    }
    for (const std::uint32_t g : always_) touch(g);
  }
  void touch(std::uint32_t goal) {
    if (!is_touched_[goal]) touched_.push_back(goal);
    is_touched_[goal] = true;
  }
  // Goals that may have changed since they were looked at, the first ones first.
  const std::vector<std::uint32_t>& touched() {
    for (const std::uint32_t goal : touched_) is_touched_[goal] = false;
    looked_.swap(touched_);
    touched_.clear();
    std::sort(looked_.begin(), looked_.end());
    return looked_;
  }
  bool holds(std::uint32_t root) const { return goals_.holds(root, sums_, enabled().size()); }
  Tokens distance(std::uint32_t root) const { return goals_.distance(root, sums_, enabled().size()); }
  // The distance after one more firing.
  Tokens distance_after(Transition t, std::uint32_t root, bool asks_dead) {
    if (asks_dead) {
      const bool was = crowded, over = flooded;
      fire(t);
      const Tokens found = distance(root);
      fire(t, -1);
      crowded = was;
      flooded = over;
      return found;
    }
    shift(t, 1);
    const Tokens found = goals_.distance(root, sums_, 1);
    shift(t, -1);
    return found;
  }

  bool crowded = false, flooded = false;

 private:
  void shift(Transition t, Tokens sign) {
    for (const auto& [place, change] : net_.rules[t].change)
      for (const auto& [atom, weight] : goals_.watch[place]) sums_[atom] += sign * weight * change;
  }
  std::vector<Transition>& list(Transition t) { return lists_[net_.order[t]]; }
  void insert(Transition t) {
    at_[t] = std::uint32_t(list(t).size());
    list(t).push_back(t);
    if (keys_) sorted_.insert(key(t));
  }
  void remove(Transition t) {
    auto& from = list(t);
    at_[from.back()] = at_[t];
    from[at_[t]] = from.back();
    from.pop_back();
    if (keys_) sorted_.erase(key(t));
  }
  std::pair<std::uint64_t, Transition> key(Transition t) const {
    return {std::uint64_t(net_.order[t]) << 32 | (*keys_)[t], t};
  }

  const TokenNet& net_;
  const Goals& goals_;
  const Marking& initial_;
  std::vector<std::uint32_t> missing0_;  // needs that the initial marking does not meet
  std::vector<Tokens> sums0_;
  std::vector<std::vector<std::uint32_t>> askers_;  // by atom: the goals that it is in
  std::vector<std::uint32_t> always_;               // goals that ask what may fire
  Marking tokens_;
  std::vector<std::uint32_t> missing_, at_;
  std::vector<Tokens> sums_;
  std::vector<std::vector<Transition>> lists_;  // enabled, by the place of their rank
  std::vector<std::uint32_t> touched_, looked_;
  std::vector<bool> is_touched_;
  const std::vector<std::uint32_t>* keys_ = nullptr;
  std::set<std::pair<std::uint64_t, Transition>> sorted_;  // enabled, by rank and key
};

}  // namespace

std::vector<Reached> walk(const TokenNet& net, const Marking& initial, const Goals& goals,
                          const std::vector<std::uint32_t>& roots, const WalkOptions& options, const GoOn& go_on) {
  Draw draw(options.seed);
  Walker walker(net, initial, goals, roots);
  std::vector<Reached> found;
  std::vector<bool> open(roots.size(), true), asks_dead;
  for (const std::uint32_t root : roots) asks_dead.push_back(goals.asks_dead(root));
  std::size_t left = roots.size() + options.unsafe;
  bool unsafe = options.unsafe;
  std::vector<Transition> run, candidates;
  std::vector<std::uint32_t> keys(net.rules.size());
  std::vector<Tokens> remaining;

  const auto look = [&] {
    for (const std::uint32_t g : walker.touched())
      if (open[g] && walker.holds(roots[g])) {
        found.push_back({g, run});
        open[g] = false;
        --left;
      }
    if (unsafe && walker.crowded) {
      found.push_back({std::uint32_t(roots.size()), run});
      unsafe = false;
      --left;
    }
  };

  // Components that are alike, each doing the same first, often lock each other: the second walk is by such an order.
  const bool alike = !options.order.empty() && std::find(asks_dead.begin(), asks_dead.end(), true) != asks_dead.end();
  std::uint64_t spent = 0;
  for (std::uint64_t round = 0; left && spent < options.steps; ++round) {
    const bool given = alike && round == 1;
    walker.sort_by(given ? &options.order : nullptr);
    walker.begin();
    walker.crowded = walker.flooded = false;
    run.clear();
    for (std::uint32_t g = 0; round == 0 && g < roots.size(); ++g) walker.touch(g);
    look();
    const std::uint64_t drawn = alike && round > 1 ? round - 1 : round;  // the round by order aside
    Mode mode = given ? ordered : Mode(drawn % 3);
    if (!given && !options.counts.empty() && round % 2 == 0) mode = counted;
    if (mode == ordered && !given)
      for (auto& key : keys) key = std::uint32_t(draw.next() >> 32);
    if (mode == counted) remaining = options.counts;
    std::uint32_t focus = std::uint32_t(roots.size());  // the open goal that a guided walk heads for
    if (mode == guided) {
      const std::uint32_t first = roots.empty() ? 0 : draw.below(roots.size());
      for (std::uint32_t i = 0; i < roots.size() && focus == roots.size(); ++i)
        if (open[(first + i) % roots.size()]) focus = std::uint32_t((first + i) % roots.size());
      if (focus == roots.size()) mode = random;
    }
    const std::uint64_t length = given ? options.length : options.length << std::min<std::uint64_t>(drawn / 3 % 6, 5);
    spent += 1 + net.rules.size() / 8;
    if (round % 256 == 255 && !go_on()) throw Interrupted();
    for (std::uint64_t step = 0; left && step < length && spent < options.steps; ++step, ++spent) {
      const auto& enabled = walker.enabled();
      if (enabled.empty() || walker.flooded) break;
      const auto count = std::uint32_t(enabled.size());
      Transition chosen = enabled[draw.below(count)];
      if (mode == guided && draw.below(8) != 0) {
        Tokens least = kFar + 1;
        const std::uint32_t start = draw.below(count), most = std::min(count, asks_dead[focus] ? kSampledDead : kSampled);
        candidates.clear();  // what is fired and undone changes the order of those that are enabled
        for (std::uint32_t i = 0; i < most; ++i) candidates.push_back(enabled[(start + i) % count]);
        for (const Transition t : candidates) {
          const Tokens far = walker.distance_after(t, roots[focus], asks_dead[focus]);
          spent += asks_dead[focus] ? 2u : 1u;
          if (far < least || (far == least && draw.below(2))) {
            least = far;
            chosen = t;
          }
        }
      } else if (given) {
        chosen = walker.first();
      } else if (mode == ordered) {
        spent += count / 8;
        for (const Transition t : enabled)
          if (keys[t] < keys[chosen]) chosen = t;
      } else if (mode == counted) {
        const std::uint32_t start = draw.below(count);
        for (std::uint32_t i = 0; i < count; ++i) {
          const Transition t = enabled[(start + i) % count];
          spent += i % 8 == 7;
          if (remaining[t] > 0) {
            chosen = t;
            break;
          }
        }
        --remaining[chosen];
      }
      walker.fire(chosen);
      run.push_back(chosen);
      look();
      if ((step & 0xFFF) == 0xFFF && !go_on()) throw Interrupted();
      if (mode == guided && !open[focus]) break;
    }
  }
  return found;
}

}  // namespace mcpn::search
