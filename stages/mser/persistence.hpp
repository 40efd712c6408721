#pragma once
/// Selections built on the maxima of a component tree and on how long they last (definitions 7).

#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/artifacts/level_set_trees.hpp"
#include "stages/common/maxima.hpp"
#include "stages/mser/node_fate.hpp"

namespace meshmser {

struct Significance {
  double min_persistence = 0;  ///< a significant maximum lasts longer than this, in units of S
  double min_area = 0;         ///< and is the highest of a node of at least this area, in coordinate units squared
};

/// The largest nodes that hold exactly one significant maximum, ascending; a root that holds one only gives nothing. In
/// a tree of shapes the maximum of a bright node and the minimum of a dark one count, in the nodes on its way up only
/// (see way_up_ends): a pit with one bottom is one, and a bump in it another.
/// `fates` (#N), where given, tells why not of every other node. O(N).
std::vector<std::int32_t> select_persistence(const ComponentTree& tree, const Maxima& maxima,
                                             const Significance& significance, NodeFates* fates = nullptr);

/// For each node of select_persistence the node of least q from it up to its maximum, of those of at least the area
/// that makes a maximum significant and itself, ties to the larger node; ascending. `changes`: of change_of_nodes;
/// `fates` as for select_persistence. O(N).
std::vector<std::int32_t> select_stable_branch(const ComponentTree& tree, const Maxima& maxima,
                                               std::span<const std::int64_t> changes, const Significance& significance,
                                               NodeFates* fates = nullptr);

}  // namespace meshmser
