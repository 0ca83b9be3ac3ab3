#include "python/module.hpp"

#include "diagrams/store.hpp"

namespace nb = nanobind;
using namespace mcpn;

NB_MODULE(_kernel, module) {
  module.doc() = "Zero-suppressed decision diagrams with saturation, and explicit exploration, for 1-safe Petri nets.";
  // NOLINTBEGIN(bugprone-throw-keyword-missing,bugprone-unused-raii): each declares a class of Python in the module.
  nb::exception<BudgetExceeded>(module, "BudgetExceeded", PyExc_RuntimeError);
  nb::exception<MemoryLimit>(module, "MemoryLimit", PyExc_MemoryError);
  nb::exception<Cancelled>(module, "Cancelled", PyExc_RuntimeError);
  // NOLINTEND(bugprone-throw-keyword-missing,bugprone-unused-raii)

#ifndef __SANITIZE_ADDRESS__
  // A daemon thread that still runs when the interpreter ends, such as those of dask, never lets go of what it uses:
  // that is no fault, and the system takes the memory back. Builds with sanitizers keep the warnings.
  nb::set_leak_warnings(false);
#endif

  bind_explorer(module);
  bind_graph(module);
  bind_search(module);
  bind_orders(module);
  bind_diagrams(module);
  bind_steps(module);
}
