#include "search/on_the_fly.hpp"

#include "diagrams/store.hpp"

namespace mcpn::search {

namespace {

struct Hit { Local limit; };

}  // namespace

// The markings that a search has entered and not decided, in the order in which they were entered, and their numbers.
// It stays while the checker pauses; the operator and the marking that it is asked for tell that it is to go on.
struct Checker::Search {
  explicit Search(Checker& of) : checker(of) {}
  void open(std::uint32_t op, std::uint32_t from) {
    if (at != kNone && number == op && start == from) return;
    close();
    number = op;
    start = at = from;
  }
  void close() {
    for (const std::uint32_t state : undecided) numbers[state] = 0;
    undecided.clear();
    path.clear();
    at = kNone;
  }
  std::uint32_t entered(std::uint32_t state) const { return state < numbers.size() ? numbers[state] : 0; }
  // The successors are tried from one on that the seed draws.
  void enter(std::uint32_t state) {
    if (state >= numbers.size()) numbers.resize(checker.out_.size());
    undecided.push_back(state);
    numbers[state] = std::uint32_t(undecided.size());
    const std::uint32_t count = checker.expand(state).count;
    const std::uint64_t drawn = checker.seed_ ? (checker.seed_ * 0x9E3779B97F4A7C15ull ^ state) * 0xBF58476D1CE4E5B9ull >> 33 : 0;
    path.push_back({state, 0, count ? std::uint32_t(drawn % count) : 0, std::uint32_t(undecided.size())});
  }
  // The next successor of the last marking of the path, or kNone.
  std::uint32_t next() {
    Frame& frame = path.back();
    const std::uint32_t count = checker.out_[frame.state].count;
    if (frame.next == count) return kNone;
    const std::uint32_t edge = (frame.first + frame.next++) % count;
    return checker.target(frame.state, edge);
  }
  // Takes the last marking off the path; where its component ends there, all of it is false.
  void leave() {
    const Frame frame = path.back();
    path.pop_back();
    if (!path.empty()) path.back().low = std::min(path.back().low, frame.low);
    if (frame.low != numbers[frame.state]) return;
    while (undecided.size() >= frame.low) {
      decide(undecided.back(), false);
      undecided.pop_back();
    }
  }
  // Whatever is undecided comes to the end of the path: all of it is true.
  void succeed() {
    for (const std::uint32_t state : undecided) decide(state, true);
    undecided.clear();
  }
  void decide(std::uint32_t state, bool value) {
    checker.learn(number, state, value);
    numbers[state] = 0;
  }

