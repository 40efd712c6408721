#pragma once
/// Borders moved to where the surfaces of both sides meet.

#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/execution/execution.hpp"
#include "stages/common/surface.hpp"

namespace meshmser {

struct FitParameters {
  double spacing = 0;                             ///< h, in coordinate units, > 0
  double radius = 0;                              ///< of the sides that planes are fitted to; 8 h is good
  double least_turn = 10 * 0.017453292519943295;  ///< radians; where sides turn by less they do not say where
  std::int32_t rounds = 3;
};

/// Moves the border between two labels of each pair of neighbours to the edge in which the planes of the two sides
/// meet. Labels are #F numbers >= 0, 0 for background, whose borders stay.
///
/// A flood ends where two fronts happen to meet on a crest that is as wide as the smoothing; the two faces beside it
/// are known far better. In each round, at places about 1.5 h apart along every border, a plane is fitted to the
/// triangles of each side within the radius, the nearer along the border the more they count. Where the planes turn by
/// at least `least_turn` and their noise leaves the place of the edge certain to within 1.5 h, triangles within 4 h of
/// the place take the label of the plane on which they are: on a convex edge the higher of the two, in a concave one
/// the lower (equally: the side of the bisecting plane). Centroids are averaged with their neighbours before, so that a
/// border between noisy points is even; the average over both sides of an edge is on the bisecting plane itself. What
/// is cut off from its patch on the way may be absorbed afterwards. Labels never vanish from their places beyond 4 h of
/// a border in a round. Deterministic for any number of threads. Cost: border length / 1.5 h x triangles in the radius.
std::vector<std::int32_t> fit_borders(const SurfaceView& surface, std::span<const std::int32_t> labels,
                                      std::span<const double> areas, const FitParameters& parameters,
                                      const Execution& execution = {});

}  // namespace meshmser
