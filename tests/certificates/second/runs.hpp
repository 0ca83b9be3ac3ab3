// Runs of a net, followed firing by firing.
#pragma once

#include "markings.hpp"

class Runs {
 public:
  Runs(const Net& net, const Markings& markings) : net_(net), markings_(markings) {}

  bool has_ended(const Marked& marking, const std::set<std::string>& roles) const {
    for (std::size_t p = 0; p < marking.size(); ++p) if (marking[p] && markings_.is_end(p, roles)) return true;
    return false;
  }
  // The marking after a run; none where it cannot be followed.
  std::optional<Marked> after(const Json& run) const {
    Marked in;
    for (const Place& place : net_.places) in.push_back(place.initial);
    settle(in);
    for (const Int t : numbers(run)) {
      if (t < 0 || t >= Int(net_.transitions.size())) return std::nullopt;
      const Transition& of = net_.transitions[std::size_t(t)];
      if (of.internal() || !is_covered(of, in)) return std::nullopt;
      fire(of, in);
      settle(in);
    }
    return in;
  }
  bool is_stuck(const std::optional<Marked>& in) const {
    if (!in || has_ended(*in, kEnds)) return false;
    return std::none_of(markings_.events.begin(), markings_.events.end(), [&](std::size_t t) { return is_covered(net_.transitions[t], *in); });
  }

 private:
  static bool is_covered(const Transition& t, const Marked& in) {
    const auto marked = [&](Int place) { return bool(in[std::size_t(place)]); };
    return std::all_of(t.consume.begin(), t.consume.end(), marked) && std::all_of(t.read.begin(), t.read.end(), marked);
  }
  static void fire(const Transition& t, Marked& in) {
    for (const Int place : t.consume) in[std::size_t(place)] = false;
    for (const Int place : t.produce) in[std::size_t(place)] = true;
  }
  void settle(Marked& in) const {
    for (int steps = 0;; ++steps) {
      if (steps > 100'000) throw Limit("more than 100,000 internal firings in a row");
      const std::size_t* next = nullptr;
      for (auto rank = markings_.ranks.begin(); !next && rank != markings_.ranks.end(); ++rank)
        for (const std::size_t& t : *rank) if (!next && is_covered(net_.transitions[t], in)) next = &t;
      if (!next) return;
      fire(net_.transitions[*next], in);
    }
  }

  const Net& net_;
  const Markings& markings_;
};
