#pragma once
/// The step of the scalar across the borders of regions.

#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/artifacts/level_set_trees.hpp"
#include "pipeline/execution/execution.hpp"
#include "stages/common/surface.hpp"

namespace meshmser {

/// The mean step of S across the level part of the border of each selected node of a tree (by its place in `selected`,
/// ascending): the area-weighted mean over the triangles inside, minus that outside, of those whose centroid is within
/// `band` of the level edge from which they are first reached (of the middle between the centroids on its two sides),
/// neighbour by neighbour, breadth first, through others of which this holds.
/// Positive for the upper tree, negative for the lower, as a rule; 0 without a level border. `triangle_values`: #F.
/// Linear in the mesh and in the sum of the bands.
std::vector<double> border_contrasts(const SurfaceView& surface, const ComponentTree& tree,
                                     std::span<const std::int32_t> selected, std::span<const double> triangle_values,
                                     std::span<const double> areas, double band, const Execution& execution = {});

/// The noise of a scalar from itself: a robust deviation (1.4826 x median absolute value) of each triangle's value from
/// the mean of its three neighbours', times sqrt(3/4). Too small where the noise is smooth. 0 for fewer than 16
/// triangles with three neighbours.
double noise_of_values(const SurfaceView& surface, std::span<const double> triangle_values);

}  // namespace meshmser
