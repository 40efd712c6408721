#include "stages/common/tree_nodes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace meshmser {

std::vector<std::int32_t> smallest_triangle_of_nodes(const ComponentTree& tree) {
  std::vector<std::int32_t> smallest(tree.num_nodes(), std::numeric_limits<std::int32_t>::max());
  for (std::size_t t = tree.node_of_triangle.size(); t-- > 0;)
    if (tree.node_of_triangle[t] >= 0)
      smallest[static_cast<std::size_t>(tree.node_of_triangle[t])] = static_cast<std::int32_t>(t);
  for (std::size_t n = 0; n < tree.num_nodes(); ++n) {
    const std::int32_t parent = tree.parent_of_node[n];
    if (parent >= 0)
      smallest[static_cast<std::size_t>(parent)] = std::min(smallest[static_cast<std::size_t>(parent)], smallest[n]);
  }
  return smallest;
}

double area_of_node(const ComponentTree& tree, std::int32_t node) {
  const auto n = static_cast<std::size_t>(node);
  return std::ldexp(static_cast<double>(tree.area_of_node[n]), -tree.area_exponent_of_node[n]);
}

std::vector<std::int32_t> smallest_listed_nodes(const ComponentTree& tree, std::span<const std::int32_t> nodes) {
  std::vector<std::int32_t> place(tree.num_nodes(), -1);
  for (std::size_t i = 0; i < nodes.size(); ++i)
    place[static_cast<std::size_t>(nodes[i])] = static_cast<std::int32_t>(i);
  for (std::size_t n = tree.num_nodes(); n-- > 0;)
    if (place[n] < 0 && tree.parent_of_node[n] >= 0) place[n] = place[static_cast<std::size_t>(tree.parent_of_node[n])];
  return place;
}

std::vector<std::int32_t> nearest_listed_ancestors(const ComponentTree& tree, std::span<const std::int32_t> nodes) {
  std::vector<std::int32_t> ancestor(nodes.size(), -1);
  // The listed nodes whose subtree is not left yet; in descending order a node comes before all of its subtree.
  std::vector<std::int32_t> open;
  for (std::size_t i = nodes.size(); i-- > 0;) {
    const std::int32_t node = nodes[i];
    while (!open.empty() &&
           tree.first_node_of_subtree[static_cast<std::size_t>(nodes[static_cast<std::size_t>(open.back())])] > node)
      open.pop_back();
    if (!open.empty()) ancestor[i] = open.back();
    open.push_back(static_cast<std::int32_t>(i));
  }
  return ancestor;
}

}  // namespace meshmser
