// A second checker of diagrams.json, written from docs/certificates.md alone: c++ -O2 -std=c++17 diagram_checker.cpp -o diagram_checker.
//
// diagram_checker FILE [--max-nodes N] [--seconds S] prints "VERDICT KEY" for each claim that sets of markings prove; VERDICT is proved,
// refuted or not checked. It ends with 0 if all are proved, 1 if some is refuted, else 2. What is malformed is told in one sentence, with
// exit code 2.
#include "certificate.hpp"

#include <optional>

using Node = std::uint32_t;  // 0 is the empty family, 1 holds the empty set alone

// ---- families of sets of levels

// What becomes of one level: which sets pass, and how they leave.
struct Change {
  enum Leaves { as_it_came, out, in, either };
  std::uint32_t level;
  int needed;  // 0: sets without it, 1: sets with it, -1: all
  Leaves leaves;
};
using Changes = std::vector<Change>;  // in the order of levels

class Families {
 public:
  Families(std::size_t most, const Clock& clock) : most_(most), clock_(clock) { rows_.resize(2, {kNone, 0, 0}); }

  Node node(std::uint32_t level, Node low, Node high) {
    if (!high) return low;
    const auto [found, fresh] = numbers_.emplace(Key{level, low, high}, Node(rows_.size()));
    if (fresh) {
      if (rows_.size() >= most_) throw Limit("more than " + std::to_string(most_) + " nodes");
      if (rows_.size() % 1024 == 0) clock_.look(0);
      rows_.push_back({level, low, high});
    }
    return found->second;
  }
  Node both(Node a, Node b) { return combined(kBoth, a, b); }
  Node any(Node a, Node b) { return combined(kAny, a, b); }
  Node less(Node a, Node b) { return combined(kLess, a, b); }
  bool within(Node a, Node b) { return less(a, b) == 0; }
  Node changed(Node of, const Changes& changes) {
    std::map<std::pair<Node, std::size_t>, Node> known;
    return changed(of, changes, 0, known);
  }
  // Those of a set without, or with a level, which is dropped.
  Node part(Node of, std::uint32_t level, bool with) { return changed(of, {{level, with ? 1 : 0, Change::out}}); }
  // Of pairs the first ones, with levels halved.
  Node firsts(Node pairs) {
    std::map<Node, Node> known;
    return firsts(pairs, known);
  }
  // Whether all pairs are of equals.
  bool equals(Node pairs) {
    std::map<Node, bool> known;
    return equals(pairs, known);
  }

 private:
  struct Row { std::uint32_t level; Node low, high; };
  using Key = std::array<std::uint32_t, 3>;
  struct Hash {
    std::size_t operator()(const Key& key) const {
      std::uint64_t hash = 0;
      for (const std::uint32_t part : key) hash = (hash ^ part) * 0x9E3779B97F4A7C15u, hash ^= hash >> 29;
      return std::size_t(hash);
    }
  };
  static constexpr std::uint32_t kNone = ~0u;
  enum Operation : std::uint32_t { kBoth, kAny, kLess };

