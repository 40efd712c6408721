#pragma once
/// Joining of neighbouring label patches across borders that are none (definitions 9). Labels are #F numbers >= 0, 0
/// for background, which never joins. Returned labels: joined patches bear the smallest of their labels. Weakest border
/// first; ties to the pair of smaller labels. Results do not depend on the number of threads.

#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/execution/execution.hpp"
#include "stages/common/surface.hpp"

namespace meshmser {

/// Joins two labels while the mean strength along their common border exceeds the greater of their two mean strengths
/// by less than `threshold`. `strength`: #V, >= 0; means are weighted by length and by area (`areas`: #F); those of a
/// joined patch are taken over the whole of it.
std::vector<std::int32_t> merge_by_saliency(const SurfaceView& surface, std::span<const std::int32_t> labels,
                                            std::span<const double> strength, std::span<const double> areas,
                                            double threshold, const Execution& execution = {});

struct TurningParameters {
  double threshold = 6 * 0.017453292519943295;  ///< radians
  double radius = 0;                            ///< of the surroundings compared, in coordinate units; 6 h is good
  std::int32_t samples = 60;                    ///< at most so many places along a border
  double curvature_quantile = 0.2;              ///< of a region's curvature, which its own bending explains at least
};

/// Joins two labels while the surface turns across their common border by less than the threshold (in the median over
/// the border) beyond what the bending of the two patches themselves explains.
///
/// At a sample of the border, each side is the triangles of that patch within the radius, reached without leaving it;
/// its normal is their mean weighted by area x squared distance from the sample, so that the rounded edge itself counts
/// little; so is its centre. The turn is the angle between the two normals, minus the distance of the two centres times
/// the greater of the two patches' curvatures: the quantile of `curvature` (#F, >= 0, greatest principal curvature in
/// 1/unit; empty: explains nothing) over the patch, or 1.15 times its median where that is less than 1.6 times the
/// quantile, as on bores and other faces that bend evenly (from there to 2.3 times the gain falls to nothing). `areas`:
/// #F. Two patches larger than the circle of the radius whose
/// common border is shorter than the radius touch at a corner only and do not join. Cost: samples x triangles in the
/// surroundings, for each border, and again for the borders of a patch that has grown.
std::vector<std::int32_t> merge_by_turning(const SurfaceView& surface, std::span<const std::int32_t> labels,
                                           std::span<const double> curvature, std::span<const double> areas,
                                           const TurningParameters& parameters, const Execution& execution = {});

}  // namespace meshmser
