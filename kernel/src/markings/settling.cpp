#include "markings/settling.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "diagrams/store.hpp"

namespace mcpn {

namespace {

constexpr std::uint32_t kMostSteps = 100'000;  // internal firings in a row before they are taken for endless
constexpr std::size_t kUnkept = 4096;      // firings behind an event after which each marking is kept
constexpr State kOpen = ~State(0);         // a marking whose ways are being tried
constexpr State kEntered = kOpen - 1;      // one that has just been put on the path

}  // namespace

Settling::Settling(const SafeNet& net, const Stubborn::Places& initial, Orders orders, const Limits& limits,
                   std::uint64_t max_transient, std::uint64_t max_firings)
    : net_(net), initial_(initial), orders_(orders), limits_(limits),
      transient_limits_{max_transient, limits.bytes, limits.go_on},
      stable_(found_, limits_, "stable states"), marking_(net.words_), enabled_(net.firings_.size() / 64 + 1),
      max_firings_(max_firings) {
  found_.words = net.words_;
  forget();
  if (orders == Orders::kEnough) stubborn_.emplace(net, initial);
}

// Nothing is kept of the transient markings passed.
void Settling::forget() {
  passed_ = {};
  passed_.words = net_.words_;
  transient_.emplace(passed_, transient_limits_, "transient markings", &stable_);
}

Exploration Settling::run() {
  marking_ = net_.marking_of(initial_);
  net_.collect(marking_.data(), net_.internal_, enabled_);
  if (!settled(0, 0)) return std::move(found_);
  found_.offsets.push_back(0);
  std::vector<Word> events(enabled_.size());
  for (State state = 0; state < found_.states(); ++state) {
    const auto here = [&] { return found_.markings.data() + std::uint64_t(state) * found_.words; };
    std::fill(events.begin(), events.end(), 0);
    net_.collect(here(), net_.events_, events);
    for (std::uint32_t t = 0; (t = next_bit(events.data(), events.size(), t)) != kNoBit; ++t) {
      std::copy_n(here(), found_.words, marking_.data());
      std::fill(enabled_.begin(), enabled_.end(), 0);
      if (!fire(t)) {
        firings_.assign(1, t);
        stop(state, "unsafe");
        return std::move(found_);
      }
      const std::optional<State> target = settled(state, t);
      if (!target) {
        found_.trouble->firings.insert(found_.trouble->firings.begin(), t);
        return std::move(found_);
      }
      ++found_.edges;
      if (orders_ != Orders::kOne) ++found_.decided[std::size_t(means_)];
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

std::optional<BigStep> Settling::step(const Stubborn::Places& marking, std::optional<std::uint32_t> event) {
  if (!reads_) reads_.emplace(net_.words_, stubborn_->units_of(), stubborn_->units(),
                              net_.firings_.size());
  if (passed_.states()) forget();
  marking_ = net_.marking_of(marking);
  reads_->begin(marking_);
  std::fill(enabled_.begin(), enabled_.end(), 0);
  if (!event) net_.collect(marking_.data(), net_.internal_, enabled_);
  else if (!fire(*event)) {
    firings_.assign(1, *event);
    stop(0, "unsafe");
    return std::nullopt;
  }
  const std::optional<State> end = settled(0, event.value_or(0));
  if (!end) return std::nullopt;
  return told(found_.markings.data() + std::uint64_t(*end) * found_.words);
}

BigStep Settling::told(const Word* after) const {
  BigStep step;
  const std::vector<Word>&read = reads_->places(), &before = reads_->before();
  for (std::uint32_t p = 0; (p = next_bit(read.data(), read.size(), p)) != kNoBit; ++p) {
    const bool was = has_bit(before.data(), p), is = has_bit(after, p);
    (was ? is ? step.marked : step.taken : is ? step.put : step.empty).push_back(p);
  }
  return step;
}

void Settling::absent(std::uint32_t end) {
  reads_->tell_absent(end, net_, marking_.data(), [](std::uint32_t) { return false; });
}

// Fires a transition and keeps what is enabled up to date; false where it is unsafe.
bool Settling::fire(std::uint32_t t) {
  if (++fired_ > max_firings_)
    throw StateLimit("more than " + std::to_string(max_firings_) + " firings: the limit on firings was hit");
  if ((fired_ & 0xFFF) == 0 && !limits_.go_on(found_.states(), found_.edges)) throw Interrupted();
  if (reads_) {
    reads_->read(net_.firings_[t].need);
    reads_->read(net_.firings_[t].put);
  }
  if (!net_.fire(marking_.data(), t)) return false;
  for (const std::uint32_t lost : net_.losers_[t]) enabled_[lost / 64] &= ~(Word(1) << lost % 64);
  for (const std::uint32_t won : net_.winners_[t])
    if (net_.covers(marking_.data(), won)) enabled_[won / 64] |= Word(1) << won % 64;
    else if (reads_) reads_->wait(won);
  return true;
}

// The stable end behind the marking that an event has led to; nothing where it has come to trouble.
std::optional<State> Settling::settled(State from, std::uint32_t event) {
  firings_.clear();
  if (orders_ == Orders::kOne) return one_way(from, event);
  if (stubborn_) stubborn_->begin(marking_.data());
  means_ = Means::kOnly;
  const std::optional<State> end = all_ways(from, event);
  found_.transient = passed_.states();
  return end;
}

std::optional<State> Settling::one_way(State from, std::uint32_t event) {
  for (std::uint32_t t; (t = next_bit(enabled_.data(), enabled_.size(), 0)) != kNoBit;) {  // of the first rank
    firings_.push_back(t);
    const bool safe = fire(t);
    if (!safe || firings_.size() > kMostSteps) {
      stop(from, safe ? "endless" : "unsafe");
      return std::nullopt;
    }
  }
  return stable_.number(marking_.data(), from, event);
}

std::optional<State> Settling::all_ways(State from, std::uint32_t event) {
  const std::size_t words = enabled_.size();
  for (std::optional<State> end = enter(from, event); end;) {
    if (*end != kEntered) {
      if (path_.empty()) return end;
      Step& before = path_.back();
      if (*end == kOpen) {
        stop(from, "endless");
        return std::nullopt;
      }
      if (before.end != kOpen && before.end != *end) {  // all ways before this one have led to the end of the first
        firings_.resize(before.firings);
        firings_.push_back(next_bit(top(), words, 0));
        firings_.push_back(before.next - 1);
        stop(from, "parted");
        return std::nullopt;
      }
      before.end = *end;
    }
    Step& at = path_.back();
    const Word* ways = top();
    const std::uint32_t t = next_bit(ways, words, at.next);
    if (t >= at.ways_end) {  // or none
      end = passed_.targets[at.number] = at.end;
      ways_.resize(ways_.size() - words);
      path_.pop_back();
      continue;
    }
    at.next = t + 1;
    std::copy_n(passed_.markings.data() + std::uint64_t(at.number) * passed_.words, passed_.words, marking_.data());
    std::copy_n(ways, words, enabled_.data());
    if (reads_) reads_->go_back();
    firings_.resize(at.firings);
    firings_.push_back(t);
    if (!fire(t)) {
      stop(from, "unsafe");
      return std::nullopt;
    }
    end = enter(from, event);
  }
  return std::nullopt;
}

// Goes on while a transition may fire alone. The end of the marking that it has come to, where it is known; else the
// marking is put on the path. Nothing where a firing is unsafe.
std::optional<State> Settling::enter(State from, std::uint32_t event) {
  for (;;) {
    const std::uint32_t first = next_bit(enabled_.data(), enabled_.size(), 0);
    if (reads_) absent(first == kNoBit ? std::uint32_t(net_.firings_.size()) : net_.rank_begin(first));
    if (first == kNoBit) return stable_.number(marking_.data(), from, event);
    const std::optional<std::uint32_t> found =
        stubborn_ ? stubborn_->alone(marking_.data(), enabled_, first, reads_ ? &*reads_ : nullptr) : std::nullopt;
    const std::uint32_t alone = found.value_or(kNoBit);
    means_ = std::max(means_, stubborn_ ? stubborn_->means(found, enabled_, first) : Means::kEvery);
    const bool several = alone == kNoBit;
    if (several && reads_) absent(net_.rank_end_[first]);
    if (several || firings_.size() > kUnkept) {
      const State known = State(passed_.states()), number = transient_->number(marking_.data(), 0, 0);
      if (number < known) return passed_.targets[number];
      transient_->grow(passed_.targets, 1);
      transient_->grow(path_, 1);
      transient_->grow(ways_, enabled_.size());
      passed_.targets.push_back(kOpen);
      path_.push_back({number, kOpen, several ? 0 : alone, several ? net_.rank_end_[first] : alone + 1, firings_.size()});
      ways_.insert(ways_.end(), enabled_.begin(), enabled_.end());
      if (several) ++found_.parted;
      return kEntered;
    }
    firings_.push_back(alone);
    if (!fire(alone)) {
      stop(from, "unsafe");
      return std::nullopt;
    }
  }
}

// Ends it: the firings are those that have led to where it is, and the last ones.
void Settling::stop(State from, const char* kind) { found_.trouble = {from, firings_, kind}; }

}  // namespace mcpn
