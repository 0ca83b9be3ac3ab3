#include "markings/passages.hpp"

#include <algorithm>
#include <map>

#include "diagrams/store.hpp"

namespace mcpn {

namespace {

constexpr std::size_t kMostFirings = 100'000;  // behind one event, before they are taken for endless

}  // namespace

Passages::Passages(const SafeNet& net, std::vector<Activities> leaving, const std::vector<Control>& control)
    : net_(net), leaving_(std::move(leaving)), marking_(net.words_), enabled_(net.firings_.size() / 64 + 1) {
  for (const auto& [places, at_rest] : control) {
    std::vector<Part>& parts = control_.emplace_back();
    for (std::uint32_t word = 0; word < net.words_; ++word) {
      Part part{word, 0, 0};
      for (const std::uint32_t p : places)
        if (p / 64 == word) set_bit(&part.places, p % 64);
      for (const std::uint32_t p : at_rest)
        if (p / 64 == word) set_bit(&part.at_rest, p % 64);
      if (part.places) parts.push_back(part);
    }
  }
}

std::vector<std::uint32_t> Passages::of(const Word* markings, std::size_t states, const std::int64_t* offsets,
                                        const std::int64_t* targets, const std::uint32_t* events,
                                        const Limits& limits) {
  std::vector<std::uint32_t> numbers;
  std::map<Kind, std::uint32_t> known;
  const std::size_t words = net_.words_;
  for (std::size_t state = 0; state < states; ++state) {
    if ((state & 0xFF) == 0 && !limits.go_on(state, numbers.size())) throw Interrupted();
    for (std::int64_t edge = offsets[state]; edge < offsets[state + 1]; ++edge) {
      std::copy_n(markings + state * words, words, marking_.data());
      std::copy_n(markings + state * words, words, marking_.data());
      const bool ends = run(events[edge]);
      const Word* target = markings + std::size_t(targets[edge]) * words;
      if (!ends || !std::equal(marking_.begin(), marking_.end(), target)) {
        numbers.push_back(kElsewhere);
        continue;
      }
      std::sort(kind_.left.begin(), kind_.left.end());
      std::sort(kind_.idled.begin(), kind_.idled.end());
      const auto [found, fresh] = known.emplace(kind_, std::uint32_t(kinds_.size()));
      if (fresh) kinds_.push_back(kind_);
      numbers.push_back(found->second);
    }
  }
  return numbers;
}

// Whether the run behind an event ends; it is at its end then.
bool Passages::run(std::uint32_t event) {
  kind_ = {};
  running_.clear();
  std::fill(enabled_.begin(), enabled_.end(), 0);
  fire(event);
  std::size_t firings = 0;
  for (std::uint32_t t; (t = next_bit(enabled_.data(), enabled_.size(), 0)) != kNoBit; fire(t))
    if (++firings > kMostFirings) return false;
  return true;
}

void Passages::fire(std::uint32_t t) {
  net_.fire(marking_.data(), t);
  for (const std::uint32_t lost : net_.losers_[t]) enabled_[lost / 64] &= ~(Word(1) << lost % 64);
  for (const std::uint32_t won : net_.winners_[t])
    if (net_.covers(marking_.data(), won)) set_bit(enabled_.data(), won);
  for (const std::uint32_t activity : leaving_[t]) {
    if (std::find(kind_.left.begin(), kind_.left.end(), activity) != kind_.left.end()) continue;
    kind_.left.push_back(activity);
    running_.push_back(activity);
  }
  std::erase_if(running_, [&](std::uint32_t activity) {
    if (!rests(activity)) return false;
    kind_.idled.push_back(activity);
    return true;
  });
}

bool Passages::rests(std::uint32_t activity) const {
  return std::all_of(control_[activity].begin(), control_[activity].end(), [&](const Part& part) {
    return (marking_[part.word] & part.places) == part.at_rest;
  });
}

}  // namespace mcpn
