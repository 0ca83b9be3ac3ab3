// What sets of markings prove by where firings lead from them: that they are closed, that runs end, that layers lead to an end.
#pragma once

#include "markings.hpp"

class Closures {
 public:
  Closures(const Net& net, const Diagrams& given, const Markings& markings, Families& families) : net_(net), given_(given), markings_(markings), families_(families) {}

  // Calls with each transition and those of a set in which it may fire.
  template <class Then> void firing(Node set, Then then) const {
    const Node stable = markings_.internally(set, then);
    for (const std::size_t t : markings_.events) if (const Node here = markings_.covered(stable, t)) then(t, here);
  }
  bool is_closed(Node set, bool with_events) const {
    bool closed = true;
    const auto leads = [&](std::size_t t, Node here) { closed = closed && families_.within(markings_.fired(here, t), set); };
    if (with_events) firing(set, leads);
    else markings_.internally(set, leads);
    return closed;
  }
  bool runs_end() {
    return once(ends_, [&] {
      if (given_.weights.size() != net_.places.size()) return false;
      bool again = false;
      for (std::size_t t = 0; t < net_.transitions.size(); ++t) {
        const Transition& of = net_.transitions[t];
        if (!of.internal()) continue;
        if (given_.again.count(Int(t))) { again = true; continue; }
        Wide more = 0;
        for (const Int place : of.produce) more += given_.weights[std::size_t(place)];
        for (const Int place : of.consume) more -= given_.weights[std::size_t(place)];
        if (more >= 0) return false;
      }
      bool fine = true;
      Node before = 0;
      for (const Node layer : given_.layers) {
        markings_.internally(layer, [&](std::size_t t, Node here) {
          fine = fine && families_.within(markings_.fired(here, t), given_.again.count(Int(t)) ? before : layer);
        });
        before = layer;
      }
      if (again && given_.layers.empty()) return false;
      return fine && (given_.layers.empty() || families_.within(given_.reached, before));
    });
  }
  bool lead_to(const std::vector<Node>& layers, const std::set<std::string>& roles, const std::vector<std::size_t>& events) {
    if (!runs_end()) return false;
    Node before = 0;
    for (const Node layer : layers) {
      if (!is_closed(layer, false)) return false;
      Node left = markings_.internally(layer, [](std::size_t, Node) {});
      left = families_.less(families_.less(left, markings_.ending(left, roles)), before);
      for (const std::size_t t : events) left = families_.less(left, markings_.before(before, t));
      if (left) return false;
      before = layer;
    }
    return true;
  }

 protected:
  template <class Is> static bool once(std::optional<bool>& known, Is is) {
    if (!known) known = is();
    return *known;
  }

  const Net& net_;
  const Diagrams& given_;
  const Markings& markings_;
  Families& families_;

 private:
  std::optional<bool> ends_;
};
