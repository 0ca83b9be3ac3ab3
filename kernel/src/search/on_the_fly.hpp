// CTL by looking at markings as they are needed, in nets with any number of tokens in a place.
//
// A formula is evaluated depth first at the initial marking; an operator is asked at those markings only on
// which its value at the first one depends. Until and always are decided at every marking that the search for
// them has come to, so that each is asked once at each marking (B. Vergauwen, J. Lewi, A linear local model
// checking algorithm for CTL, CONCUR 1993; the components are R. E. Tarjan's, 1972).
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "search/packed.hpp"

namespace mcpn::search {

// Paths are maximal: endless, or ending in a marking in which nothing may fire.
struct Operator {
  enum Kind : std::uint8_t { goal, negation, all, any, next, until, always } kind;
  std::vector<std::uint32_t> inside;  // operators before this one; of a goal, its node among the goals
};

enum class Local : std::uint8_t { no, yes, steps, bytes, tokens, pause };

constexpr std::uint64_t kLook = 1u << 12;  // steps from one look at signals and memory, or pause, to the next

class Checker {
 public:
  Checker(const TokenNet& net, const Marking& initial, const Goals& goals, std::vector<Operator> operators,
          std::uint64_t max_bytes);
  ~Checker();

  // Whether an operator holds at the initial marking, or the limit that was hit. What is found out is kept for
  // other operators, and for the same with more steps. After so many steps to a pause it rests: asked the same
  // again, it goes on from there; asked anything else, it forgets where it was.
  Local decide(std::uint32_t root, std::uint64_t max_steps, std::uint64_t seed, std::uint64_t pause, const GoOn& go_on);

  std::uint64_t markings() const { return packed_->size(); }
  std::size_t operators() const { return operators_.size(); }

 private:
  struct Edge { Transition transition; std::uint32_t target; };  // the target is kNone until it is asked for
  struct Out { std::uint64_t begin; std::uint32_t count = kNone; };
  struct Frame { std::uint32_t state, next, first, low; };
  struct Search;
  enum class Met : std::uint8_t { wall, way, end };  // what a search does with a marking: turn back, go on, succeed

  void begin();
  void forget();
  bool holds(std::uint32_t number, std::uint32_t state);
  bool holds_goal(std::uint32_t node, std::uint32_t state);
  bool until(std::uint32_t number, std::uint32_t state);
  bool always(std::uint32_t number, std::uint32_t state);
  template <class Look> bool search(std::uint32_t number, std::uint32_t start, bool may_stay, Look look);
  const Out& expand(std::uint32_t state);
  std::uint32_t target(std::uint32_t state, std::uint32_t edge);
  std::optional<bool> known(std::uint32_t number, std::uint32_t state) const;
  void learn(std::uint32_t number, std::uint32_t state, bool value);
  void step();
  std::uint64_t bytes() const;

  TokenNet net_;
  Marking initial_;
  Goals goals_;
  std::vector<Operator> operators_;
  std::uint64_t max_bytes_, steps_ = 0, most_steps_ = 0, pause_at_ = 0, seed_ = 0;
  std::uint32_t root_ = 0;
  bool paused_ = false;
  std::size_t width_ = 0;  // of kWidths
  const GoOn* go_on_ = nullptr;
  std::unique_ptr<Packed> packed_;
  std::vector<Out> out_;                           // by marking
  std::vector<Edge> edges_;
  std::vector<std::vector<std::uint64_t>> values_;  // by operator: two bits for each marking, known and true
  std::vector<std::unique_ptr<Search>> searches_;  // by depth
  std::size_t depth_ = 0;
  Marking marking_;
  Packed::Row row_;
  std::vector<Transition> enabled_;
};

}  // namespace mcpn::search
