// What steps lead to from some states, whichever way they are followed.
#pragma once

#include "basics.hpp"

// Adds to states what steps lead to: `next` is given a state and calls back with each state that a step from it leads to.
template <class Next> std::vector<bool> grown(std::vector<bool> seen, const Next& next) {
  std::vector<std::size_t> open;
  for (std::size_t s = 0; s < seen.size(); ++s) if (seen[s]) open.push_back(s);
  while (!open.empty()) {
    const std::size_t s = open.back();
    open.pop_back();
    next(s, [&](std::size_t to) { if (!seen[to]) { seen[to] = true; open.push_back(to); } });
  }
  return seen;
}
