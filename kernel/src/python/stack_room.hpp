// How many bytes the calling thread's stack still has.
#pragma once

#include <pthread.h>
#include <sys/resource.h>
#ifdef __linux__
#include <sys/syscall.h>
#include <unistd.h>
#endif

#include <algorithm>
#include <cstddef>
#include <cstdint>

struct StackBounds { std::uintptr_t top = 0; std::size_t bytes = 0; };  // no bytes where the system does not tell

// What the first thread may use of its stack where addresses are limited: it is mapped as it grows, and where it can not, the
// process ends.
constexpr std::size_t kGrown = 2u << 20;

inline bool may_not_grow() {
#ifdef __linux__
  rlimit addresses{};
  return syscall(SYS_gettid) == getpid() && (getrlimit(RLIMIT_AS, &addresses) != 0 || addresses.rlim_cur != RLIM_INFINITY);
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

// None where the caller is on a stack that is not its thread's own. The first thread's stack grows up to a limit which
// the process may lower meanwhile; for other threads the limit may be less than what they have.
inline std::size_t room_on_stack() {
  thread_local const StackBounds bounds = bounds_of_stack();  // the system may have to read a file for it
  rlimit limit{};
  if (getrlimit(RLIMIT_STACK, &limit) != 0) return 0;
  std::size_t bytes = std::min<std::uintmax_t>(bounds.bytes, limit.rlim_cur);  // RLIM_INFINITY is the largest
  if (may_not_grow()) bytes = std::min(bytes, kGrown);
  const auto here = reinterpret_cast<std::uintptr_t>(__builtin_frame_address(0));
  const std::uintptr_t used = bounds.top - here;
  return here <= bounds.top && used < bytes ? bytes - used : 0;
}
