// Memory for tables that are looked up at random: on large pages, where the system has them.
//
// A table of hundreds of megabytes has more small pages than the processor remembers the places of, so that every
// look would walk the page tables first, which takes longer than the look itself.
#pragma once

#include <cstddef>
#include <cstdint>
#include <new>
#include <vector>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace mcpn {

constexpr std::size_t kLargePage = std::size_t(2) << 20;

template <class T> struct LargePages {
  using value_type = T;
  LargePages() = default;
  template <class U> LargePages(const LargePages<U>&) noexcept {}

  T* allocate(std::size_t count) {
    const std::size_t bytes = count * sizeof(T);
    if (bytes < 2 * kLargePage) return static_cast<T*>(::operator new(bytes, std::align_val_t(64)));
    void* found = ::operator new(bytes, std::align_val_t(kLargePage));
#if defined(__linux__) && defined(MADV_HUGEPAGE)
    madvise(found, bytes / kLargePage * kLargePage, MADV_HUGEPAGE);  // advice: nothing is lost where it is not taken
#endif
    return static_cast<T*>(found);
  }
  void deallocate(T* values, std::size_t count) noexcept {
    ::operator delete(values, std::align_val_t(count * sizeof(T) < 2 * kLargePage ? 64 : kLargePage));
  }
  template <class U> bool operator==(const LargePages<U>&) const noexcept { return true; }
};

// A vector on such pages.
template <class T> using Table = std::vector<T, LargePages<T>>;

}  // namespace mcpn
