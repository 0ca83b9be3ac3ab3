// Markings packed with so many bits a place, found by hash and numbered in the order in which they were found.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <iterator>
#include <memory>
#include <utility>
#include <vector>

#include "search/tokens.hpp"
#include "words.hpp"

namespace mcpn::search {

constexpr std::uint32_t kNone = ~std::uint32_t(0);
constexpr std::uint32_t kWidths[] = {1, 4, 16, 32};  // bits of a place, tried one after the other

class Packed {
 public:
  using Row = std::vector<std::uint64_t>;

  Packed(std::uint32_t places, std::uint32_t bits)
      : bits_(bits), each_(64 / bits), words_(std::max(1u, (places + each_ - 1) / each_)), slots_(1u << 12, kNone) {}

  bool fits(Tokens tokens) const { return tokens < Tokens(1) << bits_; }
  bool fits(const Marking& marking) const {
    return std::all_of(marking.begin(), marking.end(), [&](Tokens tokens) { return fits(tokens); });
  }
  Tokens get(const Row& row, Place p) const { return Tokens(row[p / each_] >> p % each_ * bits_ & mask()); }
  void put(Row& row, Place p, Tokens tokens) const {
    const std::uint32_t shift = p % each_ * bits_;
    row[p / each_] = (row[p / each_] & ~(mask() << shift)) | std::uint64_t(tokens) << shift;
  }
  // Fires a rule that is enabled in a row; false where tokens do not fit, and the row is then of no use.
  bool fire(Row& row, const Rule& rule) const {
    for (const auto& [place, change] : rule.change) {
      const Tokens tokens = get(row, place) + change;
      if (!fits(tokens)) return false;
      put(row, place, tokens);
    }
    return true;
  }
  Row packed(const Marking& marking) const {
    Row row(words_, 0);
    for (Place p = 0; p < marking.size(); ++p) put(row, p, marking[p]);
    return row;
  }
  // The number of a marking, and whether it is new; then it has the next number.
  std::pair<std::uint32_t, bool> add(const Row& row) {
    std::uint64_t at = hash(row.data()) & (slots_.size() - 1);
    for (; slots_[at] != kNone; at = (at + 1) & (slots_.size() - 1))
      if (std::equal(row.begin(), row.end(), packed_.data() + slots_[at] * words_)) return {slots_[at], false};
    const auto number = std::uint32_t(count_++);
    slots_[at] = number;
    packed_.insert(packed_.end(), row.begin(), row.end());
    if (count_ * 3 > slots_.size() * 2) widen();
    return {number, true};
  }
  void get(std::uint32_t number, Row& row) const {
    row.assign(packed_.data() + number * words_, packed_.data() + (number + 1) * words_);
  }
  void get(std::uint32_t number, Marking& marking, Row& row) const {
    get(number, row);
    for (Place p = 0; p < marking.size(); ++p) marking[p] = get(row, p);
  }
  std::uint64_t size() const { return count_; }
  std::uint64_t bytes() const { return packed_.capacity() * 8 + slots_.capacity() * 4; }

 private:
  std::uint64_t hash(const std::uint64_t* row) const { return hash_words(row, words_); }
  void widen() {
    slots_.assign(slots_.size() * 2, kNone);
    for (std::uint64_t number = 0; number < count_; ++number) {
      std::uint64_t at = hash(packed_.data() + number * words_) & (slots_.size() - 1);
      while (slots_[at] != kNone) at = (at + 1) & (slots_.size() - 1);
      slots_[at] = std::uint32_t(number);
    }
  }
  std::uint64_t mask() const { return (std::uint64_t(1) << bits_) - 1; }

  std::uint32_t bits_, each_;  // bits of a place; places in a word
  std::uint64_t words_, count_ = 0;
  Row packed_;
  std::vector<std::uint32_t> slots_;
};

// Markings, and where each came from.
class Markings : public Packed {
 public:
  using Packed::Packed;
  bool add(const Row& row, std::uint32_t parent, Transition via) {
    const bool fresh = Packed::add(row).second;
    if (fresh) from_.emplace_back(parent, via);
    return fresh;
  }
  std::vector<Transition> run(std::uint32_t number) const {
    std::vector<Transition> found;
    for (; number != 0; number = from_[number].first) found.push_back(from_[number].second);
    std::reverse(found.begin(), found.end());
    return found;
  }
  std::uint64_t bytes() const { return Packed::bytes() + from_.capacity() * sizeof(from_[0]); }

 private:
  std::vector<std::pair<std::uint32_t, Transition>> from_;
};

// A search by markings so many bits a place, which begins anew with more where tokens do not fit.
template <class Narrow> class Widening : public GoalSearch {
 public:
  using Make = std::function<std::unique_ptr<Narrow>(std::uint32_t bits)>;
  explicit Widening(Make make) : make_(std::move(make)) {}

  Search search(std::uint64_t max_states, std::uint64_t max_bytes, const GoOn& go_on) override {
    max_states = std::min<std::uint64_t>(max_states, kNone - 1);
    while (true) {
      if (!narrow_) narrow_ = make_(kWidths[width_]);
      Search found = narrow_->search(max_states, max_bytes, go_on);
      if (found.outcome != Outcome::tokens || width_ + 1 == std::size(kWidths)) return found;
      narrow_.reset();
      ++width_;
    }
  }

 private:
  Make make_;
  std::unique_ptr<Narrow> narrow_;
  std::size_t width_ = 0;  // of kWidths
};

}  // namespace mcpn::search
