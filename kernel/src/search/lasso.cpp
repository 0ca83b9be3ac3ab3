#include "search/lasso.hpp"

#include <unordered_map>

#include "search/product.hpp"

namespace mcpn::search {

namespace {

class DepthFirst : public LassoSearch {
 public:
  DepthFirst(const PathTask& task, std::uint32_t bits, const LassoOptions& options)
      : task_(task), automaton_(task.automaton), options_(options), product_(task, bits, options.seed) {}

  Lasso go_on(std::uint64_t steps, const GoOn& still) override {
    still_ = &still;
    if (product_.size() == 0) {
      const std::uint32_t first = product_.begin(task_.initial);
      if (automaton_.accepting_all[0]) return {Lasso::found};
      if (enter(first, {kNone, 0}, 0)) return path();
    }
    for (const std::uint64_t until = count_ + steps; !frames_.empty(); ++count_) {
      if (count_ >= options_.max_steps) throw Limit{Lasso::steps};
      if (count_ >= until) return {Lasso::pause};
      if ((count_ & 0xFFF) == 0xFFF) watch();
      Frame& frame = frames_.back();
      if (steps_.size() == frame.begin) {
        leave();
        continue;
      }
      const Step step = steps_.back();
      steps_.pop_back();
      const AutomatonEdge& edge = product_.edge(frame.at, step);
      const auto [target, fresh] = product_.after(frame.at, step);
      if (automaton_.accepting_all[edge.target]) {
        Lasso decided = path();
        if (step.transition != kNone) decided.run.push_back(step.transition);
        return decided;
      }
      if (fresh) {
        if (enter(target, step, edge.marks)) return path();
      } else if (alive_[target]) {
        std::uint64_t marks = edge.marks;
        while (regions_.back().first > target) {
          marks |= regions_.back().marks | regions_.back().into;
          regions_.pop_back();
        }
        regions_.back().marks |= marks;
        if (regions_.back().marks == automaton_.marks) return closed();
      }
    }
    return {Lasso::none};
  }

 private:
  struct Frame {
    std::uint32_t at;
    std::size_t begin;  // of its steps
    Step by;            // that led to it
  };
  // A component as far as it is known: its first pair, the marks inside, those of the step that led to it.
  struct Region {
    std::uint32_t first;
    std::uint64_t marks, into;
  };

  bool enter(std::uint32_t at, Step by, std::uint64_t marks) {
    alive_.push_back(true);  // pairs are numbered in the order in which they are entered
    stack_.push_back(at);
    frames_.push_back({at, steps_.size(), by});
    regions_.push_back({at, 0, marks});
    return product_.expand(at, steps_);
  }
  void leave() {
    const std::uint32_t at = frames_.back().at;
    frames_.pop_back();
    if (regions_.back().first != at) return;
    regions_.pop_back();
    while (!stack_.empty() && stack_.back() >= at) {
      alive_[stack_.back()] = false;
      stack_.pop_back();
    }
  }
  void watch() {
    const std::uint64_t own = steps_.capacity() * sizeof(Step) + frames_.capacity() * sizeof(Frame) +
                              stack_.capacity() * 4 + alive_.capacity() / 8;
    if (product_.bytes() + own > options_.max_bytes) throw Limit{Lasso::bytes};
    if (!(*still_)()) throw Interrupted();
  }

  Lasso path(std::uint32_t last = kNone) const {
    Lasso found{Lasso::found};
    for (const Frame& frame : frames_) {
      if (frame.by.transition != kNone) found.run.push_back(frame.by.transition);
      if (frame.at == last) break;
    }
    return found;
  }
  // A run into the last component, and round it by all marks.
  Lasso closed() {
    const std::uint32_t first = regions_.back().first;
    Lasso found = path(first);
    const std::size_t cycle = found.run.size();
    std::uint64_t missing = automaton_.marks;
    std::uint32_t at = first;
    do {
      at = onward(at, found.run, [&](std::uint32_t, const AutomatonEdge& edge) {
        return automaton_.marks == 0 || (edge.marks & missing);
      }, first, missing);
    } while (missing);
    if (at != first)
      onward(at, found.run, [&](std::uint32_t target, const AutomatonEdge&) { return target == first; }, first, missing);
    if (found.run.size() > cycle) found.cycle = cycle;  // else nothing may fire
    return found;
  }
  // Appends a shortest run inside the last component to a step that is wanted, that one included.
  template <class Wanted>
  std::uint32_t onward(std::uint32_t from, std::vector<Transition>& run, Wanted wanted, std::uint32_t first,
                       std::uint64_t& missing) {
    std::unordered_map<std::uint32_t, std::pair<std::uint32_t, Transition>> came{{from, {from, kNone}}};
    std::vector<std::uint32_t> queue{from};
    std::vector<Step> steps;
    for (std::size_t i = 0; i < queue.size(); ++i) {
      const std::uint32_t at = queue[i];
      steps.clear();
      product_.expand(at, steps);
      if (i % 1024 == 1023) watch();
      for (const Step& step : steps) {
        const AutomatonEdge& edge = product_.edge(at, step);
        const std::uint32_t target = product_.after(at, step).first;
        if (target < first || target >= alive_.size() || !alive_[target]) continue;
        if (wanted(target, edge)) {
          std::vector<Transition> back;
          if (step.transition != kNone) back.push_back(step.transition);
          for (std::uint32_t q = at; q != from; q = came[q].first)
            if (came[q].second != kNone) back.push_back(came[q].second);
          run.insert(run.end(), back.rbegin(), back.rend());
          missing &= ~edge.marks;
          return target;
        }
        if (came.try_emplace(target, at, step.transition).second) queue.push_back(target);
      }
    }
    throw std::logic_error("a component leads to all of its steps");
  }

  const PathTask& task_;
  const Automaton& automaton_;
  LassoOptions options_;
  Product product_;
  const GoOn* still_ = nullptr;
  std::uint64_t count_ = 0;            // of steps so far
  std::vector<Frame> frames_;
  std::vector<Step> steps_;            // of the frames, those of the last one at the end
  std::vector<std::uint32_t> stack_;   // pairs whose component may still grow
  std::vector<bool> alive_;            // by pair: whether it is among them
  std::vector<Region> regions_;
};

}  // namespace

PathFinder::PathFinder(TokenNet net, Marking initial, Goals goals, std::vector<std::uint32_t> roots, Automaton automaton)
    : task_{std::move(net), std::move(initial), std::move(goals), std::move(roots), std::move(automaton)} {}

PathFinder::~PathFinder() = default;

Lasso PathFinder::search(const LassoOptions& options, std::uint64_t pause, const GoOn& still) {
  if (!search_ || options != options_) begin(options, 0);
  for (;;) {
    try {
      Lasso found = search_->go_on(pause, still);
      if (found.outcome != Lasso::pause) search_.reset();
      return found;
    } catch (const Limit& limit) {
      search_.reset();
      if (limit.outcome != Lasso::tokens || width_ + 1 == std::size(kWidths)) return {limit.outcome};
      begin(options, width_ + 1);  // wider where a place holds more than fits
    } catch (...) {
      search_.reset();
      throw;
    }
  }
}

void PathFinder::begin(const LassoOptions& options, std::size_t width) {
  options_ = options;
  width_ = width;
  search_.reset();
  search_ = options.guided ? guided(task_, kWidths[width], options)
                           : std::make_unique<DepthFirst>(task_, kWidths[width], options);
}

}  // namespace mcpn::search
