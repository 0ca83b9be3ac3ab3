// A set of markings of which the first levels are set aside while transitions fire that touch later ones alone.
#pragma once

#include <vector>

#include "diagrams/store.hpp"

namespace mcpn {

// An image walks over all of a diagram above the levels that it changes, and makes these nodes anew. So the diagram is cut
// at a level. The parts below, each once, become one diagram, which tells them apart by binary numbers on the first levels;
// an operation that looks at no level before the cut does the same to this one as to the whole. Afterwards the nodes above
// are put back. There is a cut every few levels: to go from one level to another takes as long as there are nodes between
// them. This is the zipper (Huet, The Zipper, Journal of Functional Programming 1997) of a shared diagram.
class Narrowed {
 public:
  Narrowed(Store& store, Node whole) : store_(store), at_(store, whole) {}
  ~Narrowed() {
    for (const Above& above : above_) store_.drop(above.top);
  }
  Narrowed(const Narrowed&) = delete;
  Narrowed& operator=(const Narrowed&) = delete;

  Level cut() const { return above_.empty() ? 0 : above_.back().cut; }
  // The diagram cut as low as all levels from one on allow; what looks at a level before `cut` may not be asked of it.
  Node from(Level first);
  // The same where it is cut already, or higher.
  Node covering(Level first);
  Node whole() { return covering(0); }
  void become(Node node) { at_ = node; }  // that which is cut as it is now

 private:
  static constexpr Level kBetween = 16;  // levels from one cut to the next
  struct Above {
    Node top;  // kept
    Level cut;
    std::vector<Node> parts;
  };
  bool narrow(Level cut);
  void widen();
  Node numbered(const std::vector<Node>& parts, Level bit, std::size_t first, std::size_t last);
  void unnumbered(Node node, Level bit, std::vector<Node>& parts, std::size_t first, std::size_t last) const;

  Store& store_;
  Held at_;
  std::vector<Above> above_;
};

}  // namespace mcpn
