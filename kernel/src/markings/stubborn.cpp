#include "markings/stubborn.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <utility>

#include "markings/bits.hpp"

namespace mcpn {

namespace {

using Places = Stubborn::Places;

bool meet(const Places& some, const Places& others) {
  return std::any_of(some.begin(), some.end(), [&](std::uint32_t p) { return std::find(others.begin(), others.end(), p) != others.end(); });
}

Places sorted(Places places) {
  std::sort(places.begin(), places.end());
  return places;
}

}  // namespace

Stubborn::Stubborn(const SafeNet& net, const Places& initial)
    : net_(net), units_of_(net.places_), bounded_(net.words_), rivals_(net.firings_.size()),
      crowders_(net.firings_.size()), event_(net.words_),
      known_(net.firings_.size()), marked_(net.words_), giver_(net.places_), givers_(net.places_) {
  std::map<std::pair<Places, Places>, std::uint32_t> numbers;
  for (const Firing& firing : net.firings_)
    does_.push_back(numbers.try_emplace({sorted(firing.take), sorted(firing.put)}, std::uint32_t(numbers.size())).first->second);
  const std::size_t words = net.firings_.size() / 64 + 1;
  for (std::vector<Word>* bits : {&always_, &apart_, &behind_event_, &here_, &brought_}) bits->assign(words, 0);
  std::uint32_t number = 0;
  for (const Places& unit : net.units(initial)) {
    for (const std::uint32_t p : unit) {
      set_bit(bounded_.data(), p);
      units_of_[p].push_back(number);
    }
    ++number;
  }
  units_ = number;
  const std::uint32_t events = std::uint32_t(std::find_if(net.firings_.begin(), net.firings_.end(), [](const Firing& f) { return f.rank == kEvents; }) - net.firings_.begin());
  for (std::uint32_t t = 0; t < events; ++t)
    for (const std::uint32_t p : net.firings_[t].put) givers_[p].push_back(t);
  std::vector<Word> contested(words);
  for (std::uint32_t t = 0; t < events; ++t) {
    const Firing& firing = net.firings_[t];
    for (const std::uint32_t u : net.losers_[t]) {
      if (alike(t, u)) continue;
      set_bit(contested.data(), t);
      set_bit(contested.data(), u);
      if (apart(t, u)) continue;
      rivals_[t].push_back(u);
      rivals_[u].push_back(t);
    }
    for (const std::uint32_t p : firing.take)
      if (!has_bit(bounded_.data(), p))
        std::copy_if(givers_[p].begin(), givers_[p].end(), std::back_inserter(crowders_[t]),
                     [t](std::uint32_t u) { return u != t; });  // who puts back what it takes adds nothing
  }
  std::vector<Word> all(words);
  for (std::uint32_t t = 0; t < events; ++t) {
    set_bit(all.data(), t);
    if (net.rank_end_[t] != t + 1) continue;  // all of its rank are there
    for (std::uint32_t u = t + 1; u-- > 0 && net.rank_end_[u] == t + 1;)
      if (judge(u, all)) {
        set_bit(always_.data(), u);
        bool met = has_bit(contested.data(), u);
        for (std::size_t w = 0; w < words; ++w) met |= (contested[w] & brought_[w]) != 0;
        if (!met) set_bit(apart_.data(), u);
      }
  }
}

void Stubborn::begin(const Word* marking) {
  std::copy_n(marking, net_.words_, event_.begin());
  told_ = false;
}

// Whether two transitions are never enabled at a time: they need different places of one unit.
bool Stubborn::apart(std::uint32_t t, std::uint32_t u) const {
  for (const std::uint32_t p : net_.firings_[t].need)
    for (const std::uint32_t q : net_.firings_[u].need)
      if (p != q && share_unit(p, q)) return true;
  return false;
}

bool Stubborn::share_unit(std::uint32_t p, std::uint32_t q) const { return meet(units_of_[p], units_of_[q]); }

std::optional<std::uint32_t> Stubborn::alone(const Word* marking, const std::vector<Word>& enabled, std::uint32_t first,
                                             Reads* reads) {
  const std::size_t words = enabled.size();
  const std::uint32_t end = net_.rank_end_[first];
  const bool single = next_bit(enabled.data(), words, first + 1) >= end;
  if (single && !reads) return first;
  for (std::size_t w = first / 64; w * 64 < end; ++w)
    if (const Word both = enabled[w] & always_[w]) {
      const std::uint32_t t = std::uint32_t(w) * 64 + std::uint32_t(std::countr_zero(both));
      if (t < end) return t;
      break;
    }
  if (single) {  // no other of its rank is enabled, but for those that do the same
    reads->tell_absent(end, net_, marking, [&](std::uint32_t t) { return alike(t, first); });
    return first;
  }
  if (!reads) {  // what is behind the whole event would be read
    if (!told_) {
      relax(event_.data(), std::uint32_t(net_.firings_.size()), behind_event_);
      std::fill(known_.begin(), known_.end(), Known::kNot);
      told_ = true;
    }
    for (std::uint32_t t = first; t < end; t = next_bit(enabled.data(), words, t + 1)) {
      if (known_[t] == Known::kNot) known_[t] = judge(t, behind_event_) ? Known::kAlone : Known::kBesideOthers;
      if (known_[t] == Known::kAlone) return t;
    }
  }
  for (const bool waiting : {false, true}) {  // whether what waits for it is left out, each asked for by itself
    if (!waiting) relax(marking, end, here_);
    for (std::uint32_t t = first; t < end; t = next_bit(enabled.data(), words, t + 1)) {
      if (waiting && brings_about(t)) continue;
      if (waiting) relax(marking, end, here_, t);
      if (!judge(t, here_)) continue;
      if (reads) note_absence(end, [&](const Places& need) { return reads->missing(need, marked_.data()); }, waiting ? t : kNoBit);
      return t;
    }
  }
  return std::nullopt;
}

bool Stubborn::brings_about(std::uint32_t t) const {
  return std::any_of(net_.winners_[t].begin(), net_.winners_[t].end(), [&](std::uint32_t u) { return net_.rank_end_[u] < net_.rank_end_[t]; });
}

Means Stubborn::means(std::optional<std::uint32_t> found, const std::vector<Word>& enabled, std::uint32_t first) const {
  if (!found) return Means::kEvery;
  if (next_bit(enabled.data(), enabled.size(), first + 1) >= net_.rank_end_[first]) return Means::kOnly;
  if (!has_bit(always_.data(), *found)) return Means::kReach;
  return has_bit(apart_.data(), *found) ? Means::kArcs : Means::kUnits;
}

// Of places that a transition needs, those out of reach that no other transition marks than such as are absent anyhow, if
// there are any: to note one of them asks for nothing more.
Stubborn::Places Stubborn::likely_empty(const Places& need, std::uint32_t end, std::uint32_t without) const {
  Places some;
  for (const std::uint32_t p : need)
    if (!has_bit(marked_.data(), p) && std::all_of(givers_[p].begin(), givers_[p].end(), [&](std::uint32_t t) {
          return t >= end || t == without || has_bit(brought_.data(), t);
        }))
      some.push_back(p);
  return some.empty() ? need : some;
}

void Stubborn::relax(const Word* marking, std::uint32_t end, std::vector<Word>& may, std::uint32_t without) {
  std::fill(may.begin(), may.end(), 0);
  std::copy_n(marking, net_.words_, marked_.begin());
  net_.collect(marking, net_.internal_, may);
  for (std::size_t w = end / 64; w < may.size(); ++w) may[w] &= w == end / 64 ? (Word(1) << end % 64) - 1 : 0;
  if (without != kNoBit) may[without / 64] &= ~(Word(1) << without % 64);
  queue_.clear();
  for (std::uint32_t t = 0; (t = next_bit(may.data(), may.size(), t)) != kNoBit; ++t) queue_.push_back(t);
  while (!queue_.empty()) {
    const std::uint32_t t = queue_.back();
    queue_.pop_back();
    for (const std::uint32_t p : net_.firings_[t].put) {
      if (has_bit(marked_.data(), p)) continue;
      set_bit(marked_.data(), p);
      giver_[p] = t;
    }
    for (const std::uint32_t u : net_.winners_[t])
      if (u < end && u != without && !has_bit(may.data(), u) && net_.covers(marked_.data(), u)) {
        set_bit(may.data(), u);
        queue_.push_back(u);
      }
  }
}

// Whether a transition may fire alone where those given, and no others of ranks up to its own, may fire.
bool Stubborn::judge(std::uint32_t t, const std::vector<Word>& may) {
  const std::uint32_t end = net_.rank_end_[t];
  absent_.clear();
  missed_.clear();
  if (!free(t, end, may)) return false;
  std::fill(brought_.begin(), brought_.end(), 0);
  queue_.assign(1, t);
  while (!queue_.empty()) {
    const std::uint32_t from = queue_.back();
    queue_.pop_back();
    for (const std::uint32_t u : net_.winners_[from])
      if (net_.rank_end_[u] < end && !has_bit(brought_.data(), u)) {
        if (!has_bit(may.data(), u)) {
          missed_.push_back(u);
          continue;
        }
        if (!free(u, end, may)) return false;
        set_bit(brought_.data(), u);
        queue_.push_back(u);
      }
  }
  return true;
}

void Stubborn::beside_others(const Word* marking, std::uint32_t t, Places& marked) {
  const std::uint32_t end = net_.rank_end_[t];
  const auto rival = [&](std::uint32_t u) {
    for (const auto* others : {&rivals_[u], &crowders_[u]})
      for (const std::uint32_t v : *others)
        if (v < end && has_bit(here_.data(), v)) return v;
    return kNoBit;
  };
  // What it brings about, up to the first that clashes with one in reach; and, backward, who brought that about.
  std::vector<std::uint32_t> brought{t}, by{kNoBit}, asked;
  std::fill(brought_.begin(), brought_.end(), 0);
  set_bit(brought_.data(), t);
  for (std::size_t at = 0; at < brought.size() && asked.empty(); ++at) {
    if (const std::uint32_t other = rival(brought[at]); other != kNoBit) {
      asked.push_back(other);
      for (std::size_t of = at; by[of] != kNoBit; of = by[of]) asked.push_back(brought[of]);
      break;
    }
    for (const std::uint32_t u : net_.winners_[brought[at]])
      if (net_.rank_end_[u] < end && has_bit(here_.data(), u) && !has_bit(brought_.data(), u)) {
        set_bit(brought_.data(), u);
        brought.push_back(u);
        by.push_back(std::uint32_t(at));
      }
  }
  std::fill(brought_.begin(), brought_.end(), 0);  // from here on what is in reach by the places
  for (const std::uint32_t u : asked) set_bit(brought_.data(), u);
  while (!asked.empty()) {
    const std::uint32_t u = asked.back();
    asked.pop_back();
    for (const std::uint32_t p : net_.firings_[u].need) {
      if (has_bit(marking, p)) {
        marked.push_back(p);
      } else if (!has_bit(brought_.data(), giver_[p])) {
        set_bit(brought_.data(), giver_[p]);
        asked.push_back(giver_[p]);
      }
    }
  }
}

// Whether none of some transitions before one of a later rank clashes with one; notes which would, were they there.
bool Stubborn::free(std::uint32_t t, std::uint32_t end, const std::vector<Word>& may) {
  const auto there = [&](std::uint32_t u) {
    if (u < end && !has_bit(may.data(), u)) absent_.push_back(u);
    return u < end && has_bit(may.data(), u);
  };
  return std::none_of(rivals_[t].begin(), rivals_[t].end(), there) && std::none_of(crowders_[t].begin(), crowders_[t].end(), there);
}

}  // namespace mcpn
