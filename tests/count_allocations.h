// Counts what a test program takes from the heap by new, in every form. Include it in one source of a
// program: it replaces the global operators.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <new>

namespace evograsp::testing {
namespace counted {
inline std::atomic<std::uint64_t> allocations = 0;

inline void* take(std::size_t size) noexcept {
  ++allocations;
  return std::malloc(size > 0 ? size : 1);
}
inline void* take(std::size_t size, std::align_val_t align) noexcept {
  ++allocations;
  const auto a = static_cast<std::size_t>(align);
  return std::aligned_alloc(a, (size + a - 1) / a * a);
}
inline void* or_throw(void* p) {
  if (p == nullptr) throw std::bad_alloc();
  return p;
}
}  // namespace counted

// So far, by all threads.
inline std::uint64_t allocations() {
  return counted::allocations;
}

}  // namespace evograsp::testing

// Not inlined: a compiler that sees what stands behind new would call free() of it a mistake.
// NOLINTBEGIN: replacing the global operators is how allocations are counted.
[[gnu::noinline]] void* operator new(std::size_t size) {
  return evograsp::testing::counted::or_throw(evograsp::testing::counted::take(size));
}
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return evograsp::testing::counted::take(size);
}
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t align) {
  return evograsp::testing::counted::or_throw(evograsp::testing::counted::take(size, align));
}
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t align,
                                     const std::nothrow_t&) noexcept {
  return evograsp::testing::counted::take(size, align);
}
[[gnu::noinline]] void operator delete(void* p) noexcept {
  std::free(p);
}
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept {
  std::free(p);
}
[[gnu::noinline]] void operator delete(void* p, std::align_val_t) noexcept {
  std::free(p);
}
[[gnu::noinline]] void operator delete(void* p, std::size_t, std::align_val_t) noexcept {
  std::free(p);
}
// NOLINTEND
