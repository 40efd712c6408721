#pragma once
/// Border curves off the mesh edges (definitions 10, interpolated variant), on plain arrays.

#include <cstdint>
#include <span>

#include "pipeline/artifacts/border_set.hpp"
#include "pipeline/artifacts/level_set_trees.hpp"
#include "pipeline/execution/execution.hpp"
#include "stages/borders/borders.hpp"

namespace meshmser {

/// A region as a node of a tree.
struct BorderRegion {
  const ComponentTree* tree = nullptr;
  std::int32_t node = -1;
};

/// For every loop the closed curve on which the linear S equals the region's level h, the value of its node.
///
/// `values`: #V, S itself whatever the polarity. `loops`: of extract_borders on the same surface; the region numbered r
/// is regions[r - 1]. Curve l belongs to loop l. At each border vertex v the curve runs through the fan of outside
/// triangles: a point on each edge from v to a vertex below h; v itself in place of it where that vertex reaches h;
/// where the fan ends at a hole, the piece of the rim back to v. Hole edges stay. Where another part of the region
/// touches v (a pinch), the curve passes through v itself, so that curves touch there and never cross. Equal points in
/// a row are given once. Time linear in the fans about the loops' vertices; same bytes on any number of threads.
/// Source: [LST] Fig. 2.
BorderCurves interpolate_borders(const SurfaceView& surface, std::span<const double> values, const BorderLoops& loops,
                                 std::span<const BorderRegion> regions, const Execution& execution = {});

/// The same curves, smoother: each point of a level piece moves toward the middle of its two neighbours, again and
/// again, but never farther than `tolerance` from where it was, so that the smooth curve and the exact one are within
/// `tolerance` of each other everywhere. Points of holes stay. `tolerance` >= 0, in coordinate units.
BorderCurves smooth_curves(const BorderCurves& curves, double tolerance, const Execution& execution = {});

}  // namespace meshmser
