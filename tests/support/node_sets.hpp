#pragma once
/// The nodes of a component tree as sets of triangles, by climbing from every triangle.

#include <cstdint>
#include <set>
#include <vector>

#include "pipeline/artifacts/level_set_trees.hpp"

namespace meshmser::testing {

/// #N: the triangles of every node, descendants included. O(F x depth).
inline std::vector<std::set<std::int32_t>> sets_of(const ComponentTree& tree) {
  std::vector<std::set<std::int32_t>> sets(tree.num_nodes());
  for (std::size_t t = 0; t < tree.node_of_triangle.size(); ++t)
    for (std::int32_t n = tree.node_of_triangle[t]; n >= 0; n = tree.parent_of_node[static_cast<std::size_t>(n)])
      sets[static_cast<std::size_t>(n)].insert(static_cast<std::int32_t>(t));
  return sets;
}

}  // namespace meshmser::testing
