// What becomes of each claim of an entry: a line for each, and the exit code.
#pragma once

#include "command.hpp"
#include "json.hpp"

// Judges each claim, where there is something to judge it by; else `why` says why there is none. A claim's limit leaves it open.
template <class Judge> int each_claim(const std::vector<Json>& claims, std::string why, Judge judge) {
  const bool asked = why.empty();
  bool refuted = false, open = claims.empty();
  for (const Json& each : claims) {
    std::string verdict = "not checked";
    if (asked) {
      try {
        verdict = judge(each) ? "proved" : "refuted";
      } catch (const Refuted&) {
        verdict = "refuted";
      } catch (const Limit& limit) {
        why = limit.what();
      }
    }
    refuted = refuted || verdict == "refuted";
    open = open || verdict == "not checked";
    std::cout << verdict << ' ' << each.at("key").string << '\n';
  }
  if (!why.empty()) std::cerr << "not checked: " << why << '\n';
  return refuted ? 1 : open ? 2 : 0;
}
