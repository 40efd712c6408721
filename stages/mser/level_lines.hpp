#pragma once
/// Level lines as regions' borders, and selections by them.

#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/artifacts/level_set_trees.hpp"
#include "stages/common/surface.hpp"
#include "stages/mser/node_fate.hpp"

namespace meshmser {

/// The length of the level part of each node's border (#N), in coordinate units. Linear in the mesh and the sum of all
/// borders.
std::vector<double> level_line_lengths(const SurfaceView& surface, const ComponentTree& tree);

/// One closed loop of a node's border, as far as it is level edges.
struct LevelLine {
  std::int32_t node = -1;
  double length = 0;          ///< in coordinate units
  double least_gradient = 0;  ///< on the triangles just beyond its level edges, which the line crosses
};

/// Every loop with a level edge of every node, by ascending node, then smallest half-edge. Loops never cross: at a
/// vertex where the node pinches they turn inside it, as borders do. `gradients`: #F, of triangle_gradients. Linear in
/// the mesh and in the sum of all borders with the fans about them.
std::vector<LevelLine> level_lines(const SurfaceView& surface, const ComponentTree& tree,
                                   std::span<const double> gradients);

/// The nodes whose level line is at least `least` long, ascending; roots only where marked in `open_root_of_node` (see
/// open_roots). `fates` (#N), where given, tells why not of every other node. Digne et al. 2010, figure 7 b, c.
std::vector<std::int32_t> select_length(const ComponentTree& tree, std::span<const double> length_of_node, double least,
                                        std::span<const std::uint8_t> open_root_of_node = {},
                                        NodeFates* fates = nullptr);

/// The components of the level set of one level: the greatest that is at most `value` (of S, not of -S); ascending;
/// roots and fates as for select_length. Of a tree of shapes the parts above that level and those below it. None where
/// `value` lies below every level.
std::vector<std::int32_t> select_level(const ComponentTree& tree, double value,
                                       std::span<const std::uint8_t> open_root_of_node = {},
                                       NodeFates* fates = nullptr);

}  // namespace meshmser
