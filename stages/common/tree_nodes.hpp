#pragma once
/// What follows for the nodes of a component tree from the tree alone.

#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/artifacts/level_set_trees.hpp"

namespace meshmser {

/// The smallest id among the triangles of each node, descendants included. O(N + F).
std::vector<std::int32_t> smallest_triangle_of_nodes(const ComponentTree& tree);

/// Area of a node in coordinate units squared.
double area_of_node(const ComponentTree& tree, std::int32_t node);

/// The place in `nodes` (ascending) of the smallest of them that holds each node of the tree (#N); -1: none. O(N).
std::vector<std::int32_t> smallest_listed_nodes(const ComponentTree& tree, std::span<const std::int32_t> nodes);

/// Of each node of a list (ascending) the place there of the nearest that holds it; -1: none. O(nodes).
std::vector<std::int32_t> nearest_listed_ancestors(const ComponentTree& tree, std::span<const std::int32_t> nodes);

}  // namespace meshmser
