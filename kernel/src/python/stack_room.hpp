// Whether the calling thread's stack has room for a call.
#pragma once

#include <pthread.h>
#include <sys/resource.h>
#ifdef __linux__
#include <sys/syscall.h>
#include <unistd.h>
#endif

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>

struct StackBounds { std::uintptr_t top = 0; std::size_t bytes = 0; };  // no bytes where the system does not tell

// Whether the byte at an address of the first thread's stack is mapped, or is now. That stack is mapped as it grows, and where
// it cannot, be it for a limit of addresses, a process that goes on all the same ends. The system reads there for us, which
// maps as a load would, but says EFAULT where that fails; it refuses what it has read, and so changes nothing.
inline bool maps(std::uintptr_t address) {
#ifdef __linux__
  constexpr int no_way = -1;
  constexpr std::size_t bytes_of_mask = 8;
  const int before = errno;
  const bool mapped = syscall(SYS_rt_sigprocmask, no_way, address, nullptr, bytes_of_mask) == -1 && errno == EINVAL;
  errno = before;
  return mapped;
#else
  static_cast<void>(address);
  return true;
#endif
}

inline bool on_first_thread() {
#ifdef __linux__
  return syscall(SYS_gettid) == getpid();
#else
  return false;
#endif
}

inline StackBounds bounds_of_stack() {
#ifdef __APPLE__
  return {reinterpret_cast<std::uintptr_t>(pthread_get_stackaddr_np(pthread_self())), pthread_get_stacksize_np(pthread_self())};
#else
  pthread_attr_t attributes;
  void* lowest = nullptr;
  std::size_t bytes = 0;
  if (pthread_getattr_np(pthread_self(), &attributes) != 0) return {};
  const int failed = pthread_attr_getstack(&attributes, &lowest, &bytes);
  pthread_attr_destroy(&attributes);
  if (failed) return {};
  return {reinterpret_cast<std::uintptr_t>(lowest) + bytes, bytes};
#endif
}

// Whether so many bytes are left. None are where the caller is on a stack that is not its thread's own. The first thread's
// stack grows up to a limit which the process may lower meanwhile; for other threads the limit may be less than what they have.
inline bool room_on_stack(std::size_t wanted) {
  struct Known { StackBounds bounds = bounds_of_stack(); std::uintptr_t mapped = on_first_thread() ? bounds.top : 0; };
  thread_local Known known;  // the system may have to read a file for it
  rlimit limit{};
  if (getrlimit(RLIMIT_STACK, &limit) != 0) return false;
  const std::size_t bytes = std::min<std::uintmax_t>(known.bounds.bytes, limit.rlim_cur);  // RLIM_INFINITY is the largest
  const auto here = reinterpret_cast<std::uintptr_t>(__builtin_frame_address(0));
  const std::uintptr_t used = known.bounds.top - here;
  if (here > known.bounds.top || used >= bytes || bytes - used < wanted) return false;
  if (here - wanted < known.mapped) {
    if (!maps(here - wanted)) return false;
    known.mapped = here - wanted;
  }
  return true;
}
