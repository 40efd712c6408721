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

}  // namespace meshmser
