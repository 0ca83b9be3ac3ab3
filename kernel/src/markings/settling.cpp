#include "markings/settling.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "diagrams/store.hpp"

namespace mcpn {

namespace {

constexpr std::uint32_t kMostSteps = 100'000;  // internal firings in a row before they are taken for endless
constexpr std::uint32_t kNone = ~std::uint32_t(0);
constexpr State kOpen = ~State(0);         // a marking whose ways are being tried
constexpr State kEntered = kOpen - 1;      // one that has just been put on the path

// The first bit that is set from one on.
std::uint32_t next_bit(const Word* bits, std::size_t words, std::uint32_t from) {
  for (std::size_t w = from / 64; w < words; ++w) {
    const Word left = w == from / 64 ? bits[w] & ~Word(0) << from % 64 : bits[w];
    if (left) return std::uint32_t(w) * 64 + std::uint32_t(std::countr_zero(left));
  }
  return kNone;
}

}  // namespace

Settling::Settling(const SafeNet& net, bool every, const Limits& limits, std::uint64_t max_transient)
    : net_(net), every_(every), limits_(limits), transient_limits_{max_transient, limits.bytes, limits.go_on},
      stable_(found_, limits_, "stable states", &transient_),
      transient_(passed_, transient_limits_, "transient markings", &stable_), marking_(net.words_),
      enabled_(net.firings_.size() / 64 + 1) {
  found_.words = passed_.words = net.words_;
}

Exploration Settling::run(const std::vector<std::uint32_t>& initial) {
  marking_ = net_.marking_of(initial);
  net_.collect(marking_.data(), net_.internal_, enabled_);
  if (!settled(0, 0)) return std::move(found_);
  found_.offsets.push_back(0);
  std::vector<Word> events(enabled_.size());
  for (State state = 0; state < found_.states(); ++state) {
    const auto here = [&] { return found_.markings.data() + std::uint64_t(state) * found_.words; };
    std::fill(events.begin(), events.end(), 0);
    net_.collect(here(), net_.events_, events);
    for (std::uint32_t t = 0; (t = next_bit(events.data(), events.size(), t)) != kNone; ++t) {
      std::copy_n(here(), found_.words, marking_.data());
      std::fill(enabled_.begin(), enabled_.end(), 0);
      if (!fire(t)) {
        stop(state, "unsafe", {t});
        return std::move(found_);
      }
      const std::optional<State> target = settled(state, t);
      if (!target) {
        found_.trouble->firings.insert(found_.trouble->firings.begin(), t);
        return std::move(found_);
      }
      ++found_.edges;
      stable_.grow(found_.targets, 1);
      stable_.grow(found_.labels, 1);
      found_.targets.push_back(*target);
      found_.labels.push_back(t);
    }
    stable_.grow(found_.offsets, 1);
    found_.offsets.push_back(found_.edges);
  }
  return std::move(found_);
}

// Fires a transition and keeps what is enabled up to date; false where it is unsafe.
bool Settling::fire(std::uint32_t t) {
  if ((++firings_ & 0xFFF) == 0 && !limits_.go_on(found_.states(), found_.edges)) throw Interrupted();
  if (!net_.fire(marking_.data(), t)) return false;
  for (const std::uint32_t lost : net_.losers_[t]) enabled_[lost / 64] &= ~(Word(1) << lost % 64);
  for (const std::uint32_t won : net_.winners_[t])
    if (net_.covers(marking_.data(), won)) enabled_[won / 64] |= Word(1) << won % 64;
  return true;
}

// The stable end behind the marking that an event has led to; nothing where it has come to trouble.
std::optional<State> Settling::settled(State from, std::uint32_t event) {
  return every_ ? every_way(from, event) : one_way(from, event);
}

std::optional<State> Settling::one_way(State from, std::uint32_t event) {
  std::vector<std::uint32_t> run;
  for (std::uint32_t t; (t = next_bit(enabled_.data(), enabled_.size(), 0)) != kNone;) {  // of the first rank
    run.push_back(t);
    const bool safe = fire(t);
    if (!safe || run.size() > kMostSteps) {
      stop(from, safe ? "endless" : "unsafe", std::move(run));
      return std::nullopt;
    }
  }
  return stable_.number(marking_.data(), from, event);
}

std::optional<State> Settling::every_way(State from, std::uint32_t event) {
  const std::size_t words = enabled_.size();
  for (State end = enter(from, event);;) {
    if (end != kEntered) {
      if (path_.empty()) return end;
      Step& before = path_.back();
      if (end == kOpen) {
        stop(from, "endless", {});
        return std::nullopt;
      }
      if (before.end != kOpen && before.end != end) {  // all ways before this one have led to the end of the first
        const std::uint32_t last = std::exchange(before.next, next_bit(top(), words, 0) + 1) - 1;
        stop(from, "parted", {last});
        return std::nullopt;
      }
      before.end = end;
    }
    Step& at = path_.back();
    const Word* ways = top();
    const std::uint32_t t = next_bit(ways, words, at.next);
    if (t >= at.rank_end) {  // or none
      end = passed_.targets[at.number] = at.end;
      ways_.resize(ways_.size() - words);
      path_.pop_back();
      continue;
    }
    at.next = t + 1;
    std::copy_n(passed_.markings.data() + std::uint64_t(at.number) * passed_.words, passed_.words, marking_.data());
    std::copy_n(ways, words, enabled_.data());
    if (!fire(t)) {
      stop(from, "unsafe", {});
      return std::nullopt;
    }
    end = enter(from, event);
  }
}

// The end of the marking that it has come to, where it is known; else the marking is put on the path.
State Settling::enter(State from, std::uint32_t event) {
  const std::uint32_t first = next_bit(enabled_.data(), enabled_.size(), 0);
  if (first == kNone) return stable_.number(marking_.data(), from, event);
  const State known = State(passed_.states()), number = transient_.number(marking_.data(), 0, 0);
  if (number < known) return passed_.targets[number];
  transient_.grow(passed_.targets, 1);
  transient_.grow(path_, 1);
  transient_.grow(ways_, enabled_.size());
  passed_.targets.push_back(kOpen);
  path_.push_back({number, kOpen, 0, net_.rank_end_[first]});
  ways_.insert(ways_.end(), enabled_.begin(), enabled_.end());
  return kEntered;
}

// Ends it: the firings are those on the path, and the last ones.
void Settling::stop(State from, const char* kind, std::vector<std::uint32_t> last) {
  std::vector<std::uint32_t> firings;
  for (const Step& step : path_) firings.push_back(step.next - 1);
  firings.insert(firings.end(), last.begin(), last.end());
  found_.trouble = {from, std::move(firings), kind};
}

}  // namespace mcpn
