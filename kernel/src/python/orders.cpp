// Orders of places for Python.
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <stdexcept>

#include "diagrams/orders.hpp"
#include "python/module.hpp"

namespace nb = nanobind;
using namespace mcpn;

namespace {

void check_order(const Groups& groups, const std::vector<std::uint32_t>& start) {
  std::vector<std::uint32_t> sorted = start;
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t i = 0; i < sorted.size(); ++i)
    if (sorted[i] != i) throw std::invalid_argument("an order holds each number once");
  for (const auto& group : groups)
    for (const std::uint32_t member : group)
      if (member >= start.size()) throw std::invalid_argument("a group holds numbers of the order");
}

}  // namespace

void bind_orders(nb::module_& module) {
  module.def("force", [](const Groups& groups, const std::vector<std::uint32_t>& start, unsigned rounds) {
    check_order(groups, start);
    const nb::gil_scoped_release release;
    return force(groups, start, rounds);
  }, nb::arg("groups"), nb::arg("start"), nb::arg("rounds"));
  module.def("closing", [](const Groups& groups, const std::vector<std::uint32_t>& start) {
    check_order(groups, start);
    const nb::gil_scoped_release release;
    return closing(groups, start);
  }, nb::arg("groups"), nb::arg("start"));
  module.def("sloan", [](const Groups& groups, const std::vector<std::uint32_t>& start) {
    check_order(groups, start);
    const nb::gil_scoped_release release;
    return sloan(groups, start);
  }, nb::arg("groups"), nb::arg("start"));
  module.def("clustered", [](const Groups& groups, const std::vector<std::uint32_t>& start) {
    check_order(groups, start);
    const nb::gil_scoped_release release;
    return clustered(groups, start);
  }, nb::arg("groups"), nb::arg("start"));
}
