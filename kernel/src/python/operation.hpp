// One way to run a long operation on a store.
//
// Operations recurse as deep as there are levels. Where the calling thread's stack has room for that they run there,
// without the GIL, and look for signals themselves now and then: two threads that wake each other at each of many small
// operations take longer than these. Else they run on another thread with a stack to match, while the calling thread
// looks for signals.
#pragma once

#include <nanobind/nanobind.h>

#include <functional>

#include "diagrams/store.hpp"

// Told now and then, with the GIL, by how many nodes live.
void run_operation(mcpn::Store& store, std::function<void()> body, const nanobind::object& progress);
