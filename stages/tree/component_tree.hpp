#pragma once
/// The component tree of a mesh's triangles (definitions 6), on plain arrays.

#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/artifacts/level_set_trees.hpp"
#include "pipeline/execution/execution.hpp"
#include "stages/common/surface.hpp"

namespace meshmser {

/// The tree of the connected components of {t : level(t) >= k}, k = 1 .. num_levels.
///
/// `twins`: 3 #F, from twin_half_edges, after cut_out_triangles where triangles are excluded; `areas`: #F, finite, >=
/// 0; `level_of_triangle`: #F, 0 .. num_levels, 0 for a triangle in no node. Returns the tree without `polarity` and
/// `levels`, which are the caller's. Nodes are in postorder, roots by their smallest triangle; every node holds a
/// triangle of its own level. Areas are exact sums of the triangle areas rounded to units of 2^-e, where e is chosen by
/// the greatest triangle and the number of triangles of the node's root alone. Throws StageError for more than 2^31 / 3
/// triangles, a level out of range, an area that is not finite or negative, or arrays of differing sizes.
/// Time linear in #F + num_levels; 6 bytes a triangle (8 from 2^16 levels on) and 8 a node beside its result's. All but
/// the flood itself runs on several threads; the result does not depend on how many.
///
/// Source: Salembier, Oliveras, Garrido 1998 (hierarchical queues) with the component stack of Nister and Stewenius
/// 2008; [LST] 2.3 defines the tree. Deviation from both: a level's triangles are taken first in, first out, from one
/// array.
ComponentTree build_component_tree(std::span<const std::int32_t> twins, std::span<const double> areas,
                                   std::span<const std::int32_t> level_of_triangle, std::int32_t num_levels,
                                   const Execution& execution = {});

/// The level of every triangle as the tree has it ([LST] Theorem 2): hi of its node, 0 for a triangle in no node.
std::vector<std::int32_t> rebuild_levels(const ComponentTree& tree);

}  // namespace meshmser
