#pragma once
#include <cstdint>
#include <optional>

#include "pipeline/artifacts/point_cloud.hpp"
#include "pipeline/artifacts/point_normals.hpp"
#include "pipeline/artifacts/scalar_fields.hpp"
#include "pipeline/artifacts/smoothed_points.hpp"
#include "pipeline/execution/execution.hpp"

namespace meshmser {

/// kScaleSpace: H from the last step's displacement. kQuadric: H from a quadric fitted to the raw points, for
/// comparison.
enum class CurvatureMethod { kScaleSpace, kQuadric };

/// What becomes of points so near to a rim of the cloud that their curvature is biased: within half the radius.
enum class RimTreatment { kMark, kExclude };

struct CurvatureOptions {
  double radius = 0;  ///< of the regression, in coordinate units
  int steps = 4;
  CurvatureMethod method = CurvatureMethod::kScaleSpace;
  double height_radius = 0;  ///< of the large-scale smoothing, in coordinate units; 0: no height
  int height_steps = 4;
  RimTreatment rims = RimTreatment::kMark;  ///< kExclude: curvatures there are NaN
};

struct CurvatureReport {
  double noise = 0;                      ///< sigma_z: of the raw points about their planes, in coordinate units
  std::int64_t num_isolated = 0;         ///< points without a plane: H is NaN
  std::int64_t num_unoriented = 0;       ///< points without a normal: every scalar is NaN
  std::int64_t num_without_quadric = 0;  ///< points with H but no quadric: k1 = k2 = H there
  std::int64_t num_at_rims = 0;          ///< points within half a radius of a rim: their curvature is biased
};

struct Curvature {
  SmoothedPoints smoothed;
  ScalarFields scalars;
  CurvatureReport report;
};

/// Curvatures of the surface at every point, and the smoothed cloud they were measured on.
///
/// normals: one for each point of the cloud. The scalars, in this order: `mean_curvature` H (odd; > 0 on a sphere seen
/// from outside), `k1` >= `k2` (odd), `max_abs_curvature` = max(|k1|, |k2|), `crease` = sqrt(max_abs_curvature^2 +
/// 4 H^2), all in 1/unit, `height` (odd, in units) where asked for, and `rim_distance` (in units, at most the radius).
/// NaN where a point has no plane or no normal.
/// Noise: of H as mean_curvature_noise or quadric_noise says; the other curvatures are measured against the same sigma.
/// Of height: sigma_z, since the large-scale surface averages the rest away. O(n m) a step with m neighbours; does not
/// depend on threads.
Curvature measure_curvature(const PointCloud& cloud, const PointNormals& normals, const CurvatureOptions& options,
                            const Execution& execution = {});

}  // namespace meshmser
