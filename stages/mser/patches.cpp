#include "stages/mser/patches.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "stages/common/exact_area.hpp"
#include "stages/mser/stability.hpp"

namespace meshmser {

Patches split_patches(std::span<const std::int32_t> twins, std::span<const std::int32_t> number_of_triangle,
                      std::span<const double> areas) {
  struct Found {
    std::int32_t number = 0;
    std::uint8_t is_whole = 1;
    std::int64_t num_triangles = 0;
    double greatest_area = 0;
    std::int32_t exponent = 0;
    std::int64_t area = 0;
  };
  const std::size_t num_triangles = number_of_triangle.size();
  // The first pass joins each triangle to its earlier neighbours of the same number; a root is its patch's smallest
  // triangle.
  std::vector<std::int32_t> joined(num_triangles);
  const auto root_of = [&](std::int32_t t) {
    while (joined[static_cast<std::size_t>(t)] != t) {
      std::int32_t& next = joined[static_cast<std::size_t>(t)];
      next = joined[static_cast<std::size_t>(next)];
      t = next;
    }
    return t;
  };
  std::vector<std::uint8_t> at_other(num_triangles, 0);
  for (std::size_t t = 0; t < num_triangles; ++t) {
    auto root = static_cast<std::int32_t>(t);
    joined[t] = root;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t twin = twins[3 * t + k];
      if (twin < 0) continue;
      const auto neighbour = static_cast<std::size_t>(twin / 3);
      if (number_of_triangle[neighbour] != number_of_triangle[t]) {
        at_other[t] = 1;
      } else if (neighbour < t) {
        const std::int32_t other = root_of(static_cast<std::int32_t>(neighbour));
        joined[static_cast<std::size_t>(std::max(root, other))] = std::min(root, other);
        root = std::min(root, other);
      }
    }
  }
  std::vector<Found> found;  // by smallest triangle
  Patches patches;
  std::vector<std::int32_t>& patch_of_triangle = patches.patch_of_triangle;
  patch_of_triangle.assign(num_triangles, 0);
  for (std::size_t t = 0; t < num_triangles; ++t) {
    if (number_of_triangle[t] == 0) continue;
    const auto root = static_cast<std::size_t>(root_of(static_cast<std::int32_t>(t)));
    if (root == t) {
      found.push_back({.number = number_of_triangle[t]});
      patch_of_triangle[t] = static_cast<std::int32_t>(found.size());
    }
    patch_of_triangle[t] = patch_of_triangle[root];
    Found& patch = found[static_cast<std::size_t>(patch_of_triangle[t]) - 1];
    ++patch.num_triangles;
    patch.greatest_area = std::max(patch.greatest_area, areas[t]);
    if (at_other[t] != 0) patch.is_whole = 0;
  }
  for (Found& patch : found) patch.exponent = area_exponent(patch.num_triangles, patch.greatest_area);
  for (std::size_t t = 0; t < num_triangles; ++t)
    if (patch_of_triangle[t] != 0) {
      Found& patch = found[static_cast<std::size_t>(patch_of_triangle[t]) - 1];
      patch.area += area_in_units(areas[t], patch.exponent);
    }

  std::vector<std::int32_t> order(found.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
    const Found &p = found[static_cast<std::size_t>(a)], &q = found[static_cast<std::size_t>(b)];
    return compare_area(p.area, p.exponent, q.area, q.exponent) > 0;
  });
  std::vector<std::int32_t> rank(found.size() + 1, 0);
  patches.number_of_patch.assign(1, 0);
  patches.area_of_patch.assign(1, 0);
  patches.is_whole_of_patch.assign(1, 0);
  for (const std::int32_t i : order) {
    const Found& patch = found[static_cast<std::size_t>(i)];
    rank[static_cast<std::size_t>(i) + 1] = static_cast<std::int32_t>(patches.number_of_patch.size());
    patches.number_of_patch.push_back(patch.number);
    patches.is_whole_of_patch.push_back(patch.is_whole);
    patches.area_of_patch.push_back(std::ldexp(static_cast<double>(patch.area), -patch.exponent));
  }
  for (std::int32_t& patch : patch_of_triangle) patch = rank[static_cast<std::size_t>(patch)];
  return patches;
}

void drop_whole_components(Patches& patches) {
  std::vector<std::int32_t> kept(patches.number_of_patch.size(), 0);
  std::size_t next = 1;
  for (std::size_t p = 1; p < kept.size(); ++p) {
    if (patches.is_whole_of_patch[p] != 0) continue;
    kept[p] = static_cast<std::int32_t>(next);
    patches.number_of_patch[next] = patches.number_of_patch[p];
    patches.area_of_patch[next] = patches.area_of_patch[p];
    ++next;
  }
  if (next == kept.size()) return;
  patches.number_of_patch.resize(next);
  patches.area_of_patch.resize(next);
  patches.is_whole_of_patch.assign(next, 0);
  for (std::int32_t& patch : patches.patch_of_triangle) patch = kept[static_cast<std::size_t>(patch)];
}

}  // namespace meshmser
