#include "stages/common/maxima.hpp"

#include <cmath>
#include <limits>

#include "stages/common/tree_nodes.hpp"

namespace meshmser {

std::vector<double> finite_levels(std::span<const double> levels) {
  std::vector<double> finite(levels.begin(), levels.end());
  if (finite.empty() || std::isfinite(finite[0])) return finite;
  // The others are laid at equal steps from the low end, which is one step below the first of them.
  if (finite.size() == 1)
    finite[0] = 0;
  else
    finite[0] = finite.size() == 2 ? finite[1] : 2 * finite[1] - finite[2];
  return finite;
}

std::vector<double> heights_of_levels(std::span<const double> levels) {
  std::vector<double> heights(levels.begin(), levels.end());
  if (heights.empty()) return {0};
  const bool infinite = !std::isfinite(heights[0]);
  if (!infinite) heights.insert(heights.begin(), -std::numeric_limits<double>::infinity());
  heights = finite_levels(heights);
  if (infinite) heights.insert(heights.begin(), heights[0]);
  return heights;
}

bool way_up_ends(const ComponentTree& tree, std::int32_t node) {
  if (tree.polarity != Polarity::kShapes) return false;
  const std::int32_t parent = tree.parent_of_node[static_cast<std::size_t>(node)];
  return tree.parent_of_node[static_cast<std::size_t>(parent)] < 0 ||
         tree.side_of_node[static_cast<std::size_t>(node)] != tree.side_of_node[static_cast<std::size_t>(parent)];
}

Maxima find_maxima(const ComponentTree& tree) {
  const std::size_t num_nodes = tree.num_nodes();
  const std::vector<double> heights = heights_of_levels(tree.levels);
  const std::vector<std::int32_t> smallest = smallest_triangle_of_nodes(tree);
  const auto height = [&](std::size_t node) {
    return heights[static_cast<std::size_t>(tree.own_level(static_cast<std::int32_t>(node)))];
  };

  Maxima maxima;
  maxima.highest_of_node.assign(num_nodes, -1);
  maxima.top_of_leaf.assign(num_nodes, -1);
  maxima.persistence_of_leaf.assign(num_nodes, 0);
  const auto ends_below = [&](std::int32_t leaf, std::int32_t top, double persistence) {
    maxima.top_of_leaf[static_cast<std::size_t>(leaf)] = top;
    maxima.persistence_of_leaf[static_cast<std::size_t>(leaf)] = persistence;
  };
  // The child through which each node got its highest maximum so far.
  std::vector<std::int32_t> through_child(num_nodes, -1);
  for (std::size_t n = 0; n < num_nodes; ++n) {
    std::int32_t& leaf = maxima.highest_of_node[n];
    if (leaf < 0) leaf = static_cast<std::int32_t>(n);
    if (tree.parent_of_node[n] < 0) {
      ends_below(leaf, static_cast<std::int32_t>(n), heights.back() - heights[1]);
      continue;
    }
    const auto parent = static_cast<std::size_t>(tree.parent_of_node[n]);
    if (way_up_ends(tree, static_cast<std::int32_t>(n))) {
      ends_below(leaf, static_cast<std::int32_t>(n), std::abs(height(static_cast<std::size_t>(leaf)) - height(parent)));
      continue;
    }
    std::int32_t& rival = maxima.highest_of_node[parent];
    if (rival < 0) {
      rival = leaf;
      through_child[parent] = static_cast<std::int32_t>(n);
      continue;
    }
    const auto l = static_cast<std::size_t>(leaf), r = static_cast<std::size_t>(rival);
    const bool higher =
        tree.hi_of_node[l] != tree.hi_of_node[r] ? tree.hi_of_node[l] > tree.hi_of_node[r] : smallest[l] < smallest[r];
    if (higher) {
      ends_below(rival, through_child[parent], std::abs(height(r) - height(parent)));
      rival = leaf;
      through_child[parent] = static_cast<std::int32_t>(n);
    } else {
      ends_below(leaf, static_cast<std::int32_t>(n), std::abs(height(l) - height(parent)));
    }
  }
  return maxima;
}

}  // namespace meshmser
