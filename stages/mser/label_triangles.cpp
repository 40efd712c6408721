#include "stages/mser/label_triangles.hpp"

#include <algorithm>

#include "stages/common/large_pages.hpp"
#include "stages/mser/stability.hpp"

namespace meshmser {
namespace {

std::strong_ordering compare_region_areas(std::span<const ComponentTree> trees, const SelectedNode& a,
                                          const SelectedNode& b) {
  const ComponentTree& tree_a = trees[static_cast<std::size_t>(a.tree)];
  const ComponentTree& tree_b = trees[static_cast<std::size_t>(b.tree)];
  const auto m = static_cast<std::size_t>(a.node), n = static_cast<std::size_t>(b.node);
  return compare_area(tree_a.area_of_node[m], tree_a.area_exponent_of_node[m], tree_b.area_of_node[n],
                      tree_b.area_exponent_of_node[n]);
}

/// 1 + index of the smallest region at or above each node of a tree; 0: none.
std::vector<std::int32_t> region_of_nodes(const ComponentTree& tree, std::span<const SelectedNode> regions,
                                          std::int32_t tree_index) {
  std::vector<std::int32_t> region = number_of_nodes(tree, regions, tree_index);
  for (std::size_t n = tree.num_nodes(); n-- > 0;)
    if (region[n] == 0 && tree.parent_of_node[n] >= 0)
      region[n] = region[static_cast<std::size_t>(tree.parent_of_node[n])];
  return region;
}

}  // namespace

std::vector<SelectedNode> order_regions(std::span<const ComponentTree> trees,
                                        std::span<const std::vector<std::int32_t>> selected_of_tree) {
  std::vector<SelectedNode> regions;
  for (std::size_t tree = 0; tree < trees.size(); ++tree)
    for (const std::int32_t node : selected_of_tree[tree]) regions.push_back({static_cast<std::int32_t>(tree), node});
  std::stable_sort(regions.begin(), regions.end(),
                   [&](const SelectedNode& a, const SelectedNode& b) { return compare_region_areas(trees, a, b) > 0; });
  std::vector<std::vector<std::int32_t>> smallest(trees.size());
  for (std::size_t begin = 0, end = 0; begin < regions.size(); begin = end) {
    end = begin + 1;
    while (end < regions.size() && compare_region_areas(trees, regions[begin], regions[end]) == 0) ++end;
    if (end - begin == 1) continue;
    const auto smallest_triangle = [&](const SelectedNode& region) {
      const auto tree = static_cast<std::size_t>(region.tree);
      if (smallest[tree].empty()) smallest[tree] = smallest_triangle_of_nodes(trees[tree]);
      return smallest[tree][static_cast<std::size_t>(region.node)];
    };
    std::sort(regions.begin() + static_cast<std::ptrdiff_t>(begin), regions.begin() + static_cast<std::ptrdiff_t>(end),
              [&](const SelectedNode& a, const SelectedNode& b) {
                const std::int32_t i = smallest_triangle(a), j = smallest_triangle(b);
                if (i != j) return i < j;
                if (a.tree != b.tree) return a.tree < b.tree;
                return a.node > b.node;
              });
  }
  return regions;
}

std::vector<std::int32_t> number_of_nodes(const ComponentTree& tree, std::span<const SelectedNode> regions,
                                          std::int32_t tree_index) {
  std::vector<std::int32_t> number(tree.num_nodes(), 0);
  for (std::size_t i = 0; i < regions.size(); ++i)
    if (regions[i].tree == tree_index)
      number[static_cast<std::size_t>(regions[i].node)] = static_cast<std::int32_t>(i) + 1;
  return number;
}

std::vector<std::int32_t> label_triangles(std::span<const ComponentTree> trees, std::span<const SelectedNode> regions) {
  std::vector<std::int32_t> label;
  for (std::size_t tree = 0; tree < trees.size(); ++tree) {
    const std::vector<std::int32_t> region = region_of_nodes(trees[tree], regions, static_cast<std::int32_t>(tree));
    const std::vector<std::int32_t>& node_of_triangle = trees[tree].node_of_triangle;
    const auto region_at = [&](std::size_t t) {
      return node_of_triangle[t] < 0 ? 0 : region[static_cast<std::size_t>(node_of_triangle[t])];
    };
    if (tree == 0) {
      reserve_on_large_pages(label, node_of_triangle.size());
      for (std::size_t t = 0; t < node_of_triangle.size(); ++t) label.push_back(region_at(t));
      continue;
    }
    for (std::size_t t = 0; t < node_of_triangle.size(); ++t) {
      const std::int32_t here = region_at(t);
      if (here == 0) continue;
      if (label[t] == 0) {
        label[t] = here;
        continue;
      }
      // Regions are in descending order of area, so the later is smaller unless the two are equal.
      const SelectedNode &mine = regions[static_cast<std::size_t>(here) - 1],
                         &other = regions[static_cast<std::size_t>(label[t]) - 1];
      if (here > label[t] && compare_region_areas(trees, mine, other) < 0) label[t] = here;
    }
  }
  return label;
}

std::vector<std::int32_t> parent_regions(std::span<const ComponentTree> trees, std::span<const SelectedNode> regions) {
  std::vector<std::int32_t> parent(regions.size(), -1);
  for (std::size_t tree = 0; tree < trees.size(); ++tree) {
    const std::vector<std::int32_t> region = region_of_nodes(trees[tree], regions, static_cast<std::int32_t>(tree));
    for (std::size_t i = 0; i < regions.size(); ++i) {
      if (regions[i].tree != static_cast<std::int32_t>(tree)) continue;
      const std::int32_t above = trees[tree].parent_of_node[static_cast<std::size_t>(regions[i].node)];
      if (above >= 0 && region[static_cast<std::size_t>(above)] > 0)
        parent[i] = region[static_cast<std::size_t>(above)];
    }
  }
  return parent;
}

}  // namespace meshmser
