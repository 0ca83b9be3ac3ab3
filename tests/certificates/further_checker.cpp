// A second checker of further.json, written from docs/certificates.md alone: c++ -O2 -std=c++17 further_checker.cpp -o further_checker.
//
// further_checker FILE [--max-states N] [--seconds S] prints "VERDICT KEY" for each claim on cut sets at other moments and on probabilities;
// VERDICT is proved, refuted or not checked. It ends with 0 if all are proved, 1 if some is refuted, else 2. What is malformed is told in
// one sentence, with exit code 2.
#include "cut_sets.hpp"

const std::set<std::string> kEnds{"success", "failure", "abort"};

// ---- whole numbers without a bound

class Big {
 public:
  Big(Int value = 0) : minus_(value < 0) {
    for (auto left = minus_ ? 0 - std::uint64_t(value) : std::uint64_t(value); left; left /= kBase) limbs_.push_back(std::uint32_t(left % kBase));
  }
  explicit Big(const std::string& digits) {
    for (const char digit : digits) *this = *this * Big(10) + Big(digit - '0');
  }
  int sign() const { return limbs_.empty() ? 0 : minus_ ? -1 : 1; }
  Big operator-() const { Big made = *this; made.minus_ = !minus_; return made; }
  Big operator-(const Big& other) const { return *this + -other; }
  Big operator+(const Big& other) const {
    if (minus_ != other.minus_) {
      const bool more = beyond(limbs_, other.limbs_);
      Big made = more ? *this : other;
      const auto& less = more ? other.limbs_ : limbs_;
      std::int64_t borrow = 0;
      for (std::size_t i = 0; i < made.limbs_.size(); ++i) {
        std::int64_t left = std::int64_t(made.limbs_[i]) - borrow - (i < less.size() ? less[i] : 0);
        borrow = left < 0;
        made.limbs_[i] = std::uint32_t(left < 0 ? left + std::int64_t(kBase) : left);
      }
      return made.trimmed();
    }
    Big made;
    made.minus_ = minus_;
    std::uint64_t carry = 0;
    for (std::size_t i = 0; i < std::max(limbs_.size(), other.limbs_.size()) || carry; ++i) {
      carry += std::uint64_t(i < limbs_.size() ? limbs_[i] : 0) + (i < other.limbs_.size() ? other.limbs_[i] : 0);
      made.limbs_.push_back(std::uint32_t(carry % kBase));
      carry /= kBase;
    }
    return made;
  }
  Big operator*(const Big& other) const {
    Big made;
    made.minus_ = minus_ != other.minus_;
    made.limbs_.resize(limbs_.size() + other.limbs_.size());
    for (std::size_t i = 0; i < limbs_.size(); ++i) {
      std::uint64_t carry = 0;
      for (std::size_t k = 0; k < other.limbs_.size() || carry; ++k) {
        carry += made.limbs_[i + k] + (k < other.limbs_.size() ? std::uint64_t(limbs_[i]) * other.limbs_[k] : 0);
        made.limbs_[i + k] = std::uint32_t(carry % kBase);
        carry /= kBase;
      }
    }
    return made.trimmed();
  }

 private:
  static constexpr std::uint64_t kBase = 1'000'000'000;
  static bool beyond(const std::vector<std::uint32_t>& one, const std::vector<std::uint32_t>& other) {
    if (one.size() != other.size()) return one.size() > other.size();
    return std::lexicographical_compare(other.rbegin(), other.rend(), one.rbegin(), one.rend());
  }
  Big trimmed() {
    while (!limbs_.empty() && !limbs_.back()) limbs_.pop_back();
    return *this;
  }

  bool minus_ = false;
  std::vector<std::uint32_t> limbs_;
};

struct Refuted {};  // by a value of the right type that says nothing

void need(bool holds) { if (!holds) throw Refuted(); }

const Big kOne("1" + std::string(40, '0'));  // numbers are counted in parts of 10^-40

