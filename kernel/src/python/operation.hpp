// One way to run a long operation on a store.
//
// Operations recurse as deep as there are levels. Where that is deep they run on another thread with a stack
// to match, while the calling thread looks for signals; else they run on the calling thread, without the GIL, and
// look for signals themselves now and then.
#pragma once

#include <nanobind/nanobind.h>

#include <functional>

#include "diagrams/store.hpp"

// Told now and then, with the GIL, by how many nodes live.
void run_operation(mcpn::Store& store, std::function<void()> body, const nanobind::object& progress);
