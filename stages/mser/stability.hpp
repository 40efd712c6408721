#pragma once
/// How much a node of a component tree changes over the levels around it (definitions 7), exactly.

#include <compare>
#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/artifacts/level_set_trees.hpp"
#include "stages/common/tree_nodes.hpp"

namespace meshmser {

/// The numerator Up(N) - Down(N) of q for each node, in the area unit of its tree component. `delta` >= 1 level steps.
/// Throws StageError for a smaller delta. O(N log delta), O(N) memory.
/// Digne et al. 2010, algorithm 1, line 5, taken at the middle m of the levels over which the node lasts; the area that
/// is left delta levels further up is the sum over all descendants there.
std::vector<std::int64_t> change_of_nodes(const ComponentTree& tree, std::int32_t delta);

/// The same with `delta` > 0 in units of S: Up is taken at the greatest level at least that far below h at m (at the
/// lowest, where there is none), Down at the least level at least that far above. An infinite h_1 counts as in
/// finite_levels. Levels at just these distances are there where make_levels was told to insert them. Throws StageError
/// for a delta that is not positive, and for a tree of shapes, whose levels lie along lines of unlike steps. Digne et
/// al. 2010, section 3.
std::vector<std::int64_t> change_of_nodes_by_value(const ComponentTree& tree, double delta);

/// Compares change_a / area_a with change_b / area_b without rounding; an area of 0 stands for infinity.
std::strong_ordering compare_stability(std::int64_t change_a, std::int64_t area_a, std::int64_t change_b,
                                       std::int64_t area_b);

/// q of a node, rounded to double: 0 is perfectly stable, infinite for an area of 0.
double stability_of_node(const ComponentTree& tree, std::span<const std::int64_t> changes, std::int32_t node);

/// Compares areas a 2^-exponent_a and b 2^-exponent_b, both >= 0, without rounding.
std::strong_ordering compare_area(std::int64_t a, std::int32_t exponent_a, std::int64_t b, std::int32_t exponent_b);

}  // namespace meshmser
