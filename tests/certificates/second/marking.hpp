// A set of places, a bit each: a marking, or what a transition needs, takes and puts.
#pragma once

#include "net.hpp"

class Marking {
 public:
  explicit Marking(std::size_t places = 0) : words_((places + 63) / 64) {}
  Marking(std::size_t places, const Numbers& marked) : Marking(places) { for (const Int place : marked) add(std::size_t(place)); }

  bool operator[](std::size_t place) const { return words_[place / 64] >> place % 64 & 1; }
  void add(std::size_t place) { words_[place / 64] |= std::uint64_t(1) << place % 64; }
  bool operator==(const Marking& other) const { return words_ == other.words_; }
  bool operator!=(const Marking& other) const { return words_ != other.words_; }
  bool holds(const Marking& all) const { return every([](std::uint64_t own, std::uint64_t of) { return (of & ~own) == 0; }, all); }
  bool meets(const Marking& some) const { return !every([](std::uint64_t own, std::uint64_t of) { return (own & of) == 0; }, some); }
  Marking& operator|=(const Marking& other) { return changed([](std::uint64_t own, std::uint64_t of) { return own | of; }, other); }
  Marking& operator&=(const Marking& other) { return changed([](std::uint64_t own, std::uint64_t of) { return own & of; }, other); }
  Marking& operator-=(const Marking& other) { return changed([](std::uint64_t own, std::uint64_t of) { return own & ~of; }, other); }

  struct Hash {
    std::size_t operator()(const Marking& of) const {
      std::uint64_t found = 0;
      for (const std::uint64_t word : of.words_) found = (found ^ word) * 0x9e3779b97f4a7c15, found ^= found >> 32;
      return found;
    }
  };

 private:
  template <class Is> bool every(Is is, const Marking& with) const {
    for (std::size_t i = 0; i < words_.size(); ++i) if (!is(words_[i], with.words_[i])) return false;
    return true;
  }
  template <class Made> Marking& changed(Made made, const Marking& by) {
    for (std::size_t i = 0; i < words_.size(); ++i) words_[i] = made(words_[i], by.words_[i]);
    return *this;
  }

  std::vector<std::uint64_t> words_;
};
