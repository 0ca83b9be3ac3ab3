#include "python/operation.hpp"

#include <chrono>
#include <exception>
#include <memory>
#include <system_error>
#include <utility>

#include "python/deep_stack.hpp"
#include "python/stack_room.hpp"

namespace nb = nanobind;
using namespace mcpn;

namespace {

constexpr std::size_t kStackPerLevel = 2048;  // of calls that recurse by level, one inside the other
constexpr std::size_t kStackBase = 8u << 20;  // of a thread beside that; lazily committed by the system
constexpr std::chrono::milliseconds kLook{10};  // from one look at signals and progress to the next
constexpr std::size_t kCallersBase = 1u << 20;  // of a caller's stack beside that: signals' handlers and progress run there

// Tells the caller of a long operation that it goes on, and hears whether it should: with the GIL.
class Watch {
 public:
  Watch(const Store& store, Progress& progress) : store_(store), progress_(progress) {}
  // Whether it is time again: the GIL is not to be asked for at every look.
  bool due() {
    const auto now = std::chrono::steady_clock::now();
    if (now < next_) return false;
    next_ = now + kLook;
    return true;
  }
  bool must_stop() {
    return PyErr_CheckSignals() != 0 || told_to_stop();
  }
  bool told_to_stop() {
    if (!progress_.due()) return false;
    PyObject* told = PyObject_CallFunction(progress_.told().ptr(), "K", static_cast<unsigned long long>(store_.live()));
    Py_XDECREF(told);
    return told == nullptr;
  }

 private:
  const Store& store_;
  Progress& progress_;
  std::chrono::steady_clock::time_point next_{};
};

void run_here(Store& store, const std::function<void()>& body, Watch& watch) {
  store.asked_to_stop = [&watch] {
    if (!watch.due()) return false;
    const nb::gil_scoped_acquire acquire;
    return watch.must_stop();
  };
  const struct Forget {  // what was asked is of this operation
    Store& store;
    ~Forget() { store.asked_to_stop = nullptr; }
  } forget{store};
  try {
    const nb::gil_scoped_release release;
    body();
  } catch (const Interrupted&) {
    throw nb::python_error();
  }
}

std::size_t by_level(const Store& store) { return kStackPerLevel * (std::size_t(store.levels) + 1); }

void run_on_deep_stack(Store& store, std::function<void()> body, Watch& watch) {
  std::unique_ptr<DeepStack> stack;
  try {
    stack = DeepStack::take(kStackBase + by_level(store));
  } catch (const std::system_error&) {
    throw MemoryLimit("no thread with a stack for this many levels could be made");
  }
  stack->begin(std::move(body));
  bool signalled = false;
  for (bool done = false; !done;) {
    {
      const nb::gil_scoped_release release;
      done = stack->ended(kLook);
    }
    if (!done && !signalled && watch.must_stop()) {
      signalled = true;
      store.stop.store(true);
    }
  }
  const std::exception_ptr error = stack->end();
  DeepStack::leave(std::move(stack));
  if (signalled) throw nb::python_error();
  if (error) std::rethrow_exception(error);
}

}  // namespace

void run_operation(Store& store, std::function<void()> body, Progress& progress) {
  Watch watch(store, progress);
  if (watch.told_to_stop()) throw nb::python_error();
  if (room_on_stack(kCallersBase + by_level(store)))
    run_here(store, body, watch);
  else
    run_on_deep_stack(store, std::move(body), watch);
}
