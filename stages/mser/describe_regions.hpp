#pragma once
/// What is known of each region: size, scalar, place, contrast along its border.

#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/artifacts/level_set_trees.hpp"
#include "pipeline/artifacts/segmentation.hpp"
#include "pipeline/execution/execution.hpp"
#include "stages/common/surface.hpp"
#include "stages/mser/label_triangles.hpp"
#include "stages/mser/persistence.hpp"

namespace meshmser {

/// What the selection knows of one tree.
struct TreeSelection {
  std::vector<std::int64_t> changes;  ///< of change_of_nodes
  Maxima maxima;
  std::vector<double> log_false_alarms;  ///< of log_false_alarms; empty unless lines are selected by it
  std::vector<std::int32_t> selected;    ///< ascending
};

/// One Region for each selected node, in the same order, without its contrast. Means and deviation are those of the
/// linear scalar over the triangles of the region (its descendants' included), minimum and maximum over their corners;
/// shapes are fitted to up to 192 corners of its triangles, evenly taken. `values`: #V, S; `areas`: #F. One pass
/// over the triangles and one over the regions for each tree. Same bytes on any number of threads.
std::vector<Region> describe_regions(const SurfaceView& surface, std::span<const ComponentTree> trees,
                                     std::span<const TreeSelection> selections, std::span<const SelectedNode> regions,
                                     std::span<const double> values, std::span<const double> areas,
                                     const Execution& execution = {});

/// The mean step of S across the level part of the border of each selected node of a tree (by its place in `selected`,
/// ascending): the area-weighted mean over the triangles inside, minus that outside, of those whose centroid is within
/// `band` of the level edge from which they are first reached. Positive for the upper tree, negative for the lower, as
/// a rule; 0 without a level border. `triangle_values`: #F. Linear in the mesh and in the sum of the bands.
std::vector<double> border_contrasts(const SurfaceView& surface, const ComponentTree& tree,
                                     std::span<const std::int32_t> selected, std::span<const double> triangle_values,
                                     std::span<const double> areas, double band, const Execution& execution = {});

/// The noise of a scalar from itself: a robust deviation (1.4826 x median absolute value) of each triangle's value from
/// the mean of its three neighbours', times sqrt(3/4). Too small where the noise is smooth. 0 for fewer than 16
/// triangles with three neighbours.
double noise_of_values(const SurfaceView& surface, std::span<const double> triangle_values);

}  // namespace meshmser
