#include "stages/tree/edit_tree.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "pipeline/execution/error.hpp"
#include "stages/common/maxima.hpp"
#include "stages/common/tree_nodes.hpp"

namespace meshmser {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

double sign_of(const ComponentTree& tree) {
  return tree.polarity == Polarity::kLower ? -1 : 1;
}

}  // namespace

std::int32_t level_of_value(const ComponentTree& tree, double value) {
  return static_cast<std::int32_t>(std::upper_bound(tree.levels.begin(), tree.levels.end(), sign_of(tree) * value) -
                                   tree.levels.begin());
}

TreeCut cut_tree(const ComponentTree& tree, std::int32_t level) {
  TreeCut cut;
  for (std::size_t n = 0; n < tree.num_nodes(); ++n)
    if (tree.is_at(static_cast<std::int32_t>(n), level)) cut.nodes.push_back(static_cast<std::int32_t>(n));
  std::stable_sort(cut.nodes.begin(), cut.nodes.end(),
                   [&](std::int32_t a, std::int32_t b) { return area_of_node(tree, a) > area_of_node(tree, b); });
  std::vector<std::int32_t> component(tree.num_nodes(), 0);
  for (std::size_t i = 0; i < cut.nodes.size(); ++i)
    component[static_cast<std::size_t>(cut.nodes[i])] = static_cast<std::int32_t>(i) + 1;
  for (std::size_t n = tree.num_nodes(); n-- > 0;)
    if (component[n] == 0 && tree.parent_of_node[n] >= 0)
      component[n] = component[static_cast<std::size_t>(tree.parent_of_node[n])];
  cut.component_of_triangle.reserve(tree.node_of_triangle.size());
  for (const std::int32_t node : tree.node_of_triangle)
    cut.component_of_triangle.push_back(node < 0 ? 0 : component[static_cast<std::size_t>(node)]);
  return cut;
}

std::vector<std::uint8_t> nodes_of_area(const ComponentTree& tree, double min_area) {
  std::vector<std::uint8_t> keep(tree.num_nodes());
  for (std::size_t n = 0; n < keep.size(); ++n)
    keep[n] = tree.parent_of_node[n] < 0 || area_of_node(tree, static_cast<std::int32_t>(n)) >= min_area;
  return keep;
}

std::vector<std::uint8_t> nodes_of_persistence(const ComponentTree& tree, double min_persistence) {
  const Maxima maxima = find_maxima(tree);
  std::vector<std::uint8_t> keep(tree.num_nodes());
  for (std::size_t n = 0; n < keep.size(); ++n)
    keep[n] = tree.parent_of_node[n] < 0 || maxima.persistence_of_node(static_cast<std::int32_t>(n)) >= min_persistence;
  // A high bump may stand in a shallow pit.
  for (std::size_t n = 0; n < keep.size(); ++n)
    if (keep[n] != 0 && tree.parent_of_node[n] >= 0) keep[static_cast<std::size_t>(tree.parent_of_node[n])] = 1;
  return keep;
}

