// Memory for tables that are looked up at random: on large pages, where the system has them.
//
// A table of hundreds of megabytes has more small pages than the processor remembers the places of, so that every
// look would walk the page tables first, which takes longer than the look itself.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <new>
#include <type_traits>
#include <utility>
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

// Values that are appended, which the system moves by their pages as they outgrow their place: no second copy lives.
template <class T> class Appended {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  using value_type = T;
  Appended() = default;
  Appended(Appended&& other) noexcept { *this = std::move(other); }
  Appended& operator=(Appended&& other) noexcept {
    std::swap(values_, other.values_);
    std::swap(size_, other.size_);
    std::swap(capacity_, other.capacity_);
    return *this;
  }
  ~Appended() { std::free(values_); }

  std::size_t size() const { return size_; }
  std::size_t capacity() const { return capacity_; }
  T& operator[](std::size_t at) { return values_[at]; }
  const T& operator[](std::size_t at) const { return values_[at]; }
  void push_back(T value) {
    if (size_ == capacity_) reserve(capacity_ + capacity_ / 4 + 1024);
    values_[size_++] = value;
  }
  void reserve(std::size_t capacity) {
    void* moved = std::realloc(values_, capacity * sizeof(T));
    if (!moved && capacity) throw std::bad_alloc();
    values_ = static_cast<T*>(moved);
    capacity_ = capacity;
  }
  T* release() {  // to be freed by std::free
    size_ = capacity_ = 0;
    return std::exchange(values_, nullptr);
  }

 private:
  T* values_ = nullptr;
  std::size_t size_ = 0, capacity_ = 0;
};

}  // namespace mcpn