  Node combined(Operation how, Node a, Node b) {
    if (!a) return how == kAny ? b : 0;
    if (!b) return how == kBoth ? 0 : a;
    if (a == b) return how == kLess ? 0 : a;
    const Key key{how, a, b};
    if (const auto found = combined_.find(key); found != combined_.end()) return found->second;
    if (combined_.size() % 4096 == 0) clock_.look(0);
    const Row one = rows_[a], other = rows_[b];
    Node made;
    if (one.level < other.level) {
      const Node low = combined(how, one.low, b);
      made = how == kBoth ? low : node(one.level, low, one.high);
    } else if (one.level > other.level) {
      const Node low = combined(how, a, other.low);
      made = how == kAny ? node(other.level, low, other.high) : low;
    } else {
      const Node low = combined(how, one.low, other.low), high = combined(how, one.high, other.high);
      made = node(one.level, low, high);
    }
    combined_.emplace(key, made);
    return made;
  }
  Node changed(Node of, const Changes& changes, std::size_t at, std::map<std::pair<Node, std::size_t>, Node>& known) {
    if (!of || at == changes.size()) return of;
    const auto key = std::make_pair(of, at);
    if (const auto found = known.find(key); found != known.end()) return found->second;
    const Row row = rows_[of];
    const Change& change = changes[at];
    Node made;
    if (row.level < change.level) {
      const Node low = changed(row.low, changes, at, known), high = changed(row.high, changes, at, known);
      made = node(row.level, low, high);
    } else {
      const bool here = row.level == change.level;
      const Node low = change.needed == 1 ? 0 : changed(here ? row.low : of, changes, at + 1, known);
      const Node high = change.needed == 0 || !here ? 0 : changed(row.high, changes, at + 1, known);
      switch (change.leaves) {
        case Change::as_it_came: made = node(change.level, low, high); break;
        case Change::out: made = any(low, high); break;
        case Change::in: made = node(change.level, 0, any(low, high)); break;
        default: { const Node all = any(low, high); made = node(change.level, all, all); }
      }
    }
    known.emplace(key, made);
    return made;
  }
  Node firsts(Node of, std::map<Node, Node>& known) {
    if (of < 2) return of;
    if (const auto found = known.find(of); found != known.end()) return found->second;
    const Row row = rows_[of];
    const Node low = firsts(row.low, known), high = firsts(row.high, known);
    const Node made = row.level % 2 ? any(low, high) : node(row.level / 2, low, high);
    known.emplace(of, made);
    return made;
  }
  bool equals(Node of, std::map<Node, bool>& known) {
    if (of < 2) return true;
    if (const auto found = known.find(of); found != known.end()) return found->second;
    const Row row = rows_[of], second = rows_[row.high];
    const bool made = row.level % 2 == 0 && second.level == row.level + 1 && second.low == 0 && equals(row.low, known) && equals(second.high, known);
    known.emplace(of, made);
    return made;
  }

  std::size_t most_;
  const Clock& clock_;
  std::vector<Row> rows_;
  std::unordered_map<Key, Node, Hash> numbers_, combined_;
};

// ---- what the entry holds

struct Partner { Int place, of; };

struct Diagrams {
  Numbers order, weights;
  std::vector<Partner> partners;
  std::vector<Node> nodes, pairs;  // by their number in the entry
  std::set<Int> again;
  Node reached = 0, ends = 0;
  std::vector<Node> layers;
};

Node node_of(const Json& of, const std::vector<Node>& nodes) {
  require(whole(of) >= 0 && whole(of) < Int(nodes.size()), "no such node");
  return nodes[std::size_t(of.value)];
}
std::vector<Node> layers_of(const Json& of, const std::vector<Node>& nodes) {
  std::vector<Node> found;
  for (const Json& each : list(of)) found.push_back(node_of(each, nodes));
  return found;
}

std::vector<Node> nodes_of(const Json& of, std::size_t levels, Families& families) {
  std::vector<Node> found{0, 1};
  std::vector<Int> level{Int(levels), Int(levels)};
  for (const Json& each : list(of)) {
    const Numbers row = numbers(each);
    require(row.size() == 3 && row[0] >= 0 && row[0] < Int(levels), "a node of no level");
    for (const Int child : {row[1], row[2]})
      require(child >= 0 && child < Int(found.size()) && level[std::size_t(child)] > row[0], "a node out of order");
    require(row[2] != 0, "a node with nothing above");
    found.push_back(families.node(std::uint32_t(row[0]), found[std::size_t(row[1])], found[std::size_t(row[2])]));
    level.push_back(row[0]);
  }
  return found;
}

