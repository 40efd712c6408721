#pragma once
/// A triangle's way through the component trees: the nodes that hold it and what became of each.

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "stages/mser/segment.hpp"

namespace meshmser {

/// A node that holds the triangle, or a rival of one that does.
struct ExplainedNode {
  std::int32_t node = -1;
  std::int32_t lo = 0, hi = 0;       ///< the levels over which it is a component, from 1
  double value = 0;                  ///< S on its line: h at lo (not of -S); infinite below all levels
  Polarity side = Polarity::kUpper;  ///< of its line: upper or lower
  double area = 0;                   ///< in coordinate units squared
  double stability = 0;              ///< q
  double persistence = 0;            ///< of its highest maximum, in units of S
  double contrast = std::numeric_limits<double>::quiet_NaN();  ///< NaN: gone before it was measured
  NodeFate fate;
  std::int32_t region = 0;  ///< 1 + index of the region that it is; 0: none
};

/// The nodes of a tree (by index) that hold the triangle, from its own to the root; empty where the triangle is
/// excluded or below h_1. `selection` and `fates`: both of select_regions. Linear in the path and in the regions.
std::vector<ExplainedNode> explain_triangle(const LevelSetTrees& level_sets, const RegionSelection& selection,
                                            std::span<const NodeFates> fates, std::size_t tree, std::int32_t triangle);

/// What is known of one node.
ExplainedNode explain_node(const LevelSetTrees& level_sets, const RegionSelection& selection,
                           std::span<const NodeFates> fates, std::size_t tree, std::int32_t node);

/// The rivals that are not on the path themselves, and theirs, so that no story ends with a node of which nothing is
/// told: in the order in which they are named.
std::vector<ExplainedNode> explain_rivals(const LevelSetTrees& level_sets, const RegionSelection& selection,
                                          std::span<const NodeFates> fates, std::size_t tree,
                                          std::span<const ExplainedNode> path);

struct ClosestTriangle {
  std::int32_t triangle = -1;
  double distance = std::numeric_limits<double>::infinity();
};

/// The triangle nearest to a point, ties to the smaller id; -1 for a surface without triangles. O(F).
/// Source: Ericson, Real-Time Collision Detection, 2005, 5.1.5.
ClosestTriangle closest_triangle(const SurfaceView& surface, const Eigen::Vector3d& point);

}  // namespace meshmser
