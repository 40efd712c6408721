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

/// The least gradient on the triangles just beyond each node's level edges (#N), which its level line crosses; infinite
/// for nodes without a level edge. `gradients`: #F, of triangle_gradients. Linear as level_line_lengths.
std::vector<double> least_gradients(const SurfaceView& surface, const ComponentTree& tree,
                                    std::span<const double> gradients);

/// The nodes whose level line is at least `least` long, ascending; roots only where marked in `open_root_of_node` (see
/// open_roots). `fates` (#N), where given, tells why not of every other node. Digne et al. 2010, figure 7 b, c.
std::vector<std::int32_t> select_length(const ComponentTree& tree, std::span<const double> length_of_node, double least,
                                        std::span<const std::uint8_t> open_root_of_node = {},
                                        NodeFates* fates = nullptr);

/// The components of the level set of one level: the greatest that is at most `value` (of S, not of -S); ascending;
/// roots and fates as for select_length. None where `value` lies below every level.
std::vector<std::int32_t> select_level(const ComponentTree& tree, double value,
                                       std::span<const std::uint8_t> open_root_of_node = {},
                                       NodeFates* fates = nullptr);

}  // namespace meshmser
