#include "markings/set_evolution.hpp"

#include <algorithm>
#include <deque>
#include <stdexcept>

#include "markings/bits.hpp"

namespace mcpn {

namespace {

constexpr std::size_t kNever = ~std::size_t(0);
constexpr std::size_t kMostFirings = 100'000;  // behind one event
constexpr std::uint32_t kOften = 4;            // of one transition: it is looked ahead from then on
constexpr std::size_t kMostCases = 300;        // in which a transition may not fire alone
constexpr std::size_t kWide = 4;               // so many parts of a function for each level are few

bool by_level(const Touched& a, const Touched& b) {
  return a.level != b.level ? a.level < b.level : a.touch < b.touch;
}

bool holds(const std::vector<std::uint32_t>& places, std::uint32_t p) {
  return std::find(places.begin(), places.end(), p) != places.end();
}

// Partners say the same of their level: it is named once. Whether no level is named in two ways.
bool sort(Relations::Way& way) {
  std::sort(way.begin(), way.end(), by_level);
  const auto same = [](const Touched& a, const Touched& b) { return a.level == b.level && a.touch == b.touch; };
  way.erase(std::unique(way.begin(), way.end(), same), way.end());
  const auto level = [](const Touched& a, const Touched& b) { return a.level == b.level; };
  return std::adjacent_find(way.begin(), way.end(), level) == way.end();
}

std::uint32_t suffix_of(Store& store, const Relations::Way& way) {
  std::uint32_t made = 0;
  for (auto at = way.rbegin(); at != way.rend(); ++at) made = store.suffix(at->level, at->touch, made);
  return made;
}

// Whether two different places, one of some and one of others, are in one unit.
bool meet_in_unit(const Stubborn& stubborn, const std::vector<std::uint32_t>& some, const std::vector<std::uint32_t>& others) {
  return std::any_of(some.begin(), some.end(), [&](std::uint32_t p) {
    return std::any_of(others.begin(), others.end(), [&](std::uint32_t q) { return p != q && stubborn.share_unit(p, q); });
  });
}

}  // namespace

SetEvolution::SetEvolution(const SafeNet& net, const Places& initial, Levels levels, std::size_t few_cases)
    : net_(net), levels_(std::move(levels)), few_cases_(few_cases), stubborn_(net, initial), clashes_(net, levels_, stubborn_),
      steps_(net.firings_.size()), has_won_(net.firings_.size() / 64 + 1) {}

std::optional<SetEvolution::Evolved> SetEvolution::after(Store& store, const std::vector<Start>& starts) {
  begin(store);
  Held at(store, 0), left(store, 0);
  for (const Start& start : starts) {
    Narrowed one(store, start.markings);
    if (!fire(store, one, {start.event, {}})) return std::nullopt;
    at = store.join(at, one.whole());
  }
  fired_.clear();
  const Held begun(store, at);
  if (!run(store, at, left)) return std::nullopt;
  Evolved found{at, begun, {}, {}, ++evolutions_};
  std::deque<Held> kept;
  for (const Start& start : starts) {
    Node of = 0;
    if (left) of = store.meet(undone(store, left, {start.event, {}}), start.markings);
    kept.emplace_back(store, of);
    found.left.push_back(of);
  }
  found.fired = std::move(fired_);
  return found;
}

std::optional<SetEvolution::Table> SetEvolution::function(Store& store, const Start& start, const Evolved& evolved, bool wide) {
  begin(store);
  const std::size_t most = kWide * store.levels + evolved.fired.size() * store.size(evolved.begun) / 4;
  std::optional<Table> found = wide ? function(store, start, evolved, true, std::min(kMostParts, most)) : std::nullopt;
  return found ? found : function(store, start, evolved, false, kMostParts);
}

std::optional<SetEvolution::Table> SetEvolution::function(Store& store, const Start& start, const Evolved& evolved, bool wide, std::size_t most) {
  find(store, evolved, wide, most);
  Behind& behind = behind_[wide];
  if (!behind.whole) return std::nullopt;
  Relations& relations = behind.relations;
  relations.allow(most);
  try {
    const Id begun = relations.then(domain(relations, store, start.markings, wide), relations.way(step(store, start.event).way));
    const Id whole = relations.then(begun, *behind.whole);
    // A table of nothing would say that nothing changes.
    if (whole == Relations::kNever) throw std::invalid_argument("a function of no marking");
    return relations.table(whole);
  } catch (const Relations::Full&) {
    return std::nullopt;
  }
}

// Composes what has fired in an evolution, unless that is done.
void SetEvolution::find(Store& store, const Evolved& evolved, bool wide, std::size_t most) {
  Behind& behind = behind_[wide];
  Relations& relations = behind.relations;
  if (behind.number == evolved.number && relations.size() <= kMostParts) return;
  behind.number = 0;
  behind.whole.reset();
  relations.clear(most);
  try {
    Id whole = domain(relations, store, evolved.begun, wide), some = Relations::kSame;
    // To compose with the whole takes as long for many firings of a few levels as for one: they are composed with each
    // other before, until that has made as many parts as the last time with the whole.
    std::size_t with_whole = relations.size(), since = relations.size();
    for (const Fired& fired : evolved.fired) {
      some = relations.then(some, fires(relations, store, fired, false));
      if (relations.size() - since < with_whole) continue;
      since = relations.size();
      whole = relations.then(whole, some);
      some = Relations::kSame;
      with_whole = relations.size() - since;
      since = relations.size();
    }
    whole = relations.then(whole, some);
    const Table kept = relations.table(whole);  // the parts of what it was composed of are many times as many
    relations.clear(kMostParts);
    behind.whole = whole == Relations::kNever ? whole : relations.from_table(kept, [](Touch touch) { return touch; });
  } catch (const Relations::Full&) {
    relations.clear(kMostParts);
  }
  behind.number = evolved.number;
}

// Leaves markings of a set as they are; if it is wide, all that mark no place which none of the set does. It is of no others.
SetEvolution::Id SetEvolution::domain(Relations& relations, Store& store, Node markings, bool wide) {
  if (!wide) {
    among_.clear();
    return among(relations, store, markings, 0);
  }
  if (markings == 0) return Relations::kNever;
  const std::vector<Word> marked = clashes_.marked_in(store, markings);
  Way way;
  for (std::uint32_t p = 0; p < levels_.size(); ++p)
    if (!has_bit(marked.data(), p)) way.push_back(literal(p, false));
  sort(way);
  return relations.way(way);
}

void SetEvolution::begin(Store& store) {
  if (store_ != &store) {
    store_ = &store;
    std::fill(steps_.begin(), steps_.end(), Step());
    of_place_.assign(store.levels, false);
    for (const auto& [level, reverse] : levels_) of_place_[level] = true;
  }
  won_.clear();
  std::fill(has_won_.begin(), has_won_.end(), 0);
  fired_.clear();
  ahead_.clear();
  times_.assign(net_.firings_.size(), 0);
  enabled_.assign(net_.firings_.size(), Enabled::kUnknown);
  next_look_ = kNever;
}

// Runs markings on until none of them enables anything; notes those from which they cannot all be run so.
bool SetEvolution::run(Store& store, Held& markings, Held& left) {
  const Held begun(store, markings);
  Narrowed at(store, markings);
  while (!won_.empty()) {
    if (fired_.size() > kMostFirings) return false;
    if (store.stop || (store.asked_to_stop && store.asked_to_stop())) throw Interrupted();
    std::uint32_t end = ~std::uint32_t(0);
    for (const std::uint32_t t : won_) end = std::min(end, net_.rank_end_[t]);
    const Went went = fire_first(store, at, end);
    if (went == Went::kUnsafe) return false;
    if (went != Went::kStuck) continue;
    Held stuck(store, 0);
    for (const std::uint32_t t : won_)
      if (net_.rank_end_[t] == end && !step(store, t).never) stuck = store.join(stuck, store.filter(at.whole(), step(store, t).enabled));
    at.become(store.minus(at.whole(), stuck));
    enabled_.assign(net_.firings_.size(), Enabled::kUnknown);
    for (std::size_t i = fired_.size(); i-- > 0;) stuck = undone(store, stuck, fired_[i]);
    left = store.join(left, store.meet(stuck, begun));
  }
  markings = at.whole();
  return true;
}

// Fires a transition of the first rank of those that have won a token: one that may fire alone wherever it is enabled, or
// else where it may. The newest comes first; what another one that is enabled leads to waits, once it is looked ahead.
SetEvolution::Went SetEvolution::fire_first(Store& store, Narrowed& at, std::uint32_t end) {
  if (fired_.size() >= next_look_) see_ahead(store, at.whole());
  const auto forget = [&](std::uint32_t t) {
    std::erase(won_, t);
    has_won_[t / 64] &= ~(Word(1) << t % 64);
  };
  const auto waits = [&](std::uint32_t t) {
    return !ahead_.empty() && std::any_of(won_.begin(), won_.end(), [&](std::uint32_t u) {
      return u != t && net_.rank_end_[u] == end && leads(u, t) && in_some(store, at, u);
    });
  };
  Places crowded;  // of which some markings enable others beside them that they may clash with
  bool any = false;
  for (const bool waiting : {false, true})
    for (const bool always : {true, false}) {
      const Places asked(won_.rbegin(), won_.rend());
      for (const std::uint32_t t : asked) {
        if (net_.rank_end_[t] != end || has_bit(stubborn_.always().data(), t) != always) continue;
        if (!in_some(store, at, t)) {
          forget(t);
          continue;
        }
        any = true;
        if (waits(t) != waiting) continue;
        if (always || never_clashes(store, at, t)) {
          forget(t);
          return fire(store, at, {t, {}}) ? Went::kOn : Went::kUnsafe;
        }
        crowded.push_back(t);
      }
    }
  // In which markings one may fire alone takes longer to say: it is asked where none may in all.
  for (const std::uint32_t t : crowded) {
    std::vector<Way> beside = others(store, at.whole(), t);
    const Held enabled(store, store.filter(at.whole(), step(store, t).enabled));
    not_alone(store, enabled, t, beside);
    const Held where(store, without(store, enabled, beside));
    if (where) return fire(store, at, {t, std::move(beside)}, where) ? Went::kOn : Went::kUnsafe;
  }
  return any ? Went::kStuck : Went::kEnd;
}

// Whether some of the markings enable a transition. What a firing leaves alone is enabled as it was.
bool SetEvolution::in_some(Store& store, Narrowed& at, std::uint32_t t) {
  if (enabled_[t] == Enabled::kUnknown) {
    const Step& asks = step(store, t);
    const bool some = !asks.never && store.meets(at.covering(store.first_level(asks.enabled)), asks.enabled);
    enabled_[t] = some ? Enabled::kSome : Enabled::kNone;
  }
  return enabled_[t] == Enabled::kSome;
}

// Which transitions may lead to which from some markings on. What leads to another one fires before it: so all markings
// that come to a choice by several ways have come there before it is made. Of those that lead to each other, what is enabled
// now comes first. What fires may have ended that, so it is looked at again after twice as many firings.
void SetEvolution::see_ahead(Store& store, Node markings) {
  const std::size_t count = net_.firings_.size();
  std::vector<Word> marked = clashes_.marked_in(store, markings);
  // In reach, if no token is taken.
  Places queue;
  std::vector<bool> in_reach(count);
  const auto reach = [&](const std::vector<std::uint32_t>& some) {
    for (const std::uint32_t u : some)
      if (!in_reach[u] && net_.covers(marked.data(), u)) {
        in_reach[u] = true;
        queue.push_back(u);
      }
  };
  reach(won_);
  std::vector<bool> now(in_reach);
  while (!queue.empty()) {
    const std::uint32_t t = queue.back();
    queue.pop_back();
    for (const std::uint32_t p : net_.firings_[t].put) set_bit(marked.data(), p);
    reach(net_.winners_[t]);
    reach(won_);
  }
  // Whether another one must fire in between, for places of one unit are not marked at a time.
  const auto excludes = [&](std::uint32_t t, std::uint32_t u) {
    return meet_in_unit(stubborn_, net_.firings_[t].put, net_.firings_[u].need);
  };
  // Strongly connected components (Tarjan 1972), each behind those that it leads to.
  struct Visit { std::uint32_t t; std::size_t next; };
  std::vector<std::uint32_t> number, low, whole(count), part(count);
  std::vector<bool> open(count);
  Places stack;
  std::vector<Visit> visits;
  const auto components = [&](std::vector<std::uint32_t>& of, auto follows, auto found) {
    std::uint32_t visited = 0, components_found = 0;
    number.assign(count, 0);
    low.assign(count, 0);
    const auto visit = [&](std::uint32_t t) {
      number[t] = low[t] = ++visited;
      stack.push_back(t);
      open[t] = true;
      visits.push_back({t, 0});
    };
    for (const std::uint32_t first : won_) {
      if (in_reach[first] && !number[first]) visit(first);
      while (!visits.empty()) {
        Visit& at = visits.back();
        const std::uint32_t t = at.t;
        if (at.next < net_.winners_[t].size()) {
          const std::uint32_t u = net_.winners_[t][at.next++];
          if (!in_reach[u] || !follows(t, u) || excludes(t, u)) continue;
          if (!number[u]) visit(u);
          else if (open[u]) low[t] = std::min(low[t], number[u]);
          continue;
        }
        visits.pop_back();
        if (!visits.empty()) low[visits.back().t] = std::min(low[visits.back().t], low[t]);
        if (low[t] != number[t]) continue;
        const auto begin = std::find(stack.rbegin(), stack.rend(), t).base() - 1;
        const Places members(begin, stack.end());
        stack.erase(begin, stack.end());
        for (const std::uint32_t u : members) {
          open[u] = false;
          of[u] = components_found;
        }
        ++components_found;
        found(members);
      }
    }
  };
  bool cyclic = false;
  components(whole, [](std::uint32_t, std::uint32_t) { return true; }, [&](const Places& members) { cyclic |= members.size() > 1; });
  next_look_ = cyclic ? fired_.size() * 2 : kNever;
  const auto follows = [&](std::uint32_t t, std::uint32_t u) { return whole[t] != whole[u] || !now[u]; };
  ahead_words_ = count / 64 + 1;
  ahead_.assign(count * ahead_words_, 0);
  components(part, follows, [&](const Places& members) {
    std::vector<Word> all(ahead_words_);
    for (const std::uint32_t t : members)
      for (const std::uint32_t u : net_.winners_[t]) {
        if (!in_reach[u] || !follows(t, u) || excludes(t, u) || part[u] == part[t]) continue;
        set_bit(all.data(), u);
        for (std::size_t w = 0; w < ahead_words_; ++w) all[w] |= ahead_[u * ahead_words_ + w];
      }
    for (const std::uint32_t t : members) std::copy(all.begin(), all.end(), ahead_.begin() + std::ptrdiff_t(t * ahead_words_));
  });
}

// Fires a transition in all markings that enable it, or in those of them beside which it may fire, if these are given; false
// where that is unsafe in one, or leaves it enabled and it fires again.
bool SetEvolution::fire(Store& store, Narrowed& at, Fired fired, Node where) {
  const std::uint32_t t = fired.t;
  const Step& does = step(store, t);
  if (does.unsafe || (net_.firings_[t].take.empty() && !net_.is_event(t))) return false;
  for (const std::uint32_t crowded : does.crowded)
    if (store.meets(where == kAnything ? at.from(store.first_level(crowded)) : where, crowded)) return false;
  std::uint32_t event = does.fires;
  if (!fired.beside.empty()) {
    Relations one(kMostParts);
    event = one.suffix(store, fires(one, store, fired, false));
  }
  at.become(store.image(at.from(store.first_level(event)), event));
  fired_.push_back(std::move(fired));
  for (const std::vector<std::uint32_t>* touched : {&net_.winners_[t], &net_.losers_[t]})
    for (const std::uint32_t u : *touched) enabled_[u] = Enabled::kUnknown;
  enabled_[t] = Enabled::kUnknown;
  if (++times_[t] == kOften && ahead_.empty()) next_look_ = fired_.size();
  for (const std::uint32_t won : net_.winners_[t]) {
    if (has_bit(has_won_.data(), won)) continue;
    set_bit(has_won_.data(), won);
    won_.push_back(won);
  }
  return true;
}

// What a firing does, or undoes, as a function: markings in which the transition does not fire are left as they are.
SetEvolution::Id SetEvolution::fires(Relations& relations, Store& store, const Fired& fired, bool back) {
  const Step& does = step(store, fired.t);
  Way way = does.way;
  if (back)
    for (Touched& at : way) at.touch = at.touch == Touch::consume ? Touch::produce : at.touch == Touch::produce ? Touch::consume : at.touch;
  Id moved = relations.way(way), same = relations.unless(does.asked);
  for (const Way& condition : fired.beside) {
    const Id not_there = relations.unless(condition);
    moved = back ? relations.then(moved, not_there) : relations.then(not_there, moved);
    same = relations.either(same, relations.then(relations.way(does.asked), relations.way(condition)));
  }
  return relations.either(moved, same);
}

// The markings, reachable or not, of which a firing made some.
Node SetEvolution::undone(Store& store, Node markings, const Fired& fired) {
  Relations one(kMostParts);
  return store.image(markings, one.suffix(store, fires(one, store, fired, true)));
}

Node SetEvolution::without(Store& store, Node markings, const std::vector<Way>& conditions) {
  Held left(store, markings);
  for (const Way& condition : conditions) {
    const Held here(store, store.filter(left, suffix_of(store, condition)));
    left = store.minus(left, here);
  }
  return left;
}

// Fewer conditions than those of others under which a transition may not fire alone in markings that enable it, if there are.
void SetEvolution::not_alone(Store& store, Node enabled, std::uint32_t t, std::vector<Way>& others) {
  std::optional<std::vector<Way>> clashing = this->clashing(store, enabled, t, true);
  if (clashing && (clashing->empty() || without(store, enabled, *clashing))) others = std::move(*clashing);
}

// Whether a transition may fire alone in all of the markings that enable it, as far as that is found. What is known of
// levels that are there is asked first.
bool SetEvolution::never_clashes(Store& store, Narrowed& at, std::uint32_t t) {
  {
    const Node here = at.from(store.first_level(step(store, t).enabled));
    Held left(store, store.filter(here, step(store, t).enabled));
    for (const std::uint32_t condition : step(store, t).alone) {
      if (!left) break;
      if (store.first_level(condition) < at.cut()) continue;
      const Held alone(store, store.filter(left, condition));
      left = store.minus(left, alone);
    }
    if (!left) return true;
  }
  if (others(store, at.whole(), t, 1).empty()) return true;
  const Held enabled(store, store.filter(at.whole(), step(store, t).enabled));
  const std::optional<std::vector<Way>> first = clashing(store, enabled, t, false);
  return first && first->empty();
}

// What the others of its rank ask for that some of the markings enable beside it, but for those that take and put the same.
std::vector<SetEvolution::Way> SetEvolution::others(Store& store, Node markings, std::uint32_t t, std::size_t most) {
  std::vector<Way> asked;
  for (const std::uint32_t u : won_) {
    if (u == t || net_.rank_end_[u] != net_.rank_end_[t] || stubborn_.alike(t, u) || enabled_[u] == Enabled::kNone ||
        step(store, u).never || meet_in_unit(stubborn_, net_.firings_[t].need, net_.firings_[u].need))
      continue;
    Way both = step(store, t).asked;
    both.insert(both.end(), step(store, u).asked.begin(), step(store, u).asked.end());
    if (sort(both) && store.meets(markings, suffix_of(store, both))) asked.push_back(step(store, u).asked);
    if (asked.size() == most) break;
  }
  return asked;
}

// Conditions of some of the markings in which what conflicts with it is in reach; in the others nothing is. A marking in
// which nothing is tells so of all that leave the same places empty, another one of all that have the same tokens.
// All of them, or the first that is found.
std::optional<std::vector<SetEvolution::Way>> SetEvolution::clashing(Store& store, Node enabled, std::uint32_t t, bool all) {
  if (step(store, t).many) return std::nullopt;
  std::vector<std::uint32_t>& known = step(store, t).alone;
  std::vector<std::pair<std::uint32_t, Way>>& beside = step(store, t).beside;
  std::vector<Way> found;
  Held left(store, enabled);
  const auto take = [&](std::uint32_t condition) {
    const Held here(store, store.filter(left, condition));
    left = store.minus(left, here);
    return here != 0;
  };
  for (const std::uint32_t condition : known) take(condition);
  for (const auto& [condition, way] : beside)
    if (take(condition)) {
      found.push_back(way);
      if (!all) return found;
    }
  std::vector<Level> marked;
  std::vector<bool> held(store.levels);
  std::vector<Word> marking(net_.words_);
  Places tokens;
  bool many = false;  // so those left are the ones in which it may not
  while (left) {
    if (!many && known.size() + beside.size() >= few_cases_) {
      left = clashes_.of(store, left, t);
      many = true;
      continue;
    }
    if (beside.size() >= kMostCases) {
      step(store, t).many = true;
      return std::nullopt;
    }
    marked.clear();
    store.pick(left, marked);
    std::fill(held.begin(), held.end(), false);
    for (const Level at : marked) held[at] = true;
    std::fill(marking.begin(), marking.end(), 0);
    for (std::uint32_t p = 0; p < levels_.size(); ++p)
      if (held[levels_[p].first] != levels_[p].second) set_bit(marking.data(), p);
    const std::vector<bool> support = store.support(left);
    Way way;
    const bool alone = stubborn_.alone_from(marking.data(), t, [&](const Places& need, const std::vector<Word>& reached) {
      std::uint32_t best = kNoBit;
      for (const std::uint32_t p : need) {
        if (has_bit(reached.data(), p)) continue;
        best = p;
        if (!levels_[p].second && !support[levels_[p].first]) break;  // in all that are left
      }
      way.push_back(literal(best, false));
      return best;
    });
    if (!alone) {
      tokens.clear();
      stubborn_.beside_others(marking.data(), t, tokens);
      for (const std::uint32_t p : tokens) way.push_back(literal(p, true));
    }
    sort(way);
    const std::uint32_t condition = suffix_of(store, way);
    if (!take(condition)) return std::nullopt;
    if (alone) {
      known.push_back(condition);
    } else {
      beside.emplace_back(condition, way);
      found.push_back(std::move(way));
      if (!all) return found;
    }
  }
  return found;
}

SetEvolution::Step& SetEvolution::step(Store& store, std::uint32_t t) {
  Step& step = steps_[t];
  if (step.known) return step;
  step.known = true;
  const Firing& firing = net_.firings_[t];
  for (const std::uint32_t p : firing.need) {
    step.asked.push_back(literal(p, true));
    const bool taken = holds(firing.take, p) && !holds(firing.put, p);
    step.way.push_back({levels_[p].first, !taken ? literal(p, true).touch : levels_[p].second ? Touch::produce : Touch::consume});
  }
  step.never = !sort(step.asked);
  if (step.never) return step;
  step.enabled = suffix_of(store, step.asked);
  for (const std::uint32_t p : firing.put) {
    if (holds(firing.take, p)) continue;
    step.way.push_back({levels_[p].first, levels_[p].second ? Touch::consume : Touch::produce});
    if (std::any_of(firing.need.begin(), firing.need.end(), [&](std::uint32_t q) { return q != p && stubborn_.share_unit(p, q); })) continue;
    Way crowded = step.asked;
    crowded.push_back(literal(p, true));
    if (sort(crowded)) step.crowded.push_back(suffix_of(store, crowded));
  }
  step.unsafe = firing.overflow || !sort(step.way);
  if (step.unsafe) return step;
  Relations one(kMostParts);
  step.fires = one.suffix(store, one.either(one.way(step.way), one.unless(step.asked)));
  return step;
}

// The function that leaves markings of a set as they are, and is of no others.
SetEvolution::Id SetEvolution::among(Relations& relations, Store& store, Node markings, Level from) {
  if (markings == 0) return Relations::kNever;
  while (from < store.levels && !of_place_[from]) ++from;
  if (from == store.levels) return Relations::kSame;
  const std::uint64_t key = std::uint64_t(markings) << 32 | from;
  if (const auto known = among_.find(key); known != among_.end()) return known->second;
  const bool here = store.level(markings) == from;
  const Id without = among(relations, store, here ? store.lo(markings) : markings, from + 1);
  const Id made = relations.looks(from, without, here ? among(relations, store, store.hi(markings), from + 1) : Relations::kNever);
  among_.emplace(key, made);
  return made;
}

}  // namespace mcpn