Big number(const Json& of) {
  const std::string& all = text(of);
  const std::size_t point = std::min(all.find('.'), all.size());
  const std::string before = all.substr(0, point), after = point < all.size() ? all.substr(point + 1) : "";
  const auto digits = [](const std::string& part) {
    return !part.empty() && part.size() <= 40 && part.find_first_not_of("0123456789") == std::string::npos;
  };
  need(digits(before) && (point == all.size() || digits(after)));
  return Big(before + after + std::string(40 - after.size(), '0'));
}

struct Rate { Big least, most; };

Rate rate(const Json& of) {
  need(of.items.size() == 2);
  Rate made{number(of.items[0]), number(of.items[1])};
  need((made.least.sign() == 0) == (made.most.sign() == 0) && (made.most - made.least).sign() >= 0);
  return made;
}

// ---- what claims state

bool of_cut_sets(const std::string& kind) { return kind.rfind("cut_sets_", 0) == 0; }

void shape_of_cut_sets(const std::string& kind, const Json& statement, const Json& evidence) {
  std::set<std::string> stated{"goal", "hardware", "cuts", "stopped"};
  if (kind == "cut_sets_at_entry") stated.insert({"entered", "inside", "again"});
  if (kind == "cut_sets_at_worst") stated.insert({"over", "timed"});
  keys(statement, stated, "a statement");
  keys(statement.at("goal"), {"ends", "objective"}, "a goal");
  texts(statement.at("goal").at("ends"));
  text(statement.at("goal").at("objective"));
  for (const char* key : {"hardware", "entered", "again", "over"}) if (stated.count(key)) texts(statement.at(key));
  for (const char* key : {"cuts", "inside", "timed"})
    if (stated.count(key)) for (const Json& each : list(statement.at(key))) texts(each);
  if (kind == "cut_sets_at_worst") return keys(evidence, {}, "evidence");
  keys(evidence, {"survived"}, "evidence");
  CutSets::shape_of_survived(evidence.at("survived"));
}

void shape_of_chance(const Json& statement, const Json& evidence) {
  keys(statement, {"end", "low", "high", "hardware", "objectives", "events", "stopped"}, "a statement");
  for (const char* key : {"end", "low", "high"}) text(statement.at(key));
  for (const Json& each : list(statement.at("hardware"))) {
    keys(each, {"name", "fails", "repaired"}, "hardware");
    text(each.at("name"));
    for (const char* key : {"fails", "repaired"}) texts(each.at(key));
  }
  for (const Json& each : list(statement.at("objectives"))) {
    keys(each, {"name", "duration", "failures"}, "an objective");
    for (const char* key : {"name", "duration"}) text(each.at(key));
    for (const Json& failure : list(each.at("failures"))) texts(failure);
  }
  for (const Json& each : list(statement.at("events"))) {
    keys(each, {"event", "rate"}, "an event");
    for (const char* key : {"event", "rate"}) texts(each.at(key));
  }
  keys(evidence, {"above", "below"}, "evidence");
  for (const char* key : {"above", "below"}) numbers(evidence.at(key));
}

void shape(const Json& claim) {
  const std::string& kind = claim.at("kind").string;
  if (of_cut_sets(kind)) shape_of_cut_sets(kind, claim.at("statement"), claim.at("evidence"));
  else shape_of_chance(claim.at("statement"), claim.at("evidence"));
  for (const Json& each : list(claim.at("statement").at("stopped"))) {
    keys(each, {"objective", "transitions"}, "what stops");
    text(each.at("objective"));
    numbers(each.at("transitions"));
  }
}

// ---- what they say of states

