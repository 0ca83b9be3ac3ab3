// Numbers and rates as claims on probabilities write them.
#pragma once

#include "big.hpp"

inline void need(bool holds) { if (!holds) throw Refuted("a value of the right type that says nothing"); }

const Big kOne("1" + std::string(40, '0'));  // numbers are counted in parts of 10^-40

inline Big number(const Json& of) {
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

inline Rate rate(const Json& of) {
  need(of.items.size() == 2);
  Rate made{number(of.items[0]), number(of.items[1])};
  need((made.least.sign() == 0) == (made.most.sign() == 0) && (made.most - made.least).sign() >= 0);
  return made;
}
