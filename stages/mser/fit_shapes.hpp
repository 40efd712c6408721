#pragma once
/// The plane, sphere and cylinder nearest to weighted points, and which of them describes the points best.

#include <Eigen/Core>
#include <limits>
#include <span>

#include "pipeline/artifacts/segmentation.hpp"

namespace meshmser {

/// Residuals are root mean squares of the distance to the shape; not a number where there are too few points for it.
/// Radii are positive where the shape bulges out along the normals (a boss), negative where it is seen from within (a
/// bore); infinite, with no centre, where no curvature is found.
struct FittedShapes {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  double plane_residual = kNone;
  Eigen::Vector3d plane_point = Eigen::Vector3d::Constant(kNone);  ///< the points' mean
  Eigen::Vector3d plane_normal = Eigen::Vector3d::Constant(kNone);
  double sphere_residual = kNone, sphere_radius = kNone;
  Eigen::Vector3d sphere_centre = Eigen::Vector3d::Constant(kNone);
  double cylinder_residual = kNone, cylinder_radius = kNone;
  Eigen::Vector3d cylinder_point = Eigen::Vector3d::Constant(kNone);  ///< of the axis, nearest to the points' mean
  Eigen::Vector3d cylinder_axis = Eigen::Vector3d::Constant(kNone);   ///< unit; its largest component is positive
  FittedShape best = FittedShape::kNone;
};

/// Fits the three shapes by least squares of the weighted distances.
///
/// `points`, `weights` (> 0), `normals` (of the surface at each point, any length): of one size. Sphere and cylinder
/// are given by curvature, not radius, so that flat points are no special case, and start from the plane, from the
/// linear least-squares sphere, and from linear least-squares circles across the axes that normals and points suggest;
/// Levenberg and Marquardt's steps follow. `best` has the least n log(residual^2 n / (n - k)) + k log n [Schwarz 1978],
/// with k = 3, 4, 5 numbers for plane, sphere, cylinder; n, the number of points, counts as 50 at most, since the
/// deviations of neighbouring points are not independent (so a number more must lessen the residual by some 4 %), and
/// residuals below a millionth of the points' spread as that. Too few points for a shape are k + 1 or fewer. O(n).
/// Source: Lukacs, Martin, Marshall, "Faithful least-squares fitting of spheres, cylinders, cones and tori", 1998.
FittedShapes fit_shapes(std::span<const Eigen::Vector3d> points, std::span<const double> weights,
                        std::span<const Eigen::Vector3d> normals);

}  // namespace meshmser
