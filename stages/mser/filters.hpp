#pragma once
/// What may remove a selected node again (definitions 8). Each filter takes the selected nodes of one tree, ascending,
/// and returns those that stay, ascending. Where `fates` (#N) are given, those that go have the node for which they
/// went as their rival.

#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/artifacts/level_set_trees.hpp"
#include "stages/mser/node_fate.hpp"
#include "stages/mser/persistence.hpp"

namespace meshmser {

/// What remains of a chain of nested selected nodes.
enum class Nested : std::uint8_t {
  kKeep,
  kOutermost,   ///< those within no other
  kInnermost,   ///< those that hold no other
  kMostStable,  ///< the least q first; its ancestors and descendants go; and so on
};

/// Nodes whose area, in coordinate units squared, is at least `least` and at most `most`. O(selected).
std::vector<std::int32_t> filter_area(const ComponentTree& tree, std::span<const std::int32_t> selected, double least,
                                      double most);

/// Nodes whose q is at most `most`. O(selected).
std::vector<std::int32_t> filter_variation(const ComponentTree& tree, std::span<const std::int64_t> changes,
                                           std::span<const std::int32_t> selected, double most);

/// Nodes whose highest maximum lasts over at least `least`, in units of S. O(selected).
std::vector<std::int32_t> filter_persistence(const Maxima& maxima, std::span<const std::int32_t> selected,
                                             double least);

/// Resolves pairs of like size: a node whose area is within the share `least` of its nearest selected ancestor's
/// (A(ancestor) - A(node) < least A(ancestor)) and that ancestor cannot both stay; the one of smaller q does, ties the
/// ancestor. From the leaves up; an ancestor meets the nodes nearest below it by ascending smallest triangle id, and
/// those below one that has just lost in its place. One of each chain always stays. O(N + F) and sorting.
std::vector<std::int32_t> filter_diversity(const ComponentTree& tree, std::span<const std::int64_t> changes,
                                           std::span<const std::int32_t> selected, double least,
                                           NodeFates* fates = nullptr);

/// Thins chains of nested nodes. Most stable: ties of q to the larger area, then the smaller triangle id, then the
/// larger node. O(N), sorting and a F pass for kMostStable.
std::vector<std::int32_t> filter_nested(const ComponentTree& tree, std::span<const std::int64_t> changes,
                                        std::span<const std::int32_t> selected, Nested nested,
                                        NodeFates* fates = nullptr);

}  // namespace meshmser
