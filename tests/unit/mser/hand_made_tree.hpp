#pragma once
/// Component trees written down by hand: nodes in postorder, each with its parent, hi and the area of its own
/// triangles.

#include <limits>
#include <vector>

#include "pipeline/artifacts/level_set_trees.hpp"

namespace meshmser {

struct HandMadeNode {
  std::int32_t parent;
  std::int32_t hi;
  std::int64_t own_area;  ///< one triangle of this area
};

/// A tree whose node n owns triangle n. `num_levels` levels: minus infinity, 1, 2 ...
inline ComponentTree make_tree(const std::vector<HandMadeNode>& nodes, std::int32_t num_levels) {
  ComponentTree tree;
  for (std::int32_t k = 0; k < num_levels; ++k)
    tree.levels.push_back(k == 0 ? -std::numeric_limits<double>::infinity() : k);
  const std::size_t n = nodes.size();
  tree.area_of_node.assign(n, 0);
  tree.area_exponent_of_node.assign(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    tree.parent_of_node.push_back(nodes[i].parent);
    tree.hi_of_node.push_back(nodes[i].hi);
    tree.first_node_of_subtree.push_back(static_cast<std::int32_t>(i));
    tree.node_of_triangle.push_back(static_cast<std::int32_t>(i));
  }
  for (std::size_t i = 0; i < n; ++i) {
    tree.area_of_node[i] += nodes[i].own_area;
    if (nodes[i].parent < 0) continue;
    const auto parent = static_cast<std::size_t>(nodes[i].parent);
    tree.area_of_node[parent] += tree.area_of_node[i];
    tree.first_node_of_subtree[parent] = std::min(tree.first_node_of_subtree[parent], tree.first_node_of_subtree[i]);
  }
  return tree;
}

}  // namespace meshmser
