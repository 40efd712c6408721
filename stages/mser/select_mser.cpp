#include "stages/mser/select_mser.hpp"

#include "stages/mser/stability.hpp"

namespace meshmser {
namespace {

/// The child of largest area of each node, ties to the smallest triangle id; -1 for a leaf.
std::vector<std::int32_t> main_child_of_nodes(const ComponentTree& tree) {
  std::vector<std::int32_t> main_child(tree.num_nodes(), -1);
  std::vector<std::int32_t> smallest;
  for (std::size_t n = 0; n < tree.num_nodes(); ++n) {
    if (tree.parent_of_node[n] < 0) continue;
    std::int32_t& best = main_child[static_cast<std::size_t>(tree.parent_of_node[n])];
    bool better = best < 0;
    if (!better) {
      const auto b = static_cast<std::size_t>(best);
      if (tree.area_of_node[n] == tree.area_of_node[b]) {
        if (smallest.empty()) smallest = smallest_triangle_of_nodes(tree);
        better = smallest[n] < smallest[b];
      } else {
        better = tree.area_of_node[n] > tree.area_of_node[b];
      }
    }
    if (better) best = static_cast<std::int32_t>(n);
  }
  return main_child;
}

}  // namespace

std::vector<std::int32_t> select_mser(const ComponentTree& tree, std::span<const std::int64_t> changes,
                                      const SelectMserParameters& parameters,
                                      std::span<const std::uint8_t> open_root_of_node, NodeFates* fates) {
  const std::size_t num_nodes = tree.num_nodes();
  std::vector<std::int32_t> main_child;
  if (parameters.against == Against::kMainChild) main_child = main_child_of_nodes(tree);
  // A plateau of equal q is stood for by its largest node, which is the one nearest to the root.
  std::vector<std::int32_t> plateau(num_nodes);
  // The first node found to beat the plateau that a node stands for, or -1.
  std::vector<std::int32_t> rival(num_nodes, -1);
  for (std::size_t n = num_nodes; n-- > 0;) {
    plateau[n] = static_cast<std::int32_t>(n);
    if (tree.parent_of_node[n] < 0) continue;
    const auto parent = static_cast<std::size_t>(tree.parent_of_node[n]);
    if (!main_child.empty() && main_child[parent] != static_cast<std::int32_t>(n)) continue;
    const std::strong_ordering order =
        compare_stability(changes[n], tree.area_of_node[n], changes[parent], tree.area_of_node[parent]);
    if (order == 0)
      plateau[n] = plateau[parent];
    else if (order > 0)
      rival[n] = static_cast<std::int32_t>(parent);
    else if (std::int32_t& of_parent = rival[static_cast<std::size_t>(plateau[parent])]; of_parent < 0)
      of_parent = static_cast<std::int32_t>(n);
  }
  std::vector<std::int32_t> selected;
  for (std::size_t n = 0; n < num_nodes; ++n) {
    const bool root = tree.parent_of_node[n] < 0;
    if (root && (open_root_of_node.empty() || open_root_of_node[n] == 0)) {
      tell_fate(fates, n, {NodeFate::Kind::kRoot});
      continue;
    }
    const bool unchanged = changes[n] == 0 && tree.area_of_node[n] != 0;
    const std::int32_t beaten_by = rival[static_cast<std::size_t>(plateau[n])];
    if (unchanged || (plateau[n] == static_cast<std::int32_t>(n) && beaten_by < 0))
      selected.push_back(static_cast<std::int32_t>(n));
    else if (beaten_by >= 0)
      tell_fate(fates, n, {NodeFate::Kind::kLessStable, -1, beaten_by});
    else
      tell_fate(fates, n, {NodeFate::Kind::kSmallerOfPlateau, -1, plateau[n]});
  }
  return selected;
}

std::vector<std::int32_t> select_mser(const ComponentTree& tree, const SelectMserParameters& parameters,
                                      std::span<const std::uint8_t> open_root_of_node) {
  return select_mser(tree, change_of_nodes(tree, parameters.delta), parameters, open_root_of_node);
}

std::vector<std::uint8_t> open_roots(const ComponentTree& tree, std::span<const std::int32_t> twins,
                                     std::span<const std::uint8_t> excluded_of_triangle) {
  std::vector<std::uint8_t> open;
  std::vector<std::int32_t> root_of_node;
  for (std::size_t t = 0; t < tree.node_of_triangle.size(); ++t) {
    if (tree.node_of_triangle[t] >= 0 || (!excluded_of_triangle.empty() && excluded_of_triangle[t] != 0)) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t twin = twins[3 * t + k];
      if (twin < 0) continue;
      const std::int32_t node = tree.node_of_triangle[static_cast<std::size_t>(twin / 3)];
      if (node < 0) continue;
      if (open.empty()) {
        open.assign(tree.num_nodes(), 0);
        root_of_node.resize(tree.num_nodes());
        for (std::size_t n = tree.num_nodes(); n-- > 0;) {
          const std::int32_t parent = tree.parent_of_node[n];
          root_of_node[n] = parent < 0 ? static_cast<std::int32_t>(n) : root_of_node[static_cast<std::size_t>(parent)];
        }
      }
      open[static_cast<std::size_t>(root_of_node[static_cast<std::size_t>(node)])] = 1;
    }
  }
  return open;
}

}  // namespace meshmser
