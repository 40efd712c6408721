#pragma once
/// Meaningful level lines: those along which the scalar is steeper than chance allows.

#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/artifacts/level_set_trees.hpp"
#include "stages/common/surface.hpp"
#include "stages/mser/level_lines.hpp"
#include "stages/mser/node_fate.hpp"

namespace meshmser {

/// The length of the gradient of the linear scalar on each triangle (#F); infinite on triangles without area, not a
/// number where a corner's value is none. `values`: #V. O(F).
std::vector<double> triangle_gradients(const SurfaceView& surface, std::span<const double> values,
                                       const Execution& execution = {});

/// The share of the length of all level lines along which the gradient is at least so much: by the coarea formula lines
/// of all levels together have the length of the integral of the gradient, so that steep places are met more often than
/// their area says. (Counting area alone, white noise has lines everywhere that are steeper than "chance".)
class GradientShare {
 public:
  /// `gradients`, `areas`: #F; triangles without a finite gradient do not count. Sorting.
  GradientShare(std::span<const double> gradients, std::span<const double> areas);
  /// 0 above the steepest triangle. A binary search.
  double at_least(double gradient) const;

 private:
  std::vector<double> gradients_;  ///< ascending
  std::vector<double> share_;      ///< of each and those after it
};

struct ChanceParameters {
  double independent = 0;      ///< distance along a line from which gradients count as independent, > 0
  std::int64_t num_lines = 0;  ///< that could be mistaken: the loops of all nodes of all trees
};

/// log10 of the number of false alarms of each node (#N): that of the best of its lines,
///     num_lines x (share of the lines at least as steep as the line's flattest place) ^ (length / independent);
/// so many lines as long and as steep are expected by chance. A node's lines are tested one by one: many short lines
/// are not a long one. Infinite for nodes without a level line. O(lines log F). Desolneux, Moisan, Morel, "Edge
/// detection by Helmholtz principle", 2001, on a surface in place of an image; deviation: the share is of lines, not of
/// area.
std::vector<double> log_false_alarms(std::size_t num_nodes, std::span<const LevelLine> lines,
                                     const GradientShare& share, const ChanceParameters& parameters);

/// The maximal meaningful nodes, ascending: of each monotone section of the tree (nodes joined by links to an only
/// child, of a tree of shapes one of the same side) the one of fewest false alarms, ties to the larger, where these are
/// at most 10^`log_most`. Roots only where marked in `open_root_of_node` (see open_roots). `fates` (#N), where given,
/// tells why not of every other node. O(N). Desolneux, Moisan, Morel, as above.
std::vector<std::int32_t> select_meaningful(const ComponentTree& tree, std::span<const double> log_alarms_of_node,
                                            double log_most, std::span<const std::uint8_t> open_root_of_node = {},
                                            NodeFates* fates = nullptr);

}  // namespace meshmser
