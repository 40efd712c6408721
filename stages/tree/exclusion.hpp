#pragma once
/// Triangles that leave the mesh before anything else (definitions 5).

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/execution/execution.hpp"

namespace meshmser {

/// What was left out and why; a triangle with both reasons counts as NaN.
struct Exclusion {
  std::vector<std::uint8_t> excluded_of_triangle;  ///< #F
  std::int64_t num_nan = 0;                        ///< triangles that touch a value that is not finite
  std::int64_t num_near_rim = 0;
  std::int64_t num_rims = 0;  ///< rims longer than `min_rim`
};

/// Triangles with a corner whose value is not finite, and triangles with a corner nearer (Euclidean) than
/// `rim_distance` to an edge of a rim whose length exceeds `min_rim`, or to a vertex with fallen[v] != 0 (#V or empty).
/// `rim_distance` 0 excludes none by their rim. Rims are those of the mesh as given: of `twins` before anything is cut
/// out. Time: linear in the mesh, and for each vertex near a rim the rim edges within the distance.
Exclusion exclude_triangles(std::span<const Eigen::Vector3d> positions,
                            std::span<const std::array<std::int32_t, 3>> triangles, std::span<const std::int32_t> twins,
                            std::span<const double> values, double rim_distance, double min_rim,
                            std::span<const std::uint8_t> fallen = {}, const Execution& execution = {});

}  // namespace meshmser