Diagrams diagrams_of(const Json& of, const Net& net, Families& families) {
  Diagrams made;
  const Int places = Int(net.places.size());
  made.order = numbers(of.at("order"));
  made.weights = numbers(of.at("weights"));
  std::set<Int> once;
  for (const Int place : made.order) require(place >= 0 && place < places && once.insert(place).second, "a place twice, or none");
  const std::set<Int> ordered = once;
  for (const Json& each : list(of.at("partners"))) {
    const Numbers pair = numbers(each);
    require(pair.size() == 2 && pair[0] >= 0 && pair[0] < places && ordered.count(pair[1]) > 0 && once.insert(pair[0]).second, "partners that are none");
    made.partners.push_back({pair[0], pair[1]});
  }
  require(Int(once.size()) == places, "a place that nothing says");
  for (const Int t : numbers(of.at("again"))) {
    require(t >= 0 && t < Int(net.transitions.size()), "no such transition");
    made.again.insert(t);
  }
  made.nodes = nodes_of(of.at("nodes"), made.order.size(), families);
  made.pairs = nodes_of(of.at("pairs"), 2 * made.order.size(), families);
  made.reached = node_of(of.at("reached"), made.nodes);
  made.layers = layers_of(of.at("layers"), made.nodes);
  made.ends = node_of(of.at("ends"), made.pairs);
  return made;
}

// ---- the net on sets of markings

using Marked = std::vector<bool>;  // by place
const std::set<std::string> kEnds{"success", "failure", "abort"};

class Markings {
 public:
  Markings(const Net& net, const Diagrams& given, Families& families) : net_(net), given_(given), families_(families), says_(net.places.size()) {
    for (std::size_t l = 0; l < given.order.size(); ++l) says_[std::size_t(given.order[l])] = {std::uint32_t(l), true};
    for (const Partner& each : given.partners) says_[std::size_t(each.place)] = {says_[std::size_t(each.of)].level, false};
    std::map<Int, std::vector<std::size_t>> by_rank;
    for (std::size_t t = 0; t < net.transitions.size(); ++t) {
      if (net.transitions[t].internal()) by_rank[net.transitions[t].rank].push_back(t);
      else events.push_back(t);
    }
    for (auto& [_, all] : by_rank) ranks.push_back(std::move(all));
    for (std::size_t t = 0; t < net.transitions.size(); ++t) covered_.push_back(covering(net.transitions[t]));
  }

  std::vector<std::vector<std::size_t>> ranks;
  std::vector<std::size_t> events;

  bool partners_are_right() const {
    for (const Partner& each : given_.partners) {
      if (net_.places[std::size_t(each.place)].initial == net_.places[std::size_t(each.of)].initial) return false;
      for (const Transition& t : net_.transitions) if (gain(t, each.place) != -gain(t, each.of)) return false;
    }
    return true;
  }
  Node initial() const {
    Marked all;
    for (const Place& place : net_.places) all.push_back(place.initial);
    return single(all);
  }
  Node single(const Marked& marked) const {
    Node made = 1;
    for (std::size_t l = given_.order.size(); l-- > 0;)
      if (marked[std::size_t(given_.order[l])]) made = families_.node(std::uint32_t(l), 0, made);
    return made;
  }
  bool holds(Node set, const Marked& marked) const { return families_.within(single(marked), set); }

  // Those of a set in which the tokens of a transition are; of pairs, in the first ones.
  Node covered(Node set, std::size_t t, bool pairs = false) const { return covered_[t] ? families_.changed(set, doubled(*covered_[t], pairs)) : 0; }
  // The markings after a transition, of a set of those in which its tokens are.
  Node fired(Node set, std::size_t t, bool pairs = false) const { return families_.changed(set, doubled(firing(t, false), pairs)); }
  // The markings in which its tokens are and that it leads into a set.
  Node before(Node set, std::size_t t) const { return covered_[t] ? families_.changed(set, firing(t, true)) : 0; }
  // Those of a set that mark a place.
  Node marking(Node set, std::size_t place) const { return families_.changed(set, {{says_[place].level, says_[place].is ? 1 : 0, Change::as_it_came}}); }