ComponentTree simplify_tree(const ComponentTree& tree, std::span<const std::uint8_t> keep) {
  const std::size_t n = tree.num_nodes();
  if (keep.size() != n)
    throw StageError("a tree of " + std::to_string(n) + " nodes is simplified by a list of " +
                     std::to_string(keep.size()) + "; give one mark a node");
  for (std::size_t i = 0; i < n; ++i) {
    const std::int32_t parent = tree.parent_of_node[i];
    if (parent < 0 ? keep[i] == 0 : keep[i] != 0 && keep[static_cast<std::size_t>(parent)] == 0)
      throw StageError("node " + std::to_string(i) +
                       (parent < 0 ? " is a root and must stay" : " would lose its parent"));
  }
  // Of a razed node the number of the kept one it falls to.
  std::vector<std::int32_t> number(n, -1);
  std::int32_t count = 0;
  for (std::size_t i = 0; i < n; ++i)
    if (keep[i] != 0) number[i] = count++;
  for (std::size_t i = n; i-- > 0;)
    if (keep[i] == 0) number[i] = number[static_cast<std::size_t>(tree.parent_of_node[i])];

  ComponentTree result;
  result.polarity = tree.polarity;
  result.levels = tree.levels;
  for (std::size_t i = 0; i < n; ++i) {
    if (keep[i] == 0) continue;
    const std::int32_t parent = tree.parent_of_node[i];
    result.parent_of_node.push_back(parent < 0 ? -1 : number[static_cast<std::size_t>(parent)]);
    result.hi_of_node.push_back(tree.hi_of_node[i]);
    result.area_of_node.push_back(tree.area_of_node[i]);
    result.area_exponent_of_node.push_back(tree.area_exponent_of_node[i]);
    result.first_node_of_subtree.push_back(number[i]);
    if (tree.polarity != Polarity::kShapes) continue;
    result.side_of_node.push_back(tree.side_of_node[i]);
    result.own_level_of_node.push_back(tree.own_level_of_node[i]);
  }
  // Children stand before their parents, so each first node is final when it is handed up.
  for (std::size_t i = 0; i < result.num_nodes(); ++i)
    if (const std::int32_t parent = result.parent_of_node[i]; parent >= 0) {
      std::int32_t& first = result.first_node_of_subtree[static_cast<std::size_t>(parent)];
      first = std::min(first, result.first_node_of_subtree[i]);
    }
  result.node_of_triangle.reserve(tree.node_of_triangle.size());
  for (const std::int32_t node : tree.node_of_triangle)
    result.node_of_triangle.push_back(node < 0 ? -1 : number[static_cast<std::size_t>(node)]);
  return result;
}

std::vector<double> reconstruct_triangle_values(const ComponentTree& tree) {
  std::vector<double> heights = heights_of_levels(tree.levels);
  // With one finite level there is no step to go by, and what is below must still be told from it.
  const std::size_t num_below = tree.levels.empty() ? 0 : std::isinf(tree.levels[0]) ? 2 : 1;
  if (heights.size() == num_below + 1)
    for (std::size_t k = 0; k < num_below; ++k) heights[k] = heights.back() - std::max(1.0, std::abs(heights.back()));
  std::vector<double> values;
  values.reserve(tree.node_of_triangle.size());
  for (const std::int32_t node : tree.node_of_triangle)
    values.push_back(node < 0 ? kNan : sign_of(tree) * heights[static_cast<std::size_t>(tree.own_level(node))]);
  return values;
}

std::vector<double> reconstruct_vertex_values(const ComponentTree& tree, std::span<const double> values_of_triangle,
                                              std::span<const std::array<std::int32_t, 3>> triangles,
                                              std::size_t num_vertices) {
  if (values_of_triangle.size() != triangles.size() || tree.node_of_triangle.size() != triangles.size())
    throw StageError(std::to_string(values_of_triangle.size()) + " values and a tree of " +
                     std::to_string(tree.node_of_triangle.size()) + " triangles are given for " +
                     std::to_string(triangles.size()) + " triangles");
  std::vector<double> values(num_vertices, kNan);
  // The greatest level met at each vertex, which in every tree is that of the smallest node.
  std::vector<std::int32_t> level_of_vertex(num_vertices, 0);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const double here = values_of_triangle[t];
    if (std::isnan(here) || tree.node_of_triangle[t] < 0) continue;
    const std::int32_t level = tree.hi_of_node[static_cast<std::size_t>(tree.node_of_triangle[t])];
    for (const std::int32_t v : triangles[t])
      if (level > level_of_vertex[static_cast<std::size_t>(v)]) {
        level_of_vertex[static_cast<std::size_t>(v)] = level;
        values[static_cast<std::size_t>(v)] = here;
      }
  }
  return values;
}

}  // namespace meshmser
