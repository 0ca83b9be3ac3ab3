#include "python/deep_stack.hpp"

#include <pthread.h>

#include <atomic>
#include <bit>
#include <condition_variable>
#include <csignal>
#include <cstdint>
#include <exception>
#include <mutex>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace {

std::atomic<DeepStack*> idle{nullptr};  // the one that stands ready
std::atomic<unsigned> forks{0};         // of which this process is the child

// Joins it at the end of the process. A forked child has no thread but the one that called fork.
struct AtEnd {
  AtEnd() {
    pthread_atfork(nullptr, nullptr, [] {
      ++forks;
      idle.store(nullptr);
    });
  }
  ~AtEnd() { delete idle.exchange(nullptr); }
};

}  // namespace

struct DeepStack::Thread {
  enum class Turn : std::uint8_t { ready, called, ended, over };

  static void* run(void* self) {
    static_cast<Thread*>(self)->serve();
    return nullptr;
  }
  void serve() {
    for (;;) {
      {
        std::unique_lock lock(mutex);
        changed.wait(lock, [&] { return turn == Turn::called || turn == Turn::over; });
        if (turn == Turn::over) return;
      }
      try {
        body();
      } catch (...) {
        error = std::current_exception();
      }
      hand(Turn::ended);
    }
  }
  void hand(Turn next) {
    const std::lock_guard lock(mutex);
    turn = next;
    changed.notify_all();
  }

  std::size_t bytes = 0;
  unsigned process = forks;
  pthread_t id{};
  std::mutex mutex;
  std::condition_variable changed;
  Turn turn = Turn::ready;
  std::function<void()> body;
  std::exception_ptr error;
};

DeepStack::DeepStack(std::size_t bytes) : thread_(std::make_unique<Thread>()) {
  thread_->bytes = bytes;
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, bytes);
  // Signals are for the threads of the interpreter: one that waits there must be woken by them.
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  const int failed = pthread_create(&thread_->id, &attributes, Thread::run, thread_.get());
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  pthread_attr_destroy(&attributes);
  if (failed) throw std::system_error(failed, std::generic_category());
}

DeepStack::~DeepStack() {
  if (thread_->process != forks) {  // there is no such thread here, and what it waits for cannot be destroyed
    static_cast<void>(thread_.release());
    return;
  }
  thread_->hand(Thread::Turn::over);
  pthread_join(thread_->id, nullptr);
}

std::unique_ptr<DeepStack> DeepStack::take(std::size_t bytes) {
  static const AtEnd at_end;
  std::unique_ptr<DeepStack> found(idle.exchange(nullptr));
  if (found && found->thread_->bytes >= bytes) return found;
  found.reset();
  return std::unique_ptr<DeepStack>(new DeepStack(std::bit_ceil(bytes)));
}

void DeepStack::leave(std::unique_ptr<DeepStack> stack) {
  DeepStack* none = nullptr;
  if (idle.compare_exchange_strong(none, stack.get())) static_cast<void>(stack.release());
}

void DeepStack::begin(std::function<void()> body) {
  thread_->body = std::move(body);
  thread_->hand(Thread::Turn::called);
}

bool DeepStack::ended(std::chrono::milliseconds within) {
  if (thread_->process != forks) throw std::runtime_error("an operation does not go on in a forked process");
  std::unique_lock lock(thread_->mutex);
  return thread_->changed.wait_for(lock, within, [&] { return thread_->turn == Thread::Turn::ended; });
}

std::exception_ptr DeepStack::end() {
  thread_->turn = Thread::Turn::ready;
  thread_->body = nullptr;
  return std::exchange(thread_->error, nullptr);
}
