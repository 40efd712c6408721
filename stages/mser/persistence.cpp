#include "stages/mser/persistence.hpp"

#include <algorithm>

#include "stages/mser/stability.hpp"

namespace meshmser {

std::vector<std::int32_t> select_persistence(const ComponentTree& tree, const Maxima& maxima,
                                             const Significance& significance, NodeFates* fates) {
  // Significant maxima in each node, counted up to two.
  std::vector<std::uint8_t> count(tree.num_nodes(), 0);
  for (std::size_t n = 0; n < tree.num_nodes(); ++n) {
    if (maxima.top_of_leaf[n] >= 0 && maxima.persistence_of_leaf[n] > significance.min_persistence &&
        area_of_node(tree, maxima.top_of_leaf[n]) >= significance.min_area)
      count[n] = 1;
    if (tree.parent_of_node[n] >= 0 && !way_up_ends(tree, static_cast<std::int32_t>(n))) {
      std::uint8_t& sum = count[static_cast<std::size_t>(tree.parent_of_node[n])];
      sum = static_cast<std::uint8_t>(std::min(2, sum + count[n]));
    }
  }
  std::vector<std::int32_t> selected;
  for (std::size_t n = 0; n < tree.num_nodes(); ++n)
    if (count[n] == 1 && tree.parent_of_node[n] >= 0 &&
        (way_up_ends(tree, static_cast<std::int32_t>(n)) ||
         count[static_cast<std::size_t>(tree.parent_of_node[n])] == 2))
      selected.push_back(static_cast<std::int32_t>(n));
  if (fates == nullptr) return selected;
  for (std::size_t n = tree.num_nodes(); n-- > 0;) {
    const std::int32_t parent = tree.parent_of_node[n];
    NodeFate& fate = (*fates)[n];
    if (count[n] != 1) {
      fate = {count[n] == 0 ? NodeFate::Kind::kNoMaximum : NodeFate::Kind::kSeveralMaxima};
    } else if (parent < 0) {
      fate = {NodeFate::Kind::kSingleMaximum};
    } else if (const auto p = static_cast<std::size_t>(parent);
               count[p] == 1 && !way_up_ends(tree, static_cast<std::int32_t>(n))) {
      const bool below_region = (*fates)[p].kind == NodeFate::Kind::kRegion;
      fate = below_region ? NodeFate{NodeFate::Kind::kSmallerOfMaximum, -1, parent} : (*fates)[p];
    }
  }
  return selected;
}

std::vector<std::int32_t> select_stable_branch(const ComponentTree& tree, const Maxima& maxima,
                                               std::span<const std::int64_t> changes, const Significance& significance,
                                               NodeFates* fates) {
  std::vector<std::int32_t> selected = select_persistence(tree, maxima, significance, fates);
  for (std::int32_t& choice : selected) {
    const std::int32_t end = choice;
    // A speck at the very maximum changes little from level to level because it is small, not because it is stable.
    std::int32_t node = maxima.highest_of_node[static_cast<std::size_t>(end)];
    while (node != end && area_of_node(tree, node) < significance.min_area)
      node = tree.parent_of_node[static_cast<std::size_t>(node)];
    choice = node;
    while (node != end) {
      node = tree.parent_of_node[static_cast<std::size_t>(node)];
      const auto n = static_cast<std::size_t>(node), c = static_cast<std::size_t>(choice);
      if (compare_stability(changes[n], tree.area_of_node[n], changes[c], tree.area_of_node[c]) <= 0) choice = node;
    }
    if (fates == nullptr || choice == end) continue;
    for (std::int32_t n = tree.first_node_of_subtree[static_cast<std::size_t>(end)]; n <= end; ++n) {
      NodeFate& fate = (*fates)[static_cast<std::size_t>(n)];
      if (n == choice)
        fate = {};
      else if (n == end || (fate.kind == NodeFate::Kind::kSmallerOfMaximum && fate.rival == end))
        fate = {NodeFate::Kind::kNotOnBranch, -1, choice};
    }
  }
  std::sort(selected.begin(), selected.end());
  return selected;
}

}  // namespace meshmser