class Further {
 public:
  Further(const Net& net, const States& states, const Clock& clock, const Json& statement)
      : net_(net), states_(states), clock_(clock), statement_(statement), count_(states.markings.size()), before_(count_) {
    for (std::size_t s = 0; s < count_; ++s) {
      for (const Edge& edge : states.edges[s]) before_[edge.to].push_back({s, edge});
      for (std::size_t p = 0; p < net.places.size(); ++p)
        if (states.markings[s][p]) for (const Role& role : net.places[p].roles) mark(role, s);
    }
    for (const Json& each : statement.at("stopped").items) {
      const Numbers all = numbers(each.at("transitions"));
      for (const Int t : all) need(t >= 0 && t < Int(net.transitions.size()) && !net.transitions[std::size_t(t)].internal());
      need(stopped_.emplace(each.at("objective").string, std::set<Int>(all.begin(), all.end())).second);
    }
  }
  bool cut_sets(const std::string& kind, const Json& evidence) const {
    if (kind == "cut_sets_at_worst") return at_worst();
    const Goal goal = goal_of(kind == "cut_sets_at_start");
    Search search{goal.open, goal.won, goal.is_step};
    if (kind == "cut_sets_at_start") search.moments = ending({"begin"});
    if (kind == "cut_sets_at_entry") search.moments = entries();
    return CutSets(net_, states_, clock_).proved(statement_, evidence.at("survived"), search);
  }
  bool chance(const Json& evidence) const;

 private:
  using Step = std::function<bool(std::size_t, const Edge&)>;
  struct Goal { Set won, open; Step is_step; };
  struct Way { std::size_t to; Big least, most; std::string of; };  // a rate, in parts of 1 / duration of an objective if one is named

  void mark(const Role& role, std::size_t s) {
    Set& set = marked_.emplace(role, Set(count_)).first->second;
    set[s] = true;
  }
  bool marks(std::size_t s, const std::string& role, const std::string& element) const {
    const auto found = marked_.find({role, element});
    return found != marked_.end() && found->second[s];
  }
  Set ending(const std::set<std::string>& roles) const {
    Set made(count_);
    for (std::size_t s = 0; s < count_; ++s) made[s] = states_.ends(s, roles);
    return made;
  }
  const Texts& event(const Edge& edge) const { return net_.transitions[std::size_t(edge.transition)].event; }
  bool runs(std::size_t s, const std::string& objective) const { return marks(s, "objective", objective); }
  bool ends_run(std::size_t s, const Edge& edge, const std::string& objective) const {
    if (!runs(s, objective)) return false;
    if (!runs(edge.to, objective)) return true;
    const Texts& what = event(edge);
    if (what[1] == objective && (what[0] == "success" || what[0] == "failure" || what[0] == "timeout")) return true;
    const auto found = stopped_.find(objective);
    return found != stopped_.end() && found->second.count(edge.transition) > 0;
  }
  Goal goal_of_objective(const std::string& objective) const {
    Goal made{Set(count_), Set(count_), [this, objective](std::size_t s, const Edge& edge) { return runs(s, objective) && !ends_run(s, edge, objective); }};
    for (std::size_t s = 0; s < count_; ++s) {
      made.open[s] = runs(s, objective);
      const auto& out = states_.edges[s];
      made.won[s] = made.open[s] && std::any_of(out.begin(), out.end(), [&](const Edge& edge) { return event(edge)[0] == "success" && event(edge)[1] == objective; });
    }
    return made;
  }
  Goal goal_of(bool at_start) const {
    const Json& goal = statement_.at("goal");
    const Texts roles = texts(goal.at("ends"));
    need(roles.empty() != goal.at("objective").string.empty());
    const Step all = [](std::size_t, const Edge&) { return true; };
    if (!roles.empty()) {
      Goal made{ending({roles.begin(), roles.end()}), {}, all};
      made.open = made.won;
      made.open.flip();
      return made;
    }
    Goal made = goal_of_objective(goal.at("objective").string);
    if (at_start) made.is_step = all;
    return made;
  }
  // What some edges lead to, from some states.
  Set forward(Set seen, const Step& is_step) const {
    std::vector<std::size_t> stack;
    for (std::size_t s = 0; s < count_; ++s) if (seen[s]) stack.push_back(s);
    clock_.look(0);
    while (!stack.empty()) {
      const std::size_t s = stack.back();
      stack.pop_back();
      for (const Edge& edge : states_.edges[s])
        if (!seen[edge.to] && is_step(s, edge)) { seen[edge.to] = true; stack.push_back(edge.to); }
    }
    return seen;
  }
  // From where some edges lead to some states.
  Set backward(Set seen, const Step& is_step) const {
    std::vector<std::size_t> stack;
    for (std::size_t s = 0; s < count_; ++s) if (seen[s]) stack.push_back(s);
    clock_.look(0);
    while (!stack.empty()) {
      const std::size_t s = stack.back();
      stack.pop_back();
      for (const auto& [from, edge] : before_[s])
        if (!seen[from] && is_step(from, edge)) { seen[from] = true; stack.push_back(from); }
    }
    return seen;
  }
  Set entries() const {
    const Texts entered = texts(statement_.at("entered")), again = texts(statement_.at("again"));
    const auto& inside = statement_.at("inside").items;
    for (const Json& role : inside) need(role.items.size() == 2);
    Set made(count_);
    for (std::size_t s = 0; s < count_; ++s) {
      const bool is_inside = std::any_of(inside.begin(), inside.end(), [&](const Json& role) { return marks(s, role.items[0].string, role.items[1].string); });
      for (const Edge& edge : states_.edges[s]) {
        const bool enters = std::any_of(entered.begin(), entered.end(), [&](const std::string& name) { return runs(edge.to, name) || marks(edge.to, "pending", name); });
        if (enters && (!is_inside || std::any_of(again.begin(), again.end(), [&](const std::string& name) { return ends_run(s, edge, name); }))) made[edge.to] = true;
      }
    }
    made = forward(std::move(made), [this](std::size_t, const Edge& edge) { return event(edge)[0] == "out of service"; });
    const std::string& objective = statement_.at("goal").at("objective").string;
    for (std::size_t s = 0; s < count_; ++s) made[s] = made[s] && (objective.empty() || runs(s, objective));
    return made;
  }

