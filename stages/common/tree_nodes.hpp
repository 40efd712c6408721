#pragma once
/// What follows for the nodes of a component tree from the tree alone.

#include <cstdint>
#include <vector>

#include "pipeline/artifacts/level_set_trees.hpp"

namespace meshmser {

/// The smallest id among the triangles of each node, descendants included. O(N + F).
std::vector<std::int32_t> smallest_triangle_of_nodes(const ComponentTree& tree);

/// Area of a node in coordinate units squared.
double area_of_node(const ComponentTree& tree, std::int32_t node);

}  // namespace meshmser