  // Calls with each internal transition and those of a set in which it may fire; gives those that are stable.
  template <class Then> Node internally(Node set, Then then, bool pairs = false) const {
    for (const auto& rank : ranks) {
      Node taken = 0;
      for (const std::size_t t : rank) {
        const Node here = covered(set, t, pairs);
        if (here) then(t, here);
        taken = families_.any(taken, here);
      }
      set = families_.less(set, taken);
    }
    return set;
  }
  Node ending(Node set, const std::set<std::string>& roles) const {
    Node found = 0;
    for (std::size_t p = 0; p < net_.places.size(); ++p)
      if (is_end(p, roles)) found = families_.any(found, marking(set, p));
    return found;
  }
  // The level and the side of it that say whether a place is marked.
  std::pair<std::uint32_t, bool> side(std::size_t place) const { return {says_[place].level, says_[place].is}; }
  std::size_t levels() const { return given_.order.size(); }
  bool is_end(std::size_t place, const std::set<std::string>& roles) const {
    const auto& all = net_.places[place].roles;
    return std::any_of(all.begin(), all.end(), [&](const Role& role) { return roles.count(role.first) > 0; });
  }

 private:
  struct Said { std::uint32_t level = 0; bool is = true; };

  static bool has(const Numbers& all, Int place) { return std::find(all.begin(), all.end(), place) != all.end(); }
  static int gain(const Transition& t, Int place) { return int(has(t.produce, place)) - int(has(t.consume, place)); }
  // None where its tokens are never all there, for one place is marked exactly where another is not.
  std::optional<Changes> covering(const Transition& t) const {
    std::map<std::uint32_t, int> needed;
    for (const Numbers* side : {&t.consume, &t.read})
      for (const Int place : *side) {
        const Said& said = says_[std::size_t(place)];
        const auto [found, fresh] = needed.emplace(said.level, said.is ? 1 : 0);
        if (!fresh && found->second != int(said.is)) return std::nullopt;
      }
    Changes made;
    for (const auto& [level, value] : needed) made.push_back({level, value, Change::as_it_came});
    return made;
  }
  Changes firing(std::size_t t, bool back) const {
    std::map<std::uint32_t, Change> all;
    for (const Change& each : *covered_[t]) all.emplace(each.level, each);
    const Transition& of = net_.transitions[t];
    for (const Numbers* side : {&of.consume, &of.produce})  // what is produced is there, even if it was consumed
      for (const Int place : *side) {
        const Said& said = says_[std::size_t(place)];
        if (!said.is) continue;  // its partner changes in the opposite way
        Change& change = all.emplace(said.level, Change{said.level, -1, Change::as_it_came}).first->second;
        change.leaves = side == &of.produce ? Change::in : Change::out;
      }
    Changes made;
    for (auto [_, change] : all) {
      if (back && change.leaves != Change::as_it_came) {
        const int after = change.leaves == Change::in;
        change.leaves = change.needed < 0 ? Change::either : change.needed ? Change::in : Change::out;
        change.needed = after;
      }
      made.push_back(change);
    }
    return made;
  }
  static Changes doubled(Changes of, bool pairs) {
    if (pairs) for (Change& each : of) each.level *= 2;
    return of;
  }

  const Net& net_;
  const Diagrams& given_;
  Families& families_;
  std::vector<Said> says_;
  std::vector<std::optional<Changes>> covered_;
};

// ---- claims

class Claims {
 public:
  Claims(const Net& net, const Diagrams& given, const Markings& markings, Families& families) : net_(net), given_(given), markings_(markings), families_(families) {}

  bool is_reached() {
    return once(reached_, [&] {
      const Node reached = given_.reached;
      return markings_.partners_are_right() && families_.within(markings_.initial(), reached) && is_safe(reached) && is_closed(reached, true);
    });
  }
  bool proved(const std::string& kind, bool holds, const Json& statement, const Json& evidence) {
    if (!is_reached()) return false;
    if (kind == "cut_sets") return are_cut_sets(holds, statement, evidence);
    if (kind == "safe") return holds;
    if (kind == "confluent") return holds && is_confluent();
    if (kind == "can_always_go_on") return holds ? goes_on() : is_stuck(after(evidence.at("run")));
    if (kind == "can_succeed") return ends(holds, evidence, "success");
    if (kind == "can_fail") return ends(holds, evidence, "failure");
    if (kind == "can_be_aborted") return ends(holds, evidence, "abort");
    const std::set<std::string> roles = kind == "can_always_end" ? kEnds : std::set<std::string>{"success", "abort"};
    if (holds) return always(layers_of(evidence.at("layers"), given_.nodes), roles);
    const Node closed = node_of(evidence.at("closed"), given_.nodes);
    const auto marking = after(evidence.at("run"));
    return marking && markings_.holds(closed, *marking) && is_closed(closed, true) && markings_.ending(closed, roles) == 0;
  }

