#pragma once
/// Memory that is read in random order, on large pages where the system offers them on request.

#include <cstddef>
#include <cstdint>
#include <vector>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace meshmser {

/// Reserves room for `n` elements of an empty vector and asks for large pages behind it: the processor then finds its
/// way to a random element much faster. Changes nothing but speed; where the system refuses, nothing at all.
template <class T>
void reserve_on_large_pages(std::vector<T>& items, std::size_t n) {
  items.reserve(n);
#if defined(__linux__)
  constexpr std::uintptr_t kLargePage = std::uintptr_t{1} << 21;
  const auto begin = reinterpret_cast<std::uintptr_t>(items.data());
  const std::uintptr_t first = (begin + kLargePage - 1) / kLargePage * kLargePage;
  const std::uintptr_t last = (begin + n * sizeof(T)) / kLargePage * kLargePage;
  if (first < last) (void)madvise(reinterpret_cast<void*>(first), last - first, MADV_HUGEPAGE);
#endif
}

}  // namespace meshmser
