#include "stages/mser/patches.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include "stages/common/exact_area.hpp"
#include "stages/common/large_pages.hpp"
#include "stages/common/parallel.hpp"
#include "stages/mser/stability.hpp"

namespace meshmser {

namespace {

/// Of each triangle to be joined one of the same patch that comes before it, or itself where none does: of each patch
/// only its smallest triangle. Nothing of others. Each thread joins within a part of the triangles and leaves what
/// leads out of it for later.
std::unique_ptr<std::int32_t[]> join_neighbours(std::span<const std::int32_t> twins,
                                                std::span<const std::int32_t> number_of_triangle,
                                                const SplitOptions& options, const Execution& execution) {
  const std::size_t num_triangles = number_of_triangle.size();
  std::unique_ptr<std::int32_t[]> joined = make_on_large_pages<std::int32_t>(num_triangles);
  const auto root_of = [&](std::int32_t t) {
    while (joined[static_cast<std::size_t>(t)] != t) {
      std::int32_t& next = joined[static_cast<std::size_t>(t)];
      next = joined[static_cast<std::size_t>(next)];
      t = next;
    }
    return t;
  };
  const auto join = [&](std::int32_t root, std::int32_t neighbour) {
    const std::int32_t other = root_of(neighbour), least = std::min(root, other);
    joined[static_cast<std::size_t>(std::max(root, other))] = least;
    return least;
  };
  struct Pair {
    std::int32_t triangle, neighbour;
  };
  const auto parts = static_cast<std::size_t>(thread_count(execution));
  const std::size_t per_part = num_triangles / parts + 1;
  std::vector<std::vector<Pair>> out_of_part(parts);
  parallel_chunks(static_cast<std::int64_t>(parts), 1, "", execution, [&](std::int64_t part, std::int64_t) {
    const std::size_t begin = std::min(num_triangles, static_cast<std::size_t>(part) * per_part);
    const std::size_t end = std::min(num_triangles, begin + per_part);
    std::vector<Pair>& out = out_of_part[static_cast<std::size_t>(part)];
    for (std::size_t t = begin; t < end; ++t) {
      const std::int32_t number = number_of_triangle[t];
      if (number == 0 ? !options.background : options.whole_numbers) continue;
      auto root = static_cast<std::int32_t>(t);
      joined[t] = root;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::int32_t twin = twins[3 * t + k];
        const std::size_t neighbour = twin < 0 ? t : static_cast<std::uint32_t>(twin) / 3;
        if (neighbour >= t || number_of_triangle[neighbour] != number) continue;
        if (neighbour < begin)
          out.push_back({static_cast<std::int32_t>(t), static_cast<std::int32_t>(neighbour)});
        else
          root = join(root, static_cast<std::int32_t>(neighbour));
      }
    }
  });
  for (const std::vector<Pair>& out : out_of_part)
    for (const Pair& pair : out) join(root_of(pair.triangle), pair.neighbour);
  return joined;
}

}  // namespace

Patches split_patches(std::span<const std::int32_t> twins, std::span<const std::int32_t> number_of_triangle,
                      std::span<const double> areas, const Execution& execution, SplitOptions options) {
  struct Found {
    std::int32_t number = 0, first = 0;
    std::int64_t num_triangles = 0;
    double greatest_area = 0;
    std::int32_t exponent = 0;
    std::int64_t area = 0;
  };
  const std::size_t num_triangles = number_of_triangle.size();
  const std::unique_ptr<std::int32_t[]> joined = join_neighbours(twins, number_of_triangle, options, execution);
  std::vector<std::int32_t> patch_of_number;  // of those that are one patch each
  if (options.whole_numbers && num_triangles > 0)
    patch_of_number.resize(
        static_cast<std::size_t>(*std::max_element(number_of_triangle.begin(), number_of_triangle.end())) + 1, 0);
  std::vector<Found> found;  // by smallest triangle
  Patches patches;
  std::vector<std::int32_t>& patch_of_triangle = patches.patch_of_triangle;
  reserve_on_large_pages(patch_of_triangle, num_triangles);
  patch_of_triangle.resize(num_triangles);
  for (std::size_t t = 0; t < num_triangles; ++t) {
    const std::int32_t number = number_of_triangle[t];
    if (number == 0 && !options.background) continue;
    const bool is_whole = number > 0 && options.whole_numbers;
    // What a triangle is joined to comes before it and leads to its root already.
    std::int32_t& patch_of_first =
        is_whole ? patch_of_number[static_cast<std::size_t>(number)]
                 : patch_of_triangle[static_cast<std::size_t>(joined[t] = joined[static_cast<std::size_t>(joined[t])])];
    if (patch_of_first == 0) {
      found.push_back({.number = number, .first = static_cast<std::int32_t>(t)});
      patch_of_first = static_cast<std::int32_t>(found.size());
    }
    patch_of_triangle[t] = patch_of_first;
    Found& patch = found[static_cast<std::size_t>(patch_of_first) - 1];
    ++patch.num_triangles;
    patch.greatest_area = std::max(patch.greatest_area, areas[t]);
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
  patches.first_of_patch.assign(1, -1);
  patches.area_of_patch.assign(1, 0);
  for (const std::int32_t i : order) {
    const Found& patch = found[static_cast<std::size_t>(i)];
    rank[static_cast<std::size_t>(i) + 1] = static_cast<std::int32_t>(patches.number_of_patch.size());
    patches.number_of_patch.push_back(patch.number);
    patches.first_of_patch.push_back(patch.first);
    patches.area_of_patch.push_back(std::ldexp(static_cast<double>(patch.area), -patch.exponent));
  }
  for (std::int32_t& patch : patch_of_triangle) patch = rank[static_cast<std::size_t>(patch)];
  return patches;
}

void drop_whole_components(std::span<const std::int32_t> twins, Patches& patches) {
  std::vector<std::uint8_t> has_neighbour(patches.number_of_patch.size(), 0);
  for (std::size_t h = 0; h < twins.size(); ++h) {
    if (twins[h] < 0) continue;
    const std::int32_t here = patches.patch_of_triangle[h / 3];
    if (patches.patch_of_triangle[static_cast<std::uint32_t>(twins[h]) / 3] != here)
      has_neighbour[static_cast<std::size_t>(here)] = 1;
  }
  std::vector<std::int32_t> kept(patches.number_of_patch.size(), 0);
  std::size_t next = 1;
  for (std::size_t p = 1; p < kept.size(); ++p) {
    if (has_neighbour[p] == 0) continue;
    kept[p] = static_cast<std::int32_t>(next);
    patches.number_of_patch[next] = patches.number_of_patch[p];
    patches.first_of_patch[next] = patches.first_of_patch[p];
    patches.area_of_patch[next] = patches.area_of_patch[p];
    ++next;
  }
  if (next == kept.size()) return;
  patches.number_of_patch.resize(next);
  patches.first_of_patch.resize(next);
  patches.area_of_patch.resize(next);
  for (std::int32_t& patch : patches.patch_of_triangle) patch = kept[static_cast<std::size_t>(patch)];
}

}  // namespace meshmser
