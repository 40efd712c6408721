#pragma once
/// From selected nodes to numbered regions and to a region for each triangle (definitions 9).

#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/artifacts/level_set_trees.hpp"

namespace meshmser {

/// A selected node of one of the trees of a mesh.
struct SelectedNode {
  std::int32_t tree = 0;
  std::int32_t node = 0;

  bool operator==(const SelectedNode&) const = default;
};

/// The selected nodes of all trees as one list: by decreasing area, then smallest triangle id, then upper before lower,
/// then the larger node first. `selected_of_tree`: one ascending list for each tree. Areas are compared exactly.
/// Sorting, and O(N + F) where areas tie.
std::vector<SelectedNode> order_regions(std::span<const ComponentTree> trees,
                                        std::span<const std::vector<std::int32_t>> selected_of_tree);

/// The number (1 + its index) of the region that each node of a tree is; 0: none (#N), as extract_borders wants it.
/// O(N).
std::vector<std::int32_t> number_of_nodes(const ComponentTree& tree, std::span<const SelectedNode> regions,
                                          std::int32_t tree_index = 0);

/// The smallest region that contains each triangle, as 1 + its index in `regions`; 0: none (#F). Of two regions of
/// equal area in different trees that of the earlier tree. O(N + F). Digne et al. 2010, algorithm 1, line 18.
std::vector<std::int32_t> label_triangles(std::span<const ComponentTree> trees, std::span<const SelectedNode> regions);

/// The smallest region of the same tree that properly contains each region, as 1 + its index; -1: none. O(N).
std::vector<std::int32_t> parent_regions(std::span<const ComponentTree> trees, std::span<const SelectedNode> regions);

}  // namespace meshmser
