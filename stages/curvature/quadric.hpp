#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/execution/execution.hpp"

namespace meshmser {

/// Principal curvatures k1 >= k2, positive where the surface bends away from its normal (a sphere seen from outside).
struct PrincipalCurvatures {
  std::vector<double> k1, k2;  ///< #P; NaN where no quadric could be fitted
  std::int64_t num_undefined = 0;
};

/// Fits z = a + b u + c v + d u^2 + e u v + f v^2 by least squares to the points within `radius` of each point, in the
/// frame of its normal, and takes the principal curvatures from its first and second fundamental forms at the point
/// (Cazals and Pouget 2005, degree 2).
///
/// points: #P; normals: #P outward unit normals, zero where unknown (NaN there). Points whose normals are more than 120
/// degrees apart are not neighbours. O(#P m) with m neighbours; does not depend on threads. Throws StageError for a
/// radius that is not positive.
PrincipalCurvatures fit_quadrics(std::span<const Eigen::Vector3d> points, std::span<const Eigen::Vector3d> normals,
                                 double radius, const Execution& execution = {});

/// Standard deviation of the fit's (k1 + k2) / 2 on a plane with independent noise along the normal:
/// sqrt(48 / pi) noise spacing / radius^3, from the variance of the regression on u^2 + v^2 over a disk of uniform
/// density 1 / spacing^2.
double quadric_noise(double noise, double spacing, double radius);

}  // namespace meshmser
