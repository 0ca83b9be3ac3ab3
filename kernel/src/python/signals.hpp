// Signals in loops that run on the calling thread without the GIL.
#pragma once

#include <nanobind/nanobind.h>

#include <chrono>
#include <cstddef>

// Told of all work; an exception of a signal's handler, such as Ctrl-C, is thrown from there.
class Signals {
 public:
  void after(std::size_t work) {
    if ((done_ += work) >= kWork) look();
  }

 private:
  static constexpr std::size_t kWork = 1u << 16;  // edges or states from one look at the clock to the next
  static constexpr std::chrono::milliseconds kPause{50};

  void look() {
    done_ = 0;
    const auto now = std::chrono::steady_clock::now();
    if (now < next_) return;
    next_ = now + kPause;
    const nanobind::gil_scoped_acquire acquire;
    if (PyErr_CheckSignals() != 0) throw nanobind::python_error();
  }

  std::size_t done_ = 0;
  std::chrono::steady_clock::time_point next_{};
};
