// One way to run a long operation on a store.
//
// Operations recurse as deep as there are levels. Where the calling thread's stack has room for that they run there,
// without the GIL, and look for signals themselves now and then: two threads that wake each other at each of many small
// operations take longer than these. Else they run on another thread with a stack to match, while the calling thread
// looks for signals.
#pragma once

#include <nanobind/nanobind.h>

#include <chrono>
#include <functional>

#include "diagrams/store.hpp"

// Who is told each second, with the GIL, by how many nodes live: within an operation, or before the next of many short
// ones. It may end them by an error.
struct Progress {
  nanobind::object told = nanobind::none();
  std::chrono::steady_clock::time_point due{};

  void wait() { due = std::chrono::steady_clock::now() + std::chrono::seconds(1); }
};

void run_operation(mcpn::Store& store, std::function<void()> body, Progress& progress);
