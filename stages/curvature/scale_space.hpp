#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/execution/execution.hpp"

namespace meshmser {

struct ScaleSpaceParameters {
  double radius = 0;  ///< of the regression neighbourhood, in coordinate units
  int steps = 4;
  bool find_rims = false;  ///< fills `rim_distance`
};

/// A cloud after some steps of projection on regression planes, and what the last step says about its curvature.
struct ScaleSpace {
  std::vector<Eigen::Vector3d> positions;  ///< #P: after the last step
  std::vector<Eigen::Vector3d>
      normals;  ///< #P: of the last step's planes, outward as the given ones; zero without a plane
  std::vector<double> mean_curvature;  ///< #P: H at the raw point; NaN without a plane or without a given normal
  /// #P where asked for, else empty: how far the cloud goes on in the direction in which it ends soonest, `radius`
  /// where it goes on all round; NaN without a plane. H is biased at less than radius / 2.
  std::vector<double> rim_distance;
  double noise = 0;               ///< sigma_z: standard deviation of raw points from their first planes
  std::int64_t num_isolated = 0;  ///< points that never had a plane; they stayed where they were
};

/// Moves every point at once to its projection on the regression plane of the points within `radius`, `steps` times;
/// with d the last displacement along the outward normal, H = -4 d / radius^2 [Digne et al. 2011].
///
/// points: #P finite positions; normals: #P outward unit normals, zero where unknown. Points whose normals are more
/// than 120 degrees apart are not neighbours, so that the two sheets of a thin wall do not mix. All displacements of a
/// step are measured from the same positions, so the result depends neither on the order of the points (but for
/// rounding) nor on threads. O(#P m) a step with m neighbours; throws StageError for a radius that is not positive.
ScaleSpace scale_space(std::span<const Eigen::Vector3d> points, std::span<const Eigen::Vector3d> normals,
                       const ScaleSpaceParameters& parameters, const Execution& execution = {});

/// Standard deviation of H on a plane whose points have independent noise of standard deviation `noise` along the
/// normal: sigma_H = C(steps) noise spacing / radius^3 for steps >= 2, C measured on noisy planes and interpolated in
/// the logarithms; 4 noise / radius^2 for one step. Not less than 0.0003 / spacing, below which quantisation and the
/// sampling itself decide. 0 for a spacing of 0.
double mean_curvature_noise(double noise, double spacing, const ScaleSpaceParameters& parameters);

}  // namespace meshmser
