#pragma once
/// Maximally stable nodes of a component tree (definitions 7).

#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/artifacts/level_set_trees.hpp"
#include "stages/mser/node_fate.hpp"

namespace meshmser {

/// With which nodes a node's stability is compared.
enum class Against : std::uint8_t {
  kChildren,   ///< its parent and every child [Digne et al. 2010]
  kMainChild,  ///< its parent, where it is the parent's main child, and its own child of largest area
};

struct SelectMserParameters {
  std::int32_t delta = 3;  ///< level steps, >= 1
  Against against = Against::kChildren;
};

/// The stable nodes, ascending: those whose q is 0, and the largest node of each set of nodes of equal q joined by
/// links that has no link to a node of lower q. Roots compete but are not selected, but for those marked in
/// `open_root_of_node` (#N, or empty for none; see open_roots). `changes`: of change_of_nodes with the same delta.
/// `fates` (#N), where given, tells of every other node which one beat it: its parent, else its child, of lower q.
/// O(N), and O(F) where the main child is decided by a tie. Comparisons are exact, so ties are ties.
/// Digne et al. 2010, algorithm 1, lines 4 to 10. Deviations: a plateau of q is taken as one, and gives its largest
/// node.
std::vector<std::int32_t> select_mser(const ComponentTree& tree, std::span<const std::int64_t> changes,
                                      const SelectMserParameters& parameters = {},
                                      std::span<const std::uint8_t> open_root_of_node = {}, NodeFates* fates = nullptr);

/// The same, with the changes computed on the way.
std::vector<std::int32_t> select_mser(const ComponentTree& tree, const SelectMserParameters& parameters = {},
                                      std::span<const std::uint8_t> open_root_of_node = {});

/// Marks (#N) the roots that border on triangles below an explicit h_1: these have a level border, so they may be
/// selected. `twins`: twin half-edge of each half-edge, -1 at a rim. `excluded_of_triangle`: #F, or empty for none.
/// Empty where every triangle is in a node or excluded. O(F).
std::vector<std::uint8_t> open_roots(const ComponentTree& tree, std::span<const std::int32_t> twins,
                                     std::span<const std::uint8_t> excluded_of_triangle);

}  // namespace meshmser
