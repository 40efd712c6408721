#pragma once
/// Maxima of a component tree and how long they last (definitions 7).

#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/artifacts/level_set_trees.hpp"

namespace meshmser {

/// The maxima (leaves) of a tree. Where two meet, the one of the higher level lives on; ties to the smaller triangle
/// id. In a tree of shapes the way up from a maximum (of a bright node) or a minimum (of a dark one) ends where bright
/// turns into dark or at the root, so that a bump in a pit lasts as long as it rises above the pit's floor; a node that
/// holds none of its own side but itself is a leaf.
struct Maxima {
  std::vector<std::int32_t> highest_of_node;  ///< #N: the leaf of the highest maximum in the node
  std::vector<std::int32_t> top_of_leaf;      ///< #N: of a leaf the largest node in which it is the highest; else -1
  std::vector<double> persistence_of_leaf;    ///< #N: of a leaf, in units of S; else 0

  /// Of the highest maximum in a node.
  double persistence_of_node(std::int32_t node) const {
    return persistence_of_leaf[static_cast<std::size_t>(highest_of_node[static_cast<std::size_t>(node)])];
  }
};

/// Whether the way up from the maxima in a node, which is no root, ends there, whatever is around it: in a tree of shapes
/// where its parent is of the other side or a root. O(1).
bool way_up_ends(const ComponentTree& tree, std::int32_t node);

/// Finds the maxima. A root's highest maximum lasts over the whole range of the levels; an infinite h_1 counts as the
/// low end of the range (see heights_of_levels). O(N + F), no dependence on order beyond triangle ids. Source: elder
/// rule, Edelsbrunner, Letscher, Zomorodian 2002.
Maxima find_maxima(const ComponentTree& tree);

/// The levels with an infinite h_1 replaced by the low end of the range over which the others are laid.
std::vector<double> finite_levels(std::span<const double> levels);

/// Finite values of the levels by their number, of the signed scalar, 0 (below all) included: n + 1 values. Below an
/// explicit h_1 lies the same end of the range as where h_1 is infinite; else 0 and h_1 have it in common.
std::vector<double> heights_of_levels(std::span<const double> levels);

}  // namespace meshmser
