#pragma once
/// Points that belong to no surface.

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/execution/execution.hpp"

namespace meshmser {

enum class OutlierMethod { kNone, kStatistical, kRadius };

struct OutlierOptions {
  OutlierMethod method = OutlierMethod::kNone;
  int neighbors = 16;     ///< statistical: whose mean distance is looked at; radius: the least number within `radius`
  double deviations = 3;  ///< statistical: standard deviations above the mean that are too far
  double radius_spacings = 3;  ///< radius: how far to look, in spacings
};

/// Marks outliers by PCL's filters. Statistical: points whose mean distance to `neighbors` neighbours exceeds the mean
/// of that distance by `deviations` standard deviations (Rusu et al. 2008). Radius: points with fewer than `neighbors`
/// others within `radius_spacings` x `spacing`. Points must be near the origin: PCL counts in floats.
/// Returns one byte a point, 1: outlier. O(n log n).
std::vector<std::uint8_t> find_outliers(std::span<const Eigen::Vector3d> positions, double spacing,
                                        const OutlierOptions& options, const Execution& execution = {});

}  // namespace meshmser
