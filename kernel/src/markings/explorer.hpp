// Explicit exploration of 1-safe nets: markings as bit sets, breadth first, priorities respected.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "markings/bits.hpp"
#include "pages.hpp"

namespace mcpn {

using State = std::uint32_t;

constexpr std::uint16_t kEvents = 0xFFFF;  // the rank of events; internal transitions have lower ones

// What a transition does to a 1-safe marking. Overflow: firing it is unsafe whatever the marking.
struct Firing {
  std::vector<std::uint32_t> need, take, put;
  std::uint16_t rank = 0;  // with priorities, those of the lowest rank that is enabled may fire
  bool overflow = false;
};

struct Limits {
  std::uint64_t states, bytes;
  std::function<bool(std::uint64_t states, std::uint64_t edges)> go_on;  // asked now and then
};

// Markings in the order in which they were found, and the firings between them if they were asked for.
struct Exploration {
  std::uint64_t words = 1, edges = 0, dead = 0, stable = 0, most_tokens = 0;
  std::uint64_t transient = 0, parted = 0;  // of a proof: transient markings kept, and those left by several ways
  std::array<std::uint64_t, 5> decided{};   // of a proof: edges by the last Means that was needed (stubborn.hpp)
  std::vector<std::uint64_t> bounds;   // most tokens by place, of nets whose places may hold several
  Table<Word> markings;                // words for each state
  std::vector<State> parents;          // the state that each was found from; its own number for the first
  std::vector<std::uint32_t> via;      // by which transition
  std::vector<std::uint64_t> offsets;  // edges of state s: offsets[s] to offsets[s + 1]
  Appended<State> targets;
  std::vector<std::uint32_t> labels;   // of 1-safe nets by SafeNet::labels
  struct Trouble {
    State state;
    std::vector<std::uint32_t> firings;  // from that state on
    const char* kind;                    // what the last of them is: see settling.hpp
  };
  std::optional<Trouble> trouble;  // exploration ended there

  std::uint64_t states() const { return parents.size(); }
  std::uint64_t bytes() const;
};

class Explorer;
class StateTable;

enum class Edges { kNone, kAll, kIfRoom };  // kept or not; all, unless memory is wanted for the markings

class SafeNet {
 public:
  // Firings come in the order of their ranks, where there are priorities.
  SafeNet(std::uint32_t places, std::vector<Firing> firings, bool priorities);

  std::uint32_t places() const { return places_; }
  std::uint32_t words() const { return words_; }
  std::size_t transitions() const { return firings_.size(); }
  bool priorities() const { return priorities_; }
  bool is_event(std::uint32_t t) const { return t < firings_.size() && firings_[t].rank == kEvents; }

  // Every reachable marking. The initial one is given by its marked places.
  Exploration explore(const std::vector<std::uint32_t>& initial, bool edges, const Limits& limits) const;

  // Sets of places that together hold one token at most from a marking on: see units.cpp.
  std::vector<std::vector<std::uint32_t>> units(const std::vector<std::uint32_t>& initial) const;

  // The transitions on the edges of some markings, given as rows of words, in the order in which exploration lists them.
  std::vector<std::uint32_t> labels(const Word* markings, std::size_t states) const;

 private:
  friend class Explorer;
  friend class Passages;
  friend class SetClashes;
  friend class SetEvolution;
  friend class Settling;
  friend class Stubborn;
  friend class Reads;
  struct Part { std::uint32_t word; Word need, take, put; };  // of a transition in one word of a marking
  struct Level {                                               // internal transitions, or events
    std::vector<std::vector<std::uint32_t>> keyed;             // by a place that they need
    std::vector<std::uint32_t> always;                         // those that need none
  };

  bool covers(const Word* marking, std::uint32_t t) const {
    for (std::uint32_t i = begin_[t]; i < begin_[t + 1]; ++i)
      if ((marking[parts_[i].word] & parts_[i].need) != parts_[i].need) return false;
    return true;
  }
  std::uint32_t rank_begin(std::uint32_t t) const;  // the first transition of its rank
  bool fire(Word* marking, std::uint32_t t) const;  // false: unsafe
  bool collect(const Word* marking, const Level& level, std::vector<Word>& enabled) const;
  bool collect_internal(const Word* marking, std::vector<Word>& enabled) const;
  std::vector<Word> marking_of(const std::vector<std::uint32_t>& places) const;

  std::uint32_t places_, words_;
  std::vector<Firing> firings_;
  bool priorities_;
  std::vector<std::uint32_t> begin_;
  std::vector<Part> parts_;
  Level internal_, events_;  // without priorities all are internal
  std::vector<std::uint32_t> rank_end_;  // by transition, the first one of a later rank
  std::vector<std::vector<std::uint32_t>> winners_, losers_;  // with priorities, internal ones that each may enable, disable
};

// An exploration under way, which may stop after so many firings and go on later.
class Explorer {
 public:
  Explorer(const SafeNet& net, const std::vector<std::uint32_t>& initial, Edges edges, Limits limits);
  ~Explorer();
  Explorer(const Explorer&) = delete;
  Explorer& operator=(const Explorer&) = delete;

  // Whether it came to its end; 0: any number of firings.
  bool run(std::uint64_t most_firings = 0);
  Exploration take() { return std::move(found_); }
  const Exploration& found() const { return found_; }
  State explored() const { return next_; }  // states whose firings are all known
  std::uint64_t bytes() const;

 private:
  struct Fired { std::uint64_t hashed; State state; std::uint32_t transition; };

  void prepare_enabling();
  bool look_up_enabled(const Word* marking);
  template <unsigned kWords> void spread();
  void number();

  const SafeNet& net_;
  Edges edges_;
  const Limits limits_;
  Exploration found_;
  std::unique_ptr<StateTable> table_;
  State next_ = 0;  // the first state whose firings are still to be looked at
  std::vector<Word> begin_, enabled_, after_;
  std::vector<Word> enabling_;  // by byte of a marking and its value, transitions that need no more of that byte
  std::vector<Fired> fired_;         // of the batch, and by state of the batch how many edges there are at its end
  std::vector<std::uint64_t> ends_;
};

// The one stable end of each state of a graph given by rows of targets; a stable state is its own, and -1 says that
// internal evolution need not end. Returns a state whose successors have two ends, where it stops, or -1.
std::int64_t stable_ends(const std::int64_t* offsets, const std::int64_t* targets, const bool* transient,
                         std::size_t states, std::int64_t* ends);

}  // namespace mcpn