 private:
  template <class Is> static bool once(std::optional<bool>& known, Is is) {
    if (!known) known = is();
    return *known;
  }
  // Calls with each transition and those of a set in which it may fire.
  template <class Then> void firing(Node set, Then then) const {
    const Node stable = markings_.internally(set, then);
    for (const std::size_t t : markings_.events) if (const Node here = markings_.covered(stable, t)) then(t, here);
  }
  bool is_safe(Node set) const {
    bool safe = true;
    firing(set, [&](std::size_t t, Node here) {
      const Transition& of = net_.transitions[t];
      for (const Int place : of.produce)
        if (std::find(of.consume.begin(), of.consume.end(), place) == of.consume.end()) safe = safe && markings_.marking(here, std::size_t(place)) == 0;
    });
    return safe;
  }
  bool is_closed(Node set, bool with_events) const {
    bool closed = true;
    const auto leads = [&](std::size_t t, Node here) { closed = closed && families_.within(markings_.fired(here, t), set); };
    if (with_events) firing(set, leads);
    else markings_.internally(set, leads);
    return closed;
  }
  bool runs_end() {
    return once(ends_, [&] {
      if (given_.weights.size() != net_.places.size()) return false;
      bool again = false;
      for (std::size_t t = 0; t < net_.transitions.size(); ++t) {
        const Transition& of = net_.transitions[t];
        if (!of.internal()) continue;
        if (given_.again.count(Int(t))) { again = true; continue; }
        Wide more = 0;
        for (const Int place : of.produce) more += given_.weights[std::size_t(place)];
        for (const Int place : of.consume) more -= given_.weights[std::size_t(place)];
        if (more >= 0) return false;
      }
      bool fine = true;
      Node before = 0;
      for (const Node layer : given_.layers) {
        markings_.internally(layer, [&](std::size_t t, Node here) {
          fine = fine && families_.within(markings_.fired(here, t), given_.again.count(Int(t)) ? before : layer);
        });
        before = layer;
      }
      if (again && given_.layers.empty()) return false;
      return fine && (given_.layers.empty() || families_.within(given_.reached, before));
    });
  }
  bool is_confluent() {
    if (!runs_end() || !families_.within(given_.reached, families_.firsts(given_.ends))) return false;
    bool fine = true;
    const Node stable = markings_.internally(given_.ends, [&](std::size_t t, Node here) { fine = fine && families_.within(markings_.fired(here, t, true), given_.ends); }, true);
    return fine && families_.equals(stable);
  }
  bool goes_on() const {
    Node left = markings_.internally(given_.reached, [](std::size_t, Node) {});
    left = families_.less(left, markings_.ending(left, kEnds));
    for (const std::size_t t : markings_.events) left = families_.less(left, markings_.covered(left, t));
    return left == 0;
  }
  bool ends(bool holds, const Json& evidence, const std::string& role) const {
    if (!holds) return markings_.ending(given_.reached, {role}) == 0;
    const auto marking = after(evidence.at("run"));
    return marking && has_ended(*marking, {role});
  }
  bool always(const std::vector<Node>& layers, const std::set<std::string>& roles) {
    return lead_to(layers, roles, markings_.events) && families_.within(given_.reached, layers.empty() ? 0 : layers.back());
  }
  bool lead_to(const std::vector<Node>& layers, const std::set<std::string>& roles, const std::vector<std::size_t>& events) {
    if (!runs_end()) return false;
    Node before = 0;
    for (const Node layer : layers) {
      if (!is_closed(layer, false)) return false;
      Node left = markings_.internally(layer, [](std::size_t, Node) {});
      left = families_.less(families_.less(left, markings_.ending(left, roles)), before);
      for (const std::size_t t : events) left = families_.less(left, markings_.before(before, t));
      if (left) return false;
      before = layer;
    }
    return true;
  }

