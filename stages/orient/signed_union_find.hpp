#pragma once
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace meshmser {

/// Disjoint sets whose elements carry a sign relative to their set's representative.
class SignedUnionFind {
 public:
  explicit SignedUnionFind(std::size_t size) : parent_(size), size_(size, 1) {
    std::iota(parent_.begin(), parent_.end(), 0u);
    for (auto& entry : parent_) entry <<= 1;
  }

  struct Found {
    std::uint32_t root;
    bool opposed;  ///< the element's sign is opposite to the root's
  };

  /// Halves the path on the way.
  Found find(std::uint32_t element) {
    std::uint32_t parity = 0;
    while (true) {
      const std::uint32_t link = parent_[element], above = link >> 1;
      if (above == element) return {element, parity != 0};
      const std::uint32_t next = parent_[above];
      // A root's own bit is 0, so this holds one step below a root too.
      const std::uint32_t shortcut = (next & ~1u) | ((link ^ next) & 1u);
      parent_[element] = shortcut;
      parity ^= shortcut & 1u;
      element = shortcut >> 1;
    }
  }

  /// Joins the sets of a and b such that a and b have opposite signs iff `opposed`; false where they were joined
  /// before.
  bool join(std::uint32_t a, std::uint32_t b, bool opposed) {
    Found fa = find(a), fb = find(b);
    if (fa.root == fb.root) return false;
    if (size_[fa.root] < size_[fb.root]) std::swap(fa, fb);
    const std::uint32_t bit = static_cast<std::uint32_t>(fa.opposed ^ fb.opposed ^ opposed);
    parent_[fb.root] = (fa.root << 1) | bit;
    size_[fa.root] += size_[fb.root];
    return true;
  }

  /// Elements in the set that `element` belongs to.
  std::uint32_t size_of(std::uint32_t element) { return size_[find(element).root]; }

 private:
  std::vector<std::uint32_t> parent_;  // parent << 1 | opposed to the parent
  std::vector<std::uint32_t> size_;
};

}  // namespace meshmser