  // ---- the worst moment

  Set worst_moments(const Goal& goal) const {
    std::map<std::string, Set> hopeless;  // by objective, where it runs and cannot succeed without repairs
    const auto is_hopeless = [&](std::size_t s, const std::string& objective) {
      auto found = hopeless.find(objective);
      if (found == hopeless.end()) {
        const Goal own = goal_of_objective(objective);
        Set made = backward(own.won, [&](std::size_t from, const Edge& edge) { return event(edge)[0] != "repaired" && own.is_step(from, edge); });
        for (std::size_t each = 0; each < count_; ++each) made[each] = own.open[each] && !made[each];
        found = hopeless.emplace(objective, std::move(made)).first;
      }
      return bool(found->second[s]);
    };
    std::map<std::string, Texts> timed;
    for (const Json& each : statement_.at("timed").items) {
      const Texts names = texts(each);
      need(!names.empty() && timed.emplace(names[0], Texts(names.begin() + 1, names.end())).second);
    }
    Set moments(count_);
    moments[0] = true;
    moments = forward(std::move(moments), [&](std::size_t s, const Edge& edge) {
      const Texts& what = event(edge);
      if (what[0] == "repaired") return false;
      if (what[0] == "failure") return is_hopeless(s, what[1]);
      if (what[0] != "timeout") return true;
      const auto held = timed.find(what[1]);
      if (held == timed.end()) return is_hopeless(s, what[1]);
      return std::any_of(held->second.begin(), held->second.end(), [&](const std::string& name) { return is_hopeless(s, name); });
    });
    const Texts over = texts(statement_.at("over"));
    const Set past = ending({over.begin(), over.end()});
    for (std::size_t s = 0; s < count_; ++s) moments[s] = moments[s] && goal.open[s] && !past[s];
    return moments;
  }
  bool at_worst() const {
    const Texts names = texts(statement_.at("hardware"));
    const CutSets judge(net_, states_, clock_);
    if (!judge.names_hardware(names)) return false;
    std::set<CutSets::Mask> cuts;
    for (const Json& each : statement_.at("cuts").items) {
      CutSets::Mask made;
      if (!CutSets::mask(names, texts(each), made)) return false;
      cuts.insert(made);
    }
    const Goal goal = goal_of(false);
    const Set moments = worst_moments(goal);
    std::map<CutSets::Mask, std::vector<std::size_t>> by_lost;
    for (std::size_t s = 0; s < count_; ++s) {
      if (!moments[s]) continue;
      CutSets::Mask lost(names.size());
      for (std::size_t i = 0; i < names.size(); ++i) lost[i] = marks(s, "oos", names[i]);
      by_lost[lost].push_back(s);
    }
    std::set<CutSets::Mask> losing;
    for (const auto& [lost, states] : by_lost) {
      std::set<std::string> gone;
      for (std::size_t i = 0; i < names.size(); ++i) if (lost[i]) gone.insert(names[i]);
      const Set winning = backward(goal.won, [&](std::size_t s, const Edge& edge) { return goal.is_step(s, edge) && !(event(edge)[0] == "repaired" && gone.count(event(edge)[1])); });
      if (std::any_of(states.begin(), states.end(), [&](std::size_t s) { return !winning[s]; })) losing.insert(lost);
    }
    for (const auto& cut : cuts) {
      if (!losing.count(cut)) return false;
      for (const auto& other : cuts) if (other != cut && CutSets::within(cut, other)) return false;
    }
    return std::all_of(losing.begin(), losing.end(), [&](const auto& lost) {
      return std::any_of(cuts.begin(), cuts.end(), [&](const auto& cut) { return CutSets::within(cut, lost); });
    });
  }

