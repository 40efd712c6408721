#pragma once
/// What is known of each region: size, scalar, place, shape.

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

}  // namespace meshmser
