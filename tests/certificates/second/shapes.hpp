// The shape of formulas of CTL*: which operators there are, on states and on paths, and what their parts are.
#pragma once

#include "json.hpp"

// Refuses what is no formula on states, or on paths, of a net with so many places.
inline void shape_of_formula(const Json& of, Int places, bool on_paths = false, int depth = 0) {
  require(depth < 1000, "a formula that is nested too deep");
  const auto& parts = list(of);
  require(!parts.empty(), "an empty formula");
  const std::string& op = text(parts[0]);
  const auto rest = [&](std::size_t count, bool paths) {
    require(count == 0 || parts.size() == count + 1, "a formula with other parts: " + op);
    for (std::size_t i = 1; i < parts.size(); ++i) shape_of_formula(parts[i], places, paths, depth + 1);
  };
  if (op == "says") {
    require(texts(of).size() == 3, "a formula with other parts: says");
  } else if (op == "at most") {
    require(parts.size() == 3, "a formula with other parts: at most");
    whole(parts[1]);
    for (const Json& each : list(parts[2])) {
      const Numbers pair = numbers(each);
      require(pair.size() == 2 && pair[0] >= 0 && pair[0] < places, "no weight of a place");
    }
  } else if (op == "fires" || (op == "happens" && on_paths)) {
    for (std::size_t i = 1; i < parts.size(); ++i) texts(parts[i]);
  } else if (op == "deadlock") {
    rest(0, false);
    require(parts.size() == 1, "a formula with other parts: deadlock");
  } else if (op == "not") {
    rest(1, on_paths);
  } else if (op == "and" || op == "or") {
    rest(0, on_paths);
  } else if (op == "EX" || op == "EG") {
    rest(1, false);
  } else if (op == "EU") {
    rest(2, false);
  } else if (op == "E") {
    rest(1, true);
  } else if (on_paths && op == "X") {
    rest(1, true);
  } else if (on_paths && (op == "U" || op == "R")) {
    rest(2, true);
  } else {
    malformed("a formula that is none: " + op);
  }
}
