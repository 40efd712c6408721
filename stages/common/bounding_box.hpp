#pragma once
#include <Eigen/Core>
#include <span>

namespace meshmser {

/// Length of the diagonal of the points' axis-parallel bounding box; 0 without points.
inline double bounding_diagonal(std::span<const Eigen::Vector3d> points) {
  if (points.empty()) return 0;
  Eigen::Vector3d low = points.front(), high = low;
  for (const Eigen::Vector3d& p : points) low = low.cwiseMin(p), high = high.cwiseMax(p);
  return (high - low).norm();
}

}  // namespace meshmser
