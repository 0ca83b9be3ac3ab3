#include "markings/counted.hpp"

#include <algorithm>
#include <numeric>

#include "diagrams/store.hpp"
#include "markings/state_table.hpp"

namespace mcpn {

CountedNet::CountedNet(std::vector<Field> fields, std::uint32_t words, std::vector<Rule> rules, bool priorities)
    : fields_(std::move(fields)), words_(words), rules_(std::move(rules)), by_rank_(rules_.size()) {
  if (!priorities)
    for (Rule& rule : rules_) rule.rank = 0;
  std::iota(by_rank_.begin(), by_rank_.end(), 0u);
  std::stable_sort(by_rank_.begin(), by_rank_.end(),
                   [&](std::uint32_t t, std::uint32_t u) { return rules_[t].rank < rules_[u].rank; });
}

const std::vector<std::int64_t>& CountedNet::checked(const std::vector<std::int64_t>& marking) const {
  if (marking.size() != fields_.size()) throw std::invalid_argument("tokens for each place");
  for (std::size_t p = 0; p < marking.size(); ++p)
    if (marking[p] < 0 || marking[p] >> fields_[p].width) throw std::invalid_argument("tokens beyond a field");
  return marking;
}

bool CountedNet::fire(Word* marking, const Rule& rule) const {
  for (const Arc& arc : rule.change) {
    const Field& field = fields_[arc.place];
    const std::int64_t after = tokens(marking, arc.place) + arc.tokens;
    if (after >> field.width) return false;
    marking[field.word] += Word(arc.tokens) << field.shift;  // stays inside the field, as just seen
  }
  return true;
}

Exploration CountedNet::explore(const std::vector<std::int64_t>& initial, bool edges, const Limits& limits) const {
  Exploration found;
  found.words = words_;
  found.bounds.assign(fields_.size(), 0);
  StateTable table(found, limits);
  std::vector<Word> marking(words_, 0), after(words_);
  for (std::uint32_t p = 0; p < fields_.size(); ++p) marking[fields_[p].word] |= Word(initial[p]) << fields_[p].shift;
  table.number(marking.data(), 0, 0);
  std::vector<std::uint32_t> enabled;
  if (edges) found.offsets.push_back(0);
  for (State state = 0; state < found.states(); ++state) {
    std::copy_n(found.markings.data() + std::uint64_t(state) * words_, words_, marking.data());
    std::uint64_t sum = 0;
    for (std::uint32_t p = 0; p < fields_.size(); ++p) {
      const auto here = std::uint64_t(tokens(marking.data(), p));
      found.bounds[p] = std::max(found.bounds[p], here);
      sum += here;
    }
    found.most_tokens = std::max(found.most_tokens, sum);
    enabled.clear();
    for (const std::uint32_t t : by_rank_) {
      if (!enabled.empty() && rules_[t].rank != rules_[enabled.front()].rank) break;
      if (covers(marking.data(), rules_[t])) enabled.push_back(t);
    }
    found.stable += enabled.empty() || rules_[enabled.front()].rank == kEvents;
    found.dead += enabled.empty();
    for (const std::uint32_t t : enabled) {
      after = marking;
      if (!fire(after.data(), rules_[t])) {
        found.trouble = {state, {t}, "unsafe"};
        return found;
      }
      const State target = table.number(after.data(), state, t);
      if ((++found.edges & 0xFFFF) == 0 && !limits.go_on(found.states(), found.edges)) throw Interrupted();
      if (edges) {
        table.grow(found.targets, 1);
        table.grow(found.labels, 1);
        found.targets.push_back(target);
        found.labels.push_back(t);
      }
    }
    if (edges) {
      table.grow(found.offsets, 1);
      found.offsets.push_back(found.edges);
    }
    if ((state & 0x3FF) == 0x3FF && !limits.go_on(found.states(), found.edges)) throw Interrupted();
  }
  return found;
}

}  // namespace mcpn
