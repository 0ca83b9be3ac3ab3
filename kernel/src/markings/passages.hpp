// Which activities leave an alternative, or come to rest, as events run to completion.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "markings/explorer.hpp"

namespace mcpn {

// The edges of stable markings, run to completion again in one order: the lowest internal transition of the first rank
// first. An activity is *left* where a transition that leaves one of its alternatives fires; it has *idled* where it
// rests in a marking from that firing on.
class Passages {
 public:
  using Activities = std::vector<std::uint32_t>;
  struct Control { std::vector<std::uint32_t> places, at_rest; };  // of an activity: its places, those marked at rest
  struct Kind {
    Activities left, idled;
    bool operator<(const Kind& other) const {
      return left != other.left ? left < other.left : idled < other.idled;
    }
  };
  static constexpr std::uint32_t kElsewhere = ~std::uint32_t(0);  // an edge that does not end in its target

  // By transition, the activities of which it leaves an alternative.
  Passages(const SafeNet& net, std::vector<Activities> leaving, const std::vector<Control>& control);

  // By edge, the number of its kind. Markings are rows of words.
  std::vector<std::uint32_t> of(const Word* markings, std::size_t states, const std::int64_t* offsets,
                                const std::int64_t* targets, const std::uint32_t* events, const Limits& limits);
  const std::vector<Kind>& kinds() const { return kinds_; }

 private:
  struct Part { std::uint32_t word; Word places, at_rest; };

  bool run(std::uint32_t event);
  void fire(std::uint32_t t);
  bool rests(std::uint32_t activity) const;

  const SafeNet& net_;
  const std::vector<Activities> leaving_;
  std::vector<std::vector<Part>> control_;
  std::vector<Word> marking_, enabled_;
  Kind kind_;
  Activities running_;  // those left that have not idled
  std::vector<Kind> kinds_;
};

}  // namespace mcpn
