// One way to run a long operation on a store.
//
// Operations recurse as deep as there are levels. Where the calling thread's stack has room for that they run there,
// without the GIL, and look for signals themselves now and then: two threads that wake each other at each of many small
// operations take longer than these. Else they run on another thread with a stack to match, while the calling thread
// looks for signals.
#pragma once

#include <nanobind/nanobind.h>

#include <chrono>
#include <ctime>
#include <functional>
#include <utility>

#include "diagrams/store.hpp"

// Who is told, with the GIL, by how many nodes live, each time that the process has worked for so long: within an
// operation, or before the next of many short ones. It may end them by an error, so that slices are of CPU time.
class Progress {
 public:
  void tell(nanobind::object told) {
    told_ = std::move(told);
    due_ = std::clock() + kWork;
  }
  const nanobind::object& told() const { return told_; }
  // Whether it is time again. The clock of the system is looked at first, which is no call of it.
  bool due() {
    if (told_.is_none()) return false;
    const auto now = std::chrono::steady_clock::now();
    if (now < look_) return false;
    look_ = now + kLook;
    const std::clock_t worked = std::clock();
    if (worked < due_) return false;
    due_ = worked + kWork;
    return true;
  }

 private:
  static constexpr std::clock_t kWork = CLOCKS_PER_SEC / 100;
  static constexpr std::chrono::milliseconds kLook{5};

  nanobind::object told_ = nanobind::none();
  std::clock_t due_ = 0;
  std::chrono::steady_clock::time_point look_{};
};

void run_operation(mcpn::Store& store, std::function<void()> body, Progress& progress);
