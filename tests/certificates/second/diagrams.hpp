// What diagrams.json holds: the order of places, and families of their markings.
#pragma once

#include "families.hpp"

struct Partner { Int place, of; };

struct Diagrams {
  Numbers order, weights;
  std::vector<Partner> partners;
  std::vector<Node> nodes, pairs;  // by their number in the entry
  std::set<Int> again;
  Node reached = 0, ends = 0;
  std::vector<Node> layers;
};

inline Node node_of(const Json& of, const std::vector<Node>& nodes) {
  require(whole(of) >= 0 && whole(of) < Int(nodes.size()), "no such node");
  return nodes[std::size_t(of.value)];
}
inline std::vector<Node> layers_of(const Json& of, const std::vector<Node>& nodes) {
  std::vector<Node> found;
  for (const Json& each : list(of)) found.push_back(node_of(each, nodes));
  return found;
}

inline std::vector<Node> nodes_of(const Json& of, std::size_t levels, Families& families) {
  std::vector<Node> found{0, 1};
  std::vector<Int> level{Int(levels), Int(levels)};
  for (const Json& each : list(of)) {
    const Numbers row = numbers(each);
    require(row.size() == 3 && row[0] >= 0 && row[0] < Int(levels), "a node of no level");
    for (const Int child : {row[1], row[2]})
      require(child >= 0 && child < Int(found.size()) && level[std::size_t(child)] > row[0], "a node out of order");
    require(row[2] != 0, "a node with nothing above");
    found.push_back(families.node(std::uint32_t(row[0]), found[std::size_t(row[1])], found[std::size_t(row[2])]));
    level.push_back(row[0]);
  }
  return found;
}

inline Diagrams diagrams_of(const Json& of, const Net& net, Families& families) {
  Diagrams made;
  const Int places = Int(net.places.size());
  made.order = numbers(of.at("order"));
  made.weights = numbers(of.at("weights"));
  std::set<Int> once;
  for (const Int place : made.order) require(place >= 0 && place < places && once.insert(place).second, "a place twice, or none");
  const std::set<Int> ordered = once;
  for (const Json& each : list(of.at("partners"))) {
    const Numbers pair = numbers(each);
    require(pair.size() == 2 && pair[0] >= 0 && pair[0] < places && ordered.count(pair[1]) > 0 && once.insert(pair[0]).second, "partners that are none");
    made.partners.push_back({pair[0], pair[1]});
  }
  require(Int(once.size()) == places, "a place that nothing says");
  for (const Int t : numbers(of.at("again"))) {
    require(t >= 0 && t < Int(net.transitions.size()), "no such transition");
    made.again.insert(t);
  }
  made.nodes = nodes_of(of.at("nodes"), made.order.size(), families);
  made.pairs = nodes_of(of.at("pairs"), 2 * made.order.size(), families);
  made.reached = node_of(of.at("reached"), made.nodes);
  made.layers = layers_of(of.at("layers"), made.nodes);
  made.ends = node_of(of.at("ends"), made.pairs);
  return made;
}
