// Whole numbers without a bound.
#pragma once

#include "json.hpp"

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