  // ---- cut sets

  bool repairs(std::size_t t, const std::set<std::string>& of) const {
    const Texts& event = net_.transitions[t].event;
    return event.size() > 1 && event[0] == "repaired" && of.count(event[1]) > 0;
  }
  // By element the place that says that it is out of service; none where this is no list of all, or they share places.
  std::optional<std::map<std::string, std::size_t>> out_of_service(const Texts& names) const {
    std::map<std::string, std::size_t> found;
    std::set<std::uint32_t> levels;
    for (std::size_t p = 0; p < net_.places.size(); ++p)
      for (const Role& role : net_.places[p].roles)
        if (role.first == "oos" && (!found.emplace(role.second, p).second || !levels.insert(markings_.side(p).first).second)) return std::nullopt;
    const std::set<std::string> once(names.begin(), names.end());
    if (once.size() != names.size() || once.size() != found.size()) return std::nullopt;
    for (const std::string& name : names) if (!found.count(name)) return std::nullopt;
    return found;
  }
  bool is_closed_but(Node set, const std::set<std::string>& repaired) const {
    bool closed = true;
    firing(set, [&](std::size_t t, Node here) { closed = closed && (repairs(t, repaired) || families_.within(markings_.fired(here, t), set)); });
    return closed;
  }
  Node settled(Node set, const std::set<std::size_t>& may) const {
    for (Node all = set;;) {
      Node more = all;
      const Node stable = markings_.internally(all, [&](std::size_t t, Node here) { if (may.count(t)) more = families_.any(more, markings_.fired(here, t)); });
      if (more == all) return stable;
      all = more;
    }
  }
  // The stable markings that are reached before the start, by what takes nothing from a place with the role begin.
  Node begun() const {
    std::set<std::size_t> may;
    for (std::size_t t = 0; t < net_.transitions.size(); ++t) {
      const Numbers& taken = net_.transitions[t].consume;
      if (std::none_of(taken.begin(), taken.end(), [&](Int place) { return markings_.is_end(std::size_t(place), {"begin"}); })) may.insert(t);
    }
    for (Node found = settled(markings_.initial(), may);;) {
      Node more = found;
      for (const std::size_t t : markings_.events)
        if (may.count(t)) more = families_.any(more, settled(markings_.fired(markings_.covered(more, t), t), may));
      if (more == found) return markings_.ending(found, {"begin"});
      found = more;
    }
  }
  bool are_cut_sets(bool holds, const Json& statement, const Json& evidence) {
    const Texts names = texts(statement.at("hardware")), ends = texts(statement.at("ends"));
    const std::set<std::string> goal(ends.begin(), ends.end()), all(names.begin(), names.end());
    const auto closed = layers_of(evidence.at("closed"), given_.nodes), layers = layers_of(evidence.at("layers"), given_.nodes);
    const auto out = out_of_service(names);
    const auto& cuts = list(statement.at("cuts"));
    if (!holds || !out || closed.size() != cuts.size()) return false;
    const Node before = markings_.ending(markings_.internally(given_.reached, [](std::size_t, Node) {}), {"begin"});
    std::vector<std::set<std::uint32_t>> lost;  // as levels
    for (std::size_t i = 0; i < closed.size(); ++i) {
      const Texts cut = texts(cuts[i]);
      const std::set<std::string> once(cut.begin(), cut.end());
      Node starts = before;
      lost.emplace_back();
      for (const std::string& name : cut) {
        if (!all.count(name)) return false;
        starts = markings_.marking(starts, out->at(name));
        lost.back().insert(markings_.side(out->at(name)).first);
      }
      if (once.size() != cut.size() || !families_.within(starts, closed[i]) || !is_closed_but(closed[i], once) || markings_.ending(closed[i], goal)) return false;
    }
    std::vector<std::size_t> unrepaired;
    for (const std::size_t t : markings_.events) if (net_.transitions[t].event[0] != "repaired") unrepaired.push_back(t);
    if (!lead_to(layers, goal, unrepaired)) return false;
    const Node survived = parts(families_.both(begun(), layers.empty() ? 0 : layers.back()), *out);
    Node every = 1, holding = 0;
    for (auto level : levels_of(*out)) every = families_.node(level, every, every);
    for (const auto& cut : lost) {
      for (const std::uint32_t level : cut) {
        std::set<std::uint32_t> less = cut;
        less.erase(level);
        if (!families_.within(set_of(less), survived)) return false;
      }
      Node above = 1;
      for (auto level : levels_of(*out)) above = families_.node(level, cut.count(level) ? 0 : above, above);
      holding = families_.any(holding, above);
    }
    return families_.any(holding, survived) == every;  // nothing is in both
  }
  // The levels of hardware, the last one first.
  static std::vector<std::uint32_t> levels_of_all(const std::set<std::uint32_t>& all) { return {all.rbegin(), all.rend()}; }
  std::vector<std::uint32_t> levels_of(const std::map<std::string, std::size_t>& out) const {
    std::set<std::uint32_t> all;
    for (const auto& [_, place] : out) all.insert(markings_.side(place).first);
    return levels_of_all(all);
  }
  Node set_of(const std::set<std::uint32_t>& levels) const {
    Node made = 1;
    for (auto level : levels_of_all(levels)) made = families_.node(level, 0, made);
    return made;
  }
  // What hardware is out of service in some markings, and every part of that.
  Node parts(Node set, const std::map<std::string, std::size_t>& out) const {
    std::map<std::uint32_t, bool> sides;
    for (const auto& [_, place] : out) sides.insert(markings_.side(place));
    for (std::uint32_t level = 0; level < markings_.levels(); ++level) {
      const Node with = families_.part(set, level, true), without = families_.part(set, level, false);
      const auto side = sides.find(level);
      if (side == sides.end()) { set = families_.any(with, without); continue; }
      const Node lost = side->second ? with : without;
      set = families_.any(families_.any(with, without), families_.changed(lost, {{level, -1, Change::in}}));
    }
    return set;
  }

