#pragma once
/// A triangle mesh as plain arrays, for algorithms that several stages use.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/execution/execution.hpp"

namespace meshmser {

/// A mesh with its adjacency.
struct SurfaceView {
  std::span<const Eigen::Vector3d> positions;              ///< #V
  std::span<const std::array<std::int32_t, 3>> triangles;  ///< #F
  std::span<const std::int32_t> twins;                     ///< 3 #F: twin_half_edges, after cut_out_triangles
};

/// Area of every triangle, in coordinate units squared: half the length of the cross product of two edges.
std::vector<double> triangle_areas(std::span<const Eigen::Vector3d> positions,
                                   std::span<const std::array<std::int32_t, 3>> triangles,
                                   const Execution& execution = {});

}  // namespace meshmser
