// Saturation (Ciardo, Lüttgen, Siminiscalchi 2001) on zero-suppressed diagrams of 1-safe markings, inside a given
// set where one is given (constrained saturation: Zhao, Ciardo 2009).
//
// Every node is closed under the events that begin at its level or below before it is used above. A level that a
// diagram skips is a place without token: events that begin there by producing into it, or by testing that it is
// unmarked, must still be fired; `Program::wakes` says where such levels are, so that all others are passed over.
#include "diagrams/store.hpp"

#include <algorithm>
#include <array>
#include <span>

namespace mcpn {

namespace {

constexpr std::size_t kMostPrograms = 256;                  // what a tag of the cache can tell apart
constexpr std::uint64_t kMostProgramBytes = 64u << 20;

}  // namespace

void Store::declare(const std::vector<std::uint32_t>& events) {
  if (const auto known = program_index_.find(events); known != program_index_.end()) {
    program_ = known->second;
    return;
  }
  if (programs_.size() == kMostPrograms || (program_bytes_ > kMostProgramBytes && programs_.size() > 1)) {
    for (Line& line : cache_)  // numbers of programs begin anew
      for (Cached& entry : line.ways)
        if (entry.tag >> 28 >= op_saturate) entry = {};
    programs_.clear();
    program_index_.clear();
    program_bytes_ = 0;
  }
  // What an event does where it leaves its first level alone is an event that begins below: it is closed there.
  std::vector<std::uint32_t> ways;
  for (std::uint32_t event : events)
    while (event) {
      std::uint32_t below = 0;
      for (std::uint32_t way = event; way; way = suffixes_[way].more)
        for (std::uint32_t other = suffixes_[way].more; other; other = suffixes_[other].more)
          if (suffixes_[way].touch == Touch::read && suffixes_[other].touch == Touch::zero &&
              suffixes_[way].next == suffixes_[other].next)
            below = suffixes_[way].next;
      for (std::uint32_t way = event; way; way = suffixes_[way].more)
        if (!below || suffixes_[way].touch == Touch::consume || suffixes_[way].touch == Touch::produce)
          ways.push_back(way);
      event = below;
    }
  Program program;
  program.begin.assign(levels + 2, 0);
  for (const std::uint32_t way : ways) ++program.begin[suffixes_[way].level + 2];
  for (Level at = 2; at <= levels + 1; ++at) program.begin[at] += program.begin[at - 1];
  program.events.resize(program.begin[levels + 1]);
  for (const std::uint32_t way : ways) program.events[program.begin[suffixes_[way].level + 1]++] = way;
  program.wakes.assign(levels + 2, levels);
  for (Level at = levels; at-- > 0;) {
    const bool wakes = std::any_of(
        program.events.begin() + program.begin[at], program.events.begin() + program.begin[at + 1],
        [&](std::uint32_t event) {
          return suffixes_[event].touch == Touch::produce || suffixes_[event].touch == Touch::zero;
        });
    program.wakes[at] = wakes ? at : program.wakes[at + 1];
  }
  program_ = std::uint32_t(programs_.size());
  program_index_.emplace(events, program_);
  program_bytes_ += program.bytes() + events.size() * sizeof(events[0]);
  programs_.push_back(std::move(program));
}

Node Store::saturate(Node a, Node within) {
  closed_ = levels;
  if (within == kAnything) return saturate_from(0, a, within);
  const Held start(*this, meet(a, within));
  return saturate_from(0, start, within);
}

// Closes a set, which lies inside the limit, under the events at `from` and below.
Node Store::saturate_from(Level from, Node a, Node within) {
  if (a == 0) return 0;
  const Level at = std::min(level(a), programs_[program_].wakes[from]);
  if (at == levels) return a;
  within = below(within, at);
  Node result;
  if (recall(tag(op_saturate, at, program_), 0, a, within, result)) {
    closed_ = std::min(closed_, at);
    return result;
  }
  const Branches x = split(a, at), w = limits(within, at);
  const Held low(*this, saturate_from(at + 1, x.lo, w.lo));
  const Held high(*this, saturate_from(at + 1, x.hi, w.hi));
  result = close(at, low, high, w);
  closed_ = std::min(closed_, at);
  remember(tag(op_saturate, at, program_), 0, a, within, result);
  if (within != kAnything) remember(tag(op_saturate, at, program_), 0, result, within, result);
  return result;
}

// Fires an event from one of its levels on, and closes what it makes under the events at `from` and below.
Node Store::fire(std::uint32_t event, Level from, Node a, Node within) {
  if (a == 0 || within == 0) return 0;
  if (event == 0) {
    if (within == kAnything) return a;  // children of closed nodes are closed
    const Held inside(*this, meet(a, within));  // closed under another limit, perhaps
    return saturate_from(from, inside, within);
  }
  const Suffix head = suffixes_[event];
  if (level(a) > head.level && !head.more && (head.touch == Touch::consume || head.touch == Touch::read)) return 0;
  const Level at = std::min({level(a), head.level, programs_[program_].wakes[from]});
  within = below(within, at);
  Node result;
  if (recall(tag(op_fire, at, program_), event, a, within, result)) return result;
  const Branches x = split(a, at), w = limits(within, at);
  if (at < head.level) {
    const Held low(*this, fire(event, at + 1, x.lo, w.lo));
    const Held high(*this, fire(event, at + 1, x.hi, w.hi));
    result = close(at, low, high, w);
  } else if (head.more) {
    Held low(*this, 0), high(*this, 0);
    for (std::uint32_t each = event; each; each = suffixes_[each].more) {
      const Suffix way = suffixes_[each];
      const bool from_high = way.touch == Touch::consume || way.touch == Touch::read;
      const bool into_high = way.touch == Touch::produce || way.touch == Touch::read;
      const Held made(*this, fire(way.next, at + 1, from_high ? x.hi : x.lo, into_high ? w.hi : w.lo));
      Held& target = into_high ? high : low;
      target = join(target, made);  // a union of closed sets is closed
    }
    result = close(at, low, high, w);
  } else {
    const bool from_high = head.touch == Touch::consume || head.touch == Touch::read;
    const bool into_high = head.touch == Touch::produce || head.touch == Touch::read;
    const Held made(*this, fire(head.next, at + 1, from_high ? x.hi : x.lo, into_high ? w.hi : w.lo));
    result = into_high ? close(at, 0, made, w) : close(at, made, 0, w);
  }
  remember(tag(op_fire, at, program_), event, a, within, result);
  return result;
}

// A node of two closed children, closed under the events that begin at its level.
Node Store::close(Level at, Node lo, Node hi, Branches within) {
  if (lo == 0 && hi == 0) return 0;
  const Program& program = programs_[program_];
  const std::span events(program.events.data() + program.begin[at], program.begin[at + 1] - program.begin[at]);
  if (events.empty()) return make(at, lo, hi);
  Held low(*this, lo), high(*this, hi);
  // Which version of its source each event was last fired on; few events begin at most levels.
  std::array<std::uint32_t, 16> few{};
  std::vector<std::uint32_t> many(events.size() > few.size() ? events.size() : 0);
  std::uint32_t* fired = many.empty() ? few.data() : many.data();
  std::uint32_t low_version = 1, high_version = 1;
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < events.size(); ++i) {
      const Suffix head = suffixes_[events[i]];
      const bool from_high = head.touch == Touch::consume || head.touch == Touch::read;
      const bool into_high = head.touch == Touch::produce || head.touch == Touch::read;
      const Node source = from_high ? high : low;
      const std::uint32_t version = from_high ? high_version : low_version;
      if (source == 0 || fired[i] == version) continue;
      fired[i] = version;
      const Held made(*this, fire(head.next, at + 1, source, into_high ? within.hi : within.lo));
      Held& target = into_high ? high : low;
      const Node wider = join(target, made);
      if (wider != target) {
        target = wider;
        ++(into_high ? high_version : low_version);
        changed = true;
      }
    }
  }
  return make(at, low, high);
}

}  // namespace mcpn