  Checker& checker;
  std::uint32_t number = 0, start = 0;
  std::uint32_t at = kNone;  // the marking that is looked at; kNone where nothing is searched
  std::vector<std::uint32_t> numbers;  // by marking, 0 outside
  std::vector<std::uint32_t> undecided;
  std::vector<Frame> path;
};

Checker::Checker(const TokenNet& net, const Marking& initial, const Goals& goals, std::vector<Operator> operators,
                 std::uint64_t max_bytes)
    : net_(net), initial_(initial), goals_(goals), operators_(std::move(operators)), max_bytes_(max_bytes) {
  begin();
}

Checker::~Checker() = default;

void Checker::begin() {
  while (width_ + 1 < std::size(kWidths) && !Packed(1, kWidths[width_]).fits(initial_)) ++width_;
  packed_ = std::make_unique<Packed>(net_.places, kWidths[width_]);
  out_.clear();
  edges_.clear();
  searches_.clear();
  values_.assign(operators_.size(), {});
  marking_.assign(net_.places, 0);
  packed_->add(packed_->packed(initial_));
  out_.push_back({});
}

void Checker::forget() {
  for (const auto& search : searches_) search->close();
}

Local Checker::decide(std::uint32_t root, std::uint64_t max_steps, std::uint64_t seed, std::uint64_t pause,
                      const GoOn& go_on) {
  const bool same = paused_ && root == root_ && max_steps == most_steps_ && seed == seed_;
  if (!same) {
    forget();
    steps_ = 0;
  }
  paused_ = false;
  root_ = root;
  most_steps_ = max_steps;
  seed_ = seed;
  pause_at_ = steps_ + pause;
  go_on_ = &go_on;
  if (!packed_->fits(initial_)) return Local::tokens;
  for (bool emptied = false;;) {
    depth_ = 0;
    try {
      return holds(root, 0) ? Local::yes : Local::no;
    } catch (const Hit& hit) {
      paused_ = hit.limit == Local::pause;
      const bool wider = hit.limit == Local::tokens && width_ + 1 < std::size(kWidths);
      if (paused_ || hit.limit == Local::steps) return hit.limit;
      if (!wider && (hit.limit == Local::tokens || emptied)) return hit.limit;
      if (wider) ++width_;
      else emptied = true;  // what other operators have taken is given back, once
      begin();
    }
  }
}

std::uint64_t Checker::bytes() const {
  std::uint64_t total = packed_->bytes() + out_.capacity() * sizeof(Out) + edges_.capacity() * sizeof(Edge);
  for (const auto& values : values_) total += values.capacity() * 8;
  for (const auto& search : searches_) total += search->numbers.capacity() * 4;
  return total;
}

void Checker::step() {
  if (++steps_ >= most_steps_) throw Hit{Local::steps};
  if (steps_ % kLook) return;
  if (bytes() > max_bytes_) throw Hit{Local::bytes};
  if (!(*go_on_)()) throw Interrupted();
}

const Checker::Out& Checker::expand(std::uint32_t state) {
  Out& out = out_[state];
  if (out.count == kNone) {
    packed_->get(state, marking_, row_);
    net_.collect(marking_, enabled_);
    out = {edges_.size(), std::uint32_t(enabled_.size())};
    for (const Transition t : enabled_) edges_.push_back({t, kNone});
  }
  return out;
}

std::uint32_t Checker::target(std::uint32_t state, std::uint32_t number) {
  step();
  Edge& edge = edges_[out_[state].begin + number];
  if (edge.target == kNone) {
    packed_->get(state, row_);
    if (!packed_->fire(row_, net_.rules[edge.transition])) throw Hit{Local::tokens};
    const auto [found, fresh] = packed_->add(row_);
    if (found == kNone - 1) throw Hit{Local::bytes};
    edge.target = found;
    if (fresh) out_.push_back({});
  }
  return edge.target;
}

std::optional<bool> Checker::known(std::uint32_t number, std::uint32_t state) const {
  const auto& values = values_[number];
  if (state / 32 >= values.size()) return std::nullopt;
  const std::uint64_t bits = values[state / 32] >> state % 32 * 2 & 3;
  return bits ? std::optional(bits == 3) : std::nullopt;
}

void Checker::learn(std::uint32_t number, std::uint32_t state, bool value) {
  auto& values = values_[number];
  if (state / 32 >= values.size()) values.resize(out_.size() / 32 + 1);
  values[state / 32] |= std::uint64_t(value ? 3 : 1) << state % 32 * 2;
}

bool Checker::holds_goal(std::uint32_t number, std::uint32_t state) {
  const Goals::Node& node = goals_.nodes[number];
  const auto inside = [&](std::uint32_t n) { return holds_goal(n, state); };
  switch (node.kind) {
    case Goals::dead: return expand(state).count == 0;
    case Goals::not_dead: return expand(state).count != 0;
    case Goals::all: return std::all_of(node.inside.begin(), node.inside.end(), inside);
    case Goals::any: return std::any_of(node.inside.begin(), node.inside.end(), inside);
    default: break;
  }
  packed_->get(state, row_);
  Tokens sum = 0;
  for (const auto& [place, weight] : goals_.terms[node.atom]) sum += weight * packed_->get(row_, place);
  return sum <= goals_.bounds[node.atom];
}

bool Checker::holds(std::uint32_t number, std::uint32_t state) {
  step();
  const Operator& at = operators_[number];
  const auto inside = [&](std::uint32_t n) { return holds(n, state); };
  switch (at.kind) {
    case Operator::goal: return holds_goal(at.inside[0], state);
    case Operator::negation: return !holds(at.inside[0], state);
    case Operator::all: return std::all_of(at.inside.begin(), at.inside.end(), inside);
    case Operator::any: return std::any_of(at.inside.begin(), at.inside.end(), inside);
    default: break;
  }
  if (const auto value = known(number, state)) return *value;
  if (at.kind == Operator::until) return until(number, state);
  if (at.kind == Operator::always) return always(number, state);
  bool found = false;
  const std::uint32_t count = expand(state).count;
  for (std::uint32_t i = 0; i < count && !found; ++i) found = holds(at.inside[0], target(state, i));
  learn(number, state, found);
  return found;
}

bool Checker::until(std::uint32_t number, std::uint32_t start) {
  const std::uint32_t left = operators_[number].inside[0], right = operators_[number].inside[1];
  return search(number, start, false, [&](std::uint32_t state) {
    return holds(right, state) ? Met::end : holds(left, state) ? Met::way : Met::wall;
  });
}

bool Checker::always(std::uint32_t number, std::uint32_t start) {
  const std::uint32_t operand = operators_[number].inside[0];
  return search(number, start, true, [&](std::uint32_t state) { return holds(operand, state) ? Met::way : Met::wall; });
}

// Whether a path leads along ways to an end, or, where paths may stay, to a circle or to where nothing may fire.
template <class Look> bool Checker::search(std::uint32_t number, std::uint32_t start, bool may_stay, Look look) {
  if (searches_.size() == depth_) searches_.push_back(std::make_unique<Search>(*this));
  Search& search = *searches_[depth_++];
  search.open(number, start);
  const auto ended = [&](bool value) {
    search.close();
    --depth_;
    return value;
  };
  for (;;) {  // at a marking that the search has not entered and whose value is not known
    const Met met = look(search.at);
    bool success = met == Met::end;
    if (met == Met::way) {
      search.enter(search.at);
      success = may_stay && out_[search.at].count == 0;
    } else {
      learn(number, search.at, success);
    }
    for (bool fresh = false; !success && !fresh;) {
      if (search.path.empty()) return ended(false);
      const std::uint32_t state = search.next();
      if (state == kNone) {
        search.leave();
      } else if (const auto value = known(number, state)) {
        success = *value;
      } else if (const std::uint32_t at = search.entered(state)) {
        success = may_stay;  // a circle
        search.path.back().low = std::min(search.path.back().low, at);
      } else {
        fresh = true;
        search.at = state;
      }
    }
    if (success) {
      search.succeed();
      return ended(true);
    }
    if (steps_ >= pause_at_) throw Hit{Local::pause};
  }
}

}  // namespace mcpn::search