  // ---- runs

  bool has_ended(const Marked& marking, const std::set<std::string>& roles) const {
    for (std::size_t p = 0; p < marking.size(); ++p) if (marking[p] && markings_.is_end(p, roles)) return true;
    return false;
  }
  static bool is_covered(const Transition& t, const Marked& in) {
    const auto marked = [&](Int place) { return bool(in[std::size_t(place)]); };
    return std::all_of(t.consume.begin(), t.consume.end(), marked) && std::all_of(t.read.begin(), t.read.end(), marked);
  }
  static void fire(const Transition& t, Marked& in) {
    for (const Int place : t.consume) in[std::size_t(place)] = false;
    for (const Int place : t.produce) in[std::size_t(place)] = true;
  }
  void settle(Marked& in) const {
    for (int steps = 0;; ++steps) {
      if (steps > 100'000) throw Limit("more than 100,000 internal firings in a row");
      const std::size_t* next = nullptr;
      for (auto rank = markings_.ranks.begin(); !next && rank != markings_.ranks.end(); ++rank)
        for (const std::size_t& t : *rank) if (!next && is_covered(net_.transitions[t], in)) next = &t;
      if (!next) return;
      fire(net_.transitions[*next], in);
    }
  }
  // The marking after a run; none where it cannot be followed.
  std::optional<Marked> after(const Json& run) const {
    Marked in;
    for (const Place& place : net_.places) in.push_back(place.initial);
    settle(in);
    for (const Int t : numbers(run)) {
      if (t < 0 || t >= Int(net_.transitions.size())) return std::nullopt;
      const Transition& of = net_.transitions[std::size_t(t)];
      if (of.internal() || !is_covered(of, in)) return std::nullopt;
      fire(of, in);
      settle(in);
    }
    return in;
  }
  bool is_stuck(const std::optional<Marked>& in) const {
    if (!in || has_ended(*in, kEnds)) return false;
    return std::none_of(markings_.events.begin(), markings_.events.end(), [&](std::size_t t) { return is_covered(net_.transitions[t], *in); });
  }

  const Net& net_;
  const Diagrams& given_;
  const Markings& markings_;
  Families& families_;
  std::optional<bool> reached_, ends_;
};

void shape(const Json& claim, const Diagrams& given) {
  static const std::set<std::string> kinds{"safe", "confluent", "can_always_go_on", "can_succeed", "can_fail", "can_be_aborted", "can_always_end", "can_always_end_safely", "cut_sets"};
  const std::string& kind = text(claim.at("kind"));
  const bool holds = truth(claim.at("holds"));
  require(kinds.count(kind) > 0, "a kind that is not known: " + kind);
  std::set<std::string> stated, shown;
  if (kind == "cut_sets") stated = {"ends", "hardware", "cuts"}, shown = {"closed", "layers"};
  else if (kind == "can_always_go_on") { if (!holds) shown = {"run"}; }
  else if (kind.rfind("can_always", 0) == 0) { if (holds) shown = {"layers"}; else shown = {"run", "closed"}; }
  else if (kind.rfind("can", 0) == 0 && holds) shown = {"run"};
  keys(claim.at("statement"), stated, "a statement");
  if (!stated.empty()) {
    texts(claim.at("statement").at("ends"));
    texts(claim.at("statement").at("hardware"));
    for (const Json& cut : list(claim.at("statement").at("cuts"))) texts(cut);
    layers_of(claim.at("evidence").at("closed"), given.nodes);
  }
  keys(claim.at("evidence"), shown, "evidence");
  if (shown.count("run")) numbers(claim.at("evidence").at("run"));
  if (shown.count("layers")) layers_of(claim.at("evidence").at("layers"), given.nodes);
  if (shown.count("closed") && stated.empty()) node_of(claim.at("evidence").at("closed"), given.nodes);
}

int checked(const std::string& path, const Clock& clock) {
  const auto files = unzipped(path);
  const Net net = net_of(parsed(files.at("net.json")));
  require(files.count("diagrams.json") > 0, "no diagrams.json");
  const Json entry = parsed(files.at("diagrams.json"));
  keys(entry, {"format", "version", "claims", "order", "partners", "nodes", "pairs", "reached", "layers", "ends", "weights", "again"}, "diagrams.json");
  header(entry);
  std::set<std::string> once;
  for (const Json& each : list(entry.at("claims"))) {
    keys(each, {"key", "kind", "subject", "holds", "sentence", "statement", "evidence"}, "a claim");
    require(once.insert(text(each.at("key"))).second, "two claims of one key");
    texts(each.at("subject"));
    text(each.at("sentence"));
  }
  std::string why;
  bool refuted = false, open = entry.at("claims").items.empty();
  std::unique_ptr<Claims> claims;
  Families families(clock.most, clock);
  Diagrams given;
  std::unique_ptr<Markings> markings;
  try {
    given = diagrams_of(entry, net, families);
    markings = std::make_unique<Markings>(net, given, families);
    claims = std::make_unique<Claims>(net, given, *markings, families);
  } catch (const Limit& limit) {
    why = limit.what();
  }
  if (claims) for (const Json& each : entry.at("claims").items) shape(each, given);
  for (const Json& each : entry.at("claims").items) {
    std::string verdict = "not checked";
    if (claims) {
      try {
        verdict = claims->proved(each.at("kind").string, each.at("holds").truth, each.at("statement"), each.at("evidence")) ? "proved" : "refuted";
      } catch (const Limit& limit) {
        why = limit.what();
      }
    }
    refuted = refuted || verdict == "refuted";
    open = open || verdict == "not checked";
    std::cout << verdict << ' ' << each.at("key").string << '\n';
  }
  if (!why.empty()) std::cerr << "not checked: " << why << '\n';
  return refuted ? 1 : open ? 2 : 0;
}

int main(int count, char** words) { return answered(count, words, "--max-nodes", checked); }
