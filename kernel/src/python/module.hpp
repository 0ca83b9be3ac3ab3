// The parts of the Python module, each of which adds its types and functions.
#pragma once

#include <nanobind/nanobind.h>

void bind_diagrams(nanobind::module_& module);
void bind_orders(nanobind::module_& module);
void bind_explorer(nanobind::module_& module);
void bind_graph(nanobind::module_& module);
void bind_search(nanobind::module_& module);
void bind_steps(nanobind::module_& module);