  // ---- probabilities

  struct Objective { Big duration; std::map<std::string, Big> failures; Goal goal; };
  struct Rates { std::map<Texts, Rate> events; std::map<std::string, Objective> objectives; };

  static std::string reason(const Texts& event) { return event.size() == 3 ? event[2] : ""; }
  static bool is_end_of_run(const Texts& event) { return event[0] == "success" || event[0] == "failure"; }

  // What the statement says of rates.
  Rates read() const {
    Rates made;
    Texts hardware;
    for (const Json& each : statement_.at("hardware").items) {
      const std::string& name = each.at("name").string;
      hardware.push_back(name);
      made.events[{"out of service", name}] = rate(each.at("fails"));
      made.events[{"repaired", name}] = rate(each.at("repaired"));
    }
    for (const Json& each : statement_.at("events").items) {
      const Texts named = texts(each.at("event"));
      need(named.size() == 2 && (named[0] == "declared" || named[0] == "detected") && made.events.emplace(named, rate(each.at("rate"))).second);
    }
    std::set<std::string> objectives;
    for (const Transition& each : net_.transitions) if (!each.internal() && is_end_of_run(each.event)) objectives.insert(each.event[1]);
    for (const Json& each : statement_.at("objectives").items) {
      const std::string& name = each.at("name").string;
      Objective one{number(each.at("duration")), {}, goal_of_objective(name)};
      for (const Json& failure : each.at("failures").items)
        need(failure.items.size() == 2 && one.failures.emplace(failure.items[0].string, number(failure.items[1])).second);
      need(part(one, {"success", name}).sign() >= 0);
      need(one.duration.sign() > 0 || std::count(one.goal.won.begin(), one.goal.won.end(), true) == 0);
      need(objectives.count(name) > 0 && made.objectives.emplace(name, std::move(one)).second);
    }
    need(made.objectives.size() == objectives.size() && CutSets(net_, states_, clock_).names_hardware(hardware));
    return made;
  }
  // The rate of an edge by 1.
  static Rate plain(const Rates& rates, const Texts& what) {
    const auto found = rates.events.find(what);
    return found == rates.events.end() ? Rate{} : found->second;
  }
  // The ways out of each state that are taken with some rate.
  std::vector<std::vector<Way>> chain(const Rates& rates) const {
    std::vector<std::vector<Way>> ways(count_);
    std::map<std::string, Set> lost;  // by objective, where it runs and cannot succeed any more
    for (const auto& [name, objective] : rates.objectives) {
      const Goal& goal = objective.goal;
      Set made = backward(goal.won, [&](std::size_t s, const Edge& edge) {
        return goal.is_step(s, edge) && (is_end_of_run(event(edge)) || plain(rates, event(edge)).most.sign() > 0);
      });
      for (std::size_t s = 0; s < count_; ++s) made[s] = goal.open[s] && !made[s];
      lost.emplace(name, std::move(made));
    }
    const Set ends = ending(kEnds);
    for (std::size_t s = 0; s < count_; ++s) {
      if (ends[s]) continue;
      for (const Edge& edge : states_.edges[s]) {
        const Texts& what = event(edge);
        if (what[0] == "failure" && what.size() == 2 && lost.at(what[1])[s]) ways[s].push_back({edge.to, kOne, kOne, ""});
      }
      if (!ways[s].empty()) continue;  // it is hasty
      for (const Edge& edge : states_.edges[s]) {
        const Texts& what = event(edge);
        if (edge.to == s) continue;
        Way way{edge.to, {}, {}, ""};
        const auto objective = rates.objectives.find(what[1]);
        if (is_end_of_run(what) && objective->second.goal.won[s]) {
          way.of = what[1];
          way.most = part(objective->second, what);
          way.least = way.most;
        } else {
          const Rate found = plain(rates, what);
          way.least = found.least;
          way.most = found.most;
        }
        if (way.most.sign() > 0) ways[s].push_back(std::move(way));
      }
    }
    return ways;
  }
  static Big part(const Objective& of, const Texts& what) {
    if (what[0] == "failure") {
      const auto found = of.failures.find(reason(what));
      return found == of.failures.end() ? Big() : found->second;
    }
    Big left = kOne;
    for (const auto& [_, failure] : of.failures) left = left - failure;
    return left;
  }
  // The sign of the sum of rates times differences, with the rates chosen so that it is largest.
  static int largest(const std::vector<Way>& ways, const std::vector<Big>& values, std::size_t s, const Rates& rates, bool smallest) {
    std::set<std::string> objectives;
    for (const Way& way : ways) if (!way.of.empty()) objectives.insert(way.of);
    Big sum;
    for (const Way& way : ways) {
      const Big rises = smallest ? values[s] - values[way.to] : values[way.to] - values[s];
      Big term = (rises.sign() > 0 ? way.most : way.least) * rises * (way.of.empty() ? Big(1) : kOne);
      for (const std::string& name : objectives) if (name != way.of) term = term * rates.objectives.at(name).duration;
      sum = sum + term;
    }
    return sum.sign();
  }

