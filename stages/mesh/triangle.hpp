#pragma once
/// A triangle by the ids of its corners, counter-clockwise seen from outside; its half-edge k runs from corner k to
/// corner (k + 1) % 3.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace meshmser {

using Triangle = std::array<std::int32_t, 3>;

/// The same triangle, turned so that its least corner comes first.
inline Triangle least_corner_first(const Triangle& t) {
  if (t[0] < t[1] && t[0] < t[2]) return t;
  if (t[1] < t[2]) return {t[1], t[2], t[0]};
  return {t[2], t[0], t[1]};
}

/// Turns each triangle so that its least corner comes first and sorts them: one order whatever made them.
inline void sort_triangles(std::vector<Triangle>& triangles) {
  for (Triangle& t : triangles) t = least_corner_first(t);
  std::sort(triangles.begin(), triangles.end());
}

/// The same where the first `num_sorted` are in order already.
inline void sort_added_triangles(std::vector<Triangle>& triangles, std::size_t num_sorted) {
  const auto middle = triangles.begin() + static_cast<std::ptrdiff_t>(num_sorted);
  for (auto t = middle; t != triangles.end(); ++t) *t = least_corner_first(*t);
  std::sort(middle, triangles.end());
  std::inplace_merge(triangles.begin(), middle, triangles.end());
}

}  // namespace meshmser
