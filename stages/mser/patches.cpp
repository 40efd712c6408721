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
    std::int32_t number;
    std::int64_t num_triangles;
    double greatest_area;
    std::int32_t exponent;
    std::int64_t area;
  };
  const std::size_t num_triangles = number_of_triangle.size();
  std::vector<Found> found;  // by smallest triangle
  Patches patches;
  std::vector<std::int32_t>& patch_of_triangle = patches.patch_of_triangle;
  patch_of_triangle.assign(num_triangles, 0);
  std::vector<std::int32_t> front;
  for (std::size_t first = 0; first < num_triangles; ++first) {
    const std::int32_t number = number_of_triangle[first];
    if (number == 0 || patch_of_triangle[first] != 0) continue;
    Found patch{number, 0, 0, 0, 0};
    const auto mark = static_cast<std::int32_t>(found.size()) + 1;
    patch_of_triangle[first] = mark;
    front.assign(1, static_cast<std::int32_t>(first));
    while (!front.empty()) {
      const auto t = static_cast<std::size_t>(front.back());
      front.pop_back();
      ++patch.num_triangles;
      patch.greatest_area = std::max(patch.greatest_area, areas[t]);
      for (std::size_t k = 0; k < 3; ++k) {
        const std::int32_t twin = twins[3 * t + k];
        if (twin < 0) continue;
        const auto neighbour = static_cast<std::size_t>(twin / 3);
        if (patch_of_triangle[neighbour] != 0 || number_of_triangle[neighbour] != number) continue;
        patch_of_triangle[neighbour] = mark;
        front.push_back(twin / 3);
      }
    }
    patch.exponent = area_exponent(patch.num_triangles, patch.greatest_area);
    found.push_back(patch);
  }
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
  for (const std::int32_t i : order) {
    const Found& patch = found[static_cast<std::size_t>(i)];
    rank[static_cast<std::size_t>(i) + 1] = static_cast<std::int32_t>(patches.number_of_patch.size());
    patches.number_of_patch.push_back(patch.number);
    patches.area_of_patch.push_back(std::ldexp(static_cast<double>(patch.area), -patch.exponent));
  }
  for (std::int32_t& patch : patch_of_triangle) patch = rank[static_cast<std::size_t>(patch)];
  return patches;
}

}  // namespace meshmser