  const Net& net_;
  const States& states_;
  const Clock& clock_;
  const Json& statement_;
  std::size_t count_;
  std::vector<std::vector<std::pair<std::size_t, Edge>>> before_;
  std::map<Role, Set> marked_;
  std::map<std::string, std::set<Int>> stopped_;
};

bool Further::chance(const Json& evidence) const {
  need(kEnds.count(statement_.at("end").string) > 0);
  const Rates rates = read();
  std::vector<Big> above, below;
  for (const Int each : numbers(evidence.at("above"))) above.emplace_back(each);
  for (const Int each : numbers(evidence.at("below"))) below.emplace_back(each);
  if (above.size() != count_ || below.size() != count_) return false;
  std::vector<std::size_t> starts;
  for (const Edge& edge : states_.edges[0]) if (event(edge)[0] == "start") starts.push_back(edge.to);
  if (starts.size() != 1) return false;
  const auto ways = chain(rates);
  Set reached(count_);
  std::vector<std::size_t> stack{starts[0]};
  reached[starts[0]] = true;
  while (!stack.empty()) {
    const std::size_t s = stack.back();
    stack.pop_back();
    for (const Way& way : ways[s]) if (!reached[way.to]) { reached[way.to] = true; stack.push_back(way.to); }
  }
  const Set asked = ending({statement_.at("end").string});
  const Big whole(100'000'000'000'000'000);
  Set settled(count_);
  for (std::size_t s = 0; s < count_; ++s) {
    if (!reached[s]) continue;
    if (s % 256 == 0) clock_.look(0);
    if (above[s].sign() < 0) return false;
    settled[s] = ways[s].empty() || below[s].sign() <= 0;
    if (ways[s].empty()) {
      if (asked[s] && (above[s] - whole).sign() < 0) return false;
      if ((below[s] - (asked[s] ? whole : Big())).sign() > 0) return false;
      continue;
    }
    if (largest(ways[s], above, s, rates, false) > 0) return false;
    if (below[s].sign() > 0 && largest(ways[s], below, s, rates, true) > 0) return false;
  }
  for (bool grown = true; grown;) {
    grown = false;
    clock_.look(0);
    for (std::size_t s = count_; s-- > 0;) {
      if (!reached[s] || settled[s] || std::none_of(ways[s].begin(), ways[s].end(), [&](const Way& way) { return bool(settled[way.to]); })) continue;
      settled[s] = true;
      grown = true;
    }
  }
  for (std::size_t s = 0; s < count_; ++s) if (reached[s] && !settled[s]) return false;
  const Big scale("1" + std::string(23, '0'));  // from parts of 10^-17 to parts of 10^-40
  const std::size_t first = starts[0];
  return (above[first] * scale - number(statement_.at("high"))).sign() <= 0 && (below[first] * scale - number(statement_.at("low"))).sign() >= 0;
}

bool proved(const Net& net, const States& states, const Clock& clock, const Json& claim) {
  const Further of(net, states, clock, claim.at("statement"));
  const std::string& kind = claim.at("kind").string;
  return of_cut_sets(kind) ? of.cut_sets(kind, claim.at("evidence")) : of.chance(claim.at("evidence"));
}

int checked(const std::string& path, const Clock& clock) {
  const auto files = unzipped(path);
  const Net net = net_of(parsed(files.at("net.json")));
  require(files.count("further.json") > 0, "no further.json");
  const Json further = parsed(files.at("further.json"));
  keys(further, {"format", "version", "claims"}, "further.json");
  header(further);
  static const std::set<std::string> kinds{"cut_sets_at_start", "cut_sets_at_entry", "cut_sets_whenever", "cut_sets_at_worst", "chance"};
  std::set<std::string> once;
  for (const Json& each : list(further.at("claims"))) {
    keys(each, {"key", "kind", "subject", "holds", "sentence", "statement", "evidence"}, "a claim");
    require(once.insert(text(each.at("key"))).second, "two claims of one key");
    text(each.at("kind"));
    texts(each.at("subject"));
    text(each.at("sentence"));
    truth(each.at("holds"));
    for (const char* key : {"statement", "evidence"}) require(each.at(key).kind == Json::object, "a claim without an object");
  }
  std::unique_ptr<States> states;
  std::string why;
  try {
    states = std::make_unique<States>(net, clock);
  } catch (const Unsafe&) {
    why = "the net is not safe";
  } catch (const NotConfluent&) {
    why = "the net is not confluent";
  } catch (const Limit& limit) {
    why = limit.what();
  }
  if (states)  // else no claim is looked into
    for (const Json& each : further.at("claims").items) {
      require(kinds.count(each.at("kind").string) > 0, "a kind that is not known: " + each.at("kind").string);
      if (each.at("holds").truth) shape(each);
    }
  bool refuted = false, open = further.at("claims").items.empty();
  for (const Json& each : further.at("claims").items) {
    std::string verdict = "not checked";
    if (states) {
      try {
        verdict = each.at("holds").truth && proved(net, *states, clock, each) ? "proved" : "refuted";
      } catch (const Refuted&) {
        verdict = "refuted";
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

int main(int count, char** words) { return answered(count, words, "--max-states", checked); }
