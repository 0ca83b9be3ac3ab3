// Explicit exploration of nets with several tokens in a place: a marking is a row of words, a field for each place.
#pragma once

#include "markings/explorer.hpp"

namespace mcpn {

class CountedNet {
 public:
  struct Field { std::uint32_t word, shift, width; };  // of at most 63 bits
  struct Arc { std::uint32_t place; std::int64_t tokens; };
  struct Rule {
    std::vector<Arc> need, change;  // tokens wanted; tokens added, or taken
    std::uint16_t rank;             // with priorities, those of the lowest rank that is enabled may fire
  };

  CountedNet(std::vector<Field> fields, std::uint32_t words, std::vector<Rule> rules, bool priorities);

  // The same marking, which fits into the fields.
  const std::vector<std::int64_t>& checked(const std::vector<std::int64_t>& marking) const;

  // Every reachable marking, breadth first, priorities respected. A firing that does not fit into the fields ends it.
  Exploration explore(const std::vector<std::int64_t>& initial, bool edges, const Limits& limits) const;

 private:
  std::int64_t tokens(const Word* marking, std::uint32_t place) const {
    const Field& field = fields_[place];
    return std::int64_t(marking[field.word] >> field.shift & ((Word(1) << field.width) - 1));
  }
  bool covers(const Word* marking, const Rule& rule) const {
    for (const Arc& arc : rule.need)
      if (tokens(marking, arc.place) < arc.tokens) return false;
    return true;
  }
  bool fire(Word* marking, const Rule& rule) const;  // false: it does not fit

  std::vector<Field> fields_;
  std::uint32_t words_;
  std::vector<Rule> rules_;            // without priorities all of one rank
  std::vector<std::uint32_t> by_rank_;  // the rules in the order of their ranks
};

}  // namespace mcpn
