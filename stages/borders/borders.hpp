#pragma once
/// Closed borders of regions and label patches (definitions 10), on plain arrays.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/artifacts/border_set.hpp"
#include "pipeline/artifacts/level_set_trees.hpp"
#include "pipeline/execution/execution.hpp"
#include "stages/common/surface.hpp"

namespace meshmser {

/// The border loops of nodes of a component tree.
///
/// `number_of_node`: #N; > 0 marks a region and is its number, 0 is none; several nodes never bear one number.
/// `number_behind`: #F, what stands in `neighbours` for a level edge with that triangle behind it (the smallest region
/// that contains it). Loops are in the order of definitions 10: by ascending number, then longest first, then smallest
/// first half-edge. Loops of hole edges alone are counted, not returned.
/// Time linear in mesh + tree + output, whatever the depth of nesting (but for rotating about vertices, whose fans
/// are walked once per region that passes); the result does not depend on the number of threads.
/// Source: [LST] 3.3.
BorderLoops extract_borders(const SurfaceView& surface, const ComponentTree& tree,
                            std::span<const std::int32_t> number_of_node, std::span<const std::int32_t> number_behind,
                            const Execution& execution = {});

/// The border loops of the patches of equal label; label 0 is background and has none. `label_of_triangle`: #F; a
/// triangle that was cut out bears 0. Order and hole loops as for extract_borders. Time linear in the mesh.
BorderLoops extract_label_borders(const SurfaceView& surface, std::span<const std::int32_t> label_of_triangle,
                                  const Execution& execution = {});

/// Loops of two extractions with no common owner as one, by owner.
BorderLoops merge_borders(const BorderLoops& first, const BorderLoops& second);

}  // namespace meshmser
