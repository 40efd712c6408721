#pragma once
/// Memory that is read in random order, on large pages where the system offers them on request.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace meshmser {

/// Asks for large pages behind some memory: the processor then finds its way to a random element much faster. Changes
/// nothing but speed; where the system refuses, nothing at all.
inline void ask_for_large_pages([[maybe_unused]] void* memory, [[maybe_unused]] std::size_t num_bytes) {
#if defined(__linux__)
  constexpr std::uintptr_t kLargePage = std::uintptr_t{1} << 21;
  const auto begin = reinterpret_cast<std::uintptr_t>(memory);
  const std::uintptr_t first = (begin + kLargePage - 1) / kLargePage * kLargePage;
  const std::uintptr_t last = (begin + num_bytes) / kLargePage * kLargePage;
  if (first < last) (void)madvise(reinterpret_cast<void*>(first), last - first, MADV_HUGEPAGE);
#endif
}

/// Reserves room for `n` elements of an empty vector.
template <class T>
void reserve_on_large_pages(std::vector<T>& items, std::size_t n) {
  items.reserve(n);
  ask_for_large_pages(items.data(), n * sizeof(T));
}

/// An array whose elements are not set yet, for those who write every one before they read it.
template <class T>
std::unique_ptr<T[]> make_on_large_pages(std::size_t n) {
  auto items = std::make_unique_for_overwrite<T[]>(n);
  ask_for_large_pages(items.get(), n * sizeof(T));
  return items;
}

}  // namespace meshmser
