// What events make of sets of stable markings, all at once: internal transitions fire one after the other, each in all
// markings behind these events that enable it, and their images take the place of these.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "diagrams/relation.hpp"
#include "diagrams/store.hpp"
#include "markings/explorer.hpp"
#include "markings/narrowed.hpp"
#include "markings/set_clashes.hpp"
#include "markings/stubborn.hpp"

namespace mcpn {

// A transition of the first rank fires in the markings in which it may fire alone; the others wait until another one may.
// So enough orders are tried of each, and each has one end (papers/mcpn.md, Proposition 5).
class SetEvolution {
 public:
  using Places = std::vector<std::uint32_t>;
  using Levels = SetClashes::Levels;
  using Table = std::vector<std::uint32_t>;

  // Few cases tell where a transition may fire alone, before it is asked of all markings at once.
  SetEvolution(const SafeNet& net, const Places& initial, Levels levels, std::size_t few_cases);

  using Way = Relations::Way;

  // A firing in all markings that enable a transition, but for those of some conditions.
  struct Fired {
    std::uint32_t t;
    std::vector<Way> beside;
  };
  // An event, and some stable markings that enable it.
  struct Start {
    Node markings;
    std::uint32_t event;
  };
  // What events make of markings: the stable ones behind them; by event those that are left, for in some marking behind them
  // no transition may fire alone; and what has fired behind the events, one after the other.
  struct Evolved {
    Node after, begun;       // begun: the markings that the events made
    std::vector<Node> left;
    std::vector<Fired> fired;
    std::uint64_t number;    // which evolution it was
  };
  // Nothing where a firing is unsafe, or where there is no end. Evolution is the same behind whichever event it is, so it is
  // run of all at once.
  std::optional<Evolved> after(Store& store, const std::vector<Start>& starts);
  // What an event and the evolution behind it make of some markings from which it was run: a table of Relations that leaves
  // levels of no place alone; nothing where it has too many parts. It is of no other markings, unless it may be wide, for it
  // is asked of no others: then it is of all that mark no more places than these together, if that has few parts.
  std::optional<Table> function(Store& store, const Start& start, const Evolved& evolved, bool wide);

 private:
  using Id = Relations::Id;
  // Of a transition, as suffixes of a store: that it is enabled; its firing, and nothing where it is not enabled.
  struct Step {
    Way asked, way;
    std::uint32_t enabled = 0, fires = 0;
    std::vector<std::uint32_t> crowded;  // that it is enabled, and that a place that it puts into is marked
    bool known = false, never = false, unsafe = false;
    // Conditions under which it may fire alone, and under which it may not; the latter also as suffixes.
    std::vector<std::uint32_t> alone;
    std::vector<std::pair<std::uint32_t, Way>> beside;
    bool many = false;  // so many that they were not all found
  };
  // How it goes on: a transition has fired; none is enabled; some are, but none may fire alone; a firing is unsafe.
  enum class Went { kOn, kEnd, kStuck, kUnsafe };

  enum class Enabled : std::uint8_t { kUnknown, kNone, kSome };

  bool run(Store& store, Held& markings, Held& left);
  std::optional<Table> function(Store& store, const Start& start, const Evolved& evolved, bool wide, std::size_t most);
  Went fire_first(Store& store, Narrowed& at, std::uint32_t end);
  bool in_some(Store& store, Narrowed& at, std::uint32_t t);
  void see_ahead(Store& store, Node markings);
  bool leads(std::uint32_t t, std::uint32_t u) const {
    return !ahead_.empty() && has_bit(ahead_.data() + t * ahead_words_, u);
  }
  bool fire(Store& store, Narrowed& at, Fired fired, Node where = kAnything);
  void not_alone(Store& store, Node enabled, std::uint32_t t, std::vector<Way>& others);
  std::vector<Way> others(Store& store, Node markings, std::uint32_t t, std::size_t most = ~std::size_t(0));
  bool never_clashes(Store& store, Narrowed& at, std::uint32_t t);
  std::optional<std::vector<Way>> clashing(Store& store, Node enabled, std::uint32_t t, bool all);
  Node without(Store& store, Node markings, const std::vector<Way>& conditions);
  // The function of an evolution, of all markings that its events made; kept for its other events.
  struct Behind {
    std::uint64_t number = 0;
    std::optional<Id> whole;  // nothing where it has too many parts
    Relations relations{kMostParts};
  };
  static constexpr std::size_t kMostParts = 2'000'000;
  void find(Store& store, const Evolved& evolved, bool wide, std::size_t most);
  Id domain(Relations& relations, Store& store, Node markings, bool wide);
  Id fires(Relations& relations, Store& store, const Fired& fired, bool back);
  Node undone(Store& store, Node markings, const Fired& fired);
  Step& step(Store& store, std::uint32_t t);
  void begin(Store& store);
  Id among(Relations& relations, Store& store, Node markings, Level from);
  Touched literal(std::uint32_t place, bool marked) const {
    return {levels_[place].first, marked != levels_[place].second ? Touch::read : Touch::zero};
  }

  const SafeNet& net_;
  const Levels levels_;
  const std::size_t few_cases_;
  Stubborn stubborn_;
  SetClashes clashes_;
  Behind behind_[2];                  // by whether it is wide
  const Store* store_ = nullptr;      // whose suffixes those of steps are
  std::vector<Step> steps_;
  std::vector<bool> of_place_;        // levels
  std::vector<std::uint32_t> won_;    // that have won a token, and may be enabled; the newest last
  std::vector<Word> has_won_;
  std::vector<Enabled> enabled_;      // by transition, whether some of the markings enable it
  std::vector<Word> ahead_;           // by transition, those that it may lead to
  std::size_t ahead_words_ = 0, next_look_ = 0;  // after so many firings it is looked ahead
  std::vector<std::uint32_t> times_;  // by transition, how often it has fired
  std::vector<Fired> fired_;          // behind the events
  std::uint64_t evolutions_ = 0;
  std::unordered_map<std::uint64_t, Id> among_;
};

}  // namespace mcpn
