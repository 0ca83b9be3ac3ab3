// Calls that recurse as deep as a store has levels: on a thread whose stack has room for them.
#pragma once

#include <chrono>
#include <cstddef>
#include <exception>
#include <functional>
#include <memory>

// A thread with a deep stack that makes one call after the other.
//
// One that has no call stands ready for the next who asks; one more, which a call made meanwhile needed (from another
// thread, or by what a call's caller does while it waits), ends after its call. The one that stands ready is joined at
// the end of the process. A child of os.fork has none and makes its own.
class DeepStack {
 public:
  // One with at least so many bytes; throws std::system_error where the system makes none.
  static std::unique_ptr<DeepStack> take(std::size_t bytes);
  // Leaves one that has no call to the next who asks.
  static void leave(std::unique_ptr<DeepStack> stack);

  ~DeepStack();  // joins the thread, which has no call
  DeepStack(const DeepStack&) = delete;
  DeepStack& operator=(const DeepStack&) = delete;

  void begin(std::function<void()> body);
  bool ended(std::chrono::milliseconds within);  // waits for the end of the call, so long at most
  std::exception_ptr end();                      // what the call threw, once it has ended

 private:
  struct Thread;
  explicit DeepStack(std::size_t bytes);
  std::unique_ptr<Thread> thread_;
};
