#pragma once
/// The rims of a mesh, and what lies near them.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "pipeline/execution/execution.hpp"

namespace meshmser {

/// From and to; a point where both are equal.
using RimSegment = std::pair<Eigen::Vector3d, Eigen::Vector3d>;

struct LongRims {
  std::vector<RimSegment> segments;
  std::vector<std::int32_t> half_edges;  ///< of each segment
  std::int64_t num_rims = 0;
};

/// Edges of the rims longer than `min_rim`. Linear in the mesh.
LongRims find_long_rims(std::span<const Eigen::Vector3d> positions,
                        std::span<const std::array<std::int32_t, 3>> triangles, std::span<const std::int32_t> twins,
                        double min_rim);

/// 1 for the points nearer (Euclidean) than `distance` to one of the segments. For each point near one the segments
/// within the distance.
std::vector<std::uint8_t> points_near(std::span<const Eigen::Vector3d> points, std::span<const RimSegment> segments,
                                      double distance, const Execution& execution = {});

}  // namespace meshmser
