#include "stages/mser/explain_triangle.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "stages/mser/stability.hpp"

namespace meshmser {
namespace {

Eigen::Vector3d closest_on_segment(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Vector3d ab = b - a;
  const double length2 = ab.squaredNorm();
  if (length2 == 0) return a;
  return a + std::clamp(ab.dot(p - a) / length2, 0.0, 1.0) * ab;
}

double squared_distance(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                        const Eigen::Vector3d& c) {
  const Eigen::Vector3d normal = (b - a).cross(c - a);
  const double length2 = normal.squaredNorm();
  const auto left_of = [&](const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    return (to - from).cross(p - from).dot(normal) >= 0;
  };
  if (length2 > 0 && left_of(a, b) && left_of(b, c) && left_of(c, a)) {
    const double height = normal.dot(p - a);
    return height * height / length2;
  }
  return std::min({(p - closest_on_segment(p, a, b)).squaredNorm(), (p - closest_on_segment(p, b, c)).squaredNorm(),
                   (p - closest_on_segment(p, c, a)).squaredNorm()});
}

}  // namespace

ExplainedNode explain_node(const LevelSetTrees& level_sets, const RegionSelection& selection,
                           std::span<const NodeFates> fates, std::size_t tree_index, std::int32_t node) {
  const ComponentTree& tree = level_sets.trees[tree_index];
  const TreeSelection& known = selection.selections[tree_index];
  ExplainedNode of;
  of.node = node;
  of.lo = tree.lo(node);
  of.hi = tree.hi_of_node[static_cast<std::size_t>(node)];
  of.value = tree.value(node);
  of.side = tree.side(node);
  of.area = area_of_node(tree, node);
  of.stability = stability_of_node(tree, known.changes, node);
  of.persistence = known.maxima.persistence_of_node(node);
  of.contrast = selection.contrasts[tree_index].of(node);
  of.fate = fates[tree_index][static_cast<std::size_t>(node)];
  const SelectedNode self{static_cast<std::int32_t>(tree_index), node};
  const auto found = std::find(selection.regions.begin(), selection.regions.end(), self);
  if (found != selection.regions.end()) of.region = static_cast<std::int32_t>(found - selection.regions.begin()) + 1;
  return of;
}

std::vector<ExplainedNode> explain_triangle(const LevelSetTrees& level_sets, const RegionSelection& selection,
                                            std::span<const NodeFates> fates, std::size_t tree_index,
                                            std::int32_t triangle) {
  const ComponentTree& tree = level_sets.trees[tree_index];
  std::vector<ExplainedNode> path;
  for (std::int32_t node = tree.node_of_triangle[static_cast<std::size_t>(triangle)]; node >= 0;
       node = tree.parent_of_node[static_cast<std::size_t>(node)])
    path.push_back(explain_node(level_sets, selection, fates, tree_index, node));
  return path;
}

std::vector<ExplainedNode> explain_rivals(const LevelSetTrees& level_sets, const RegionSelection& selection,
                                          std::span<const NodeFates> fates, std::size_t tree_index,
                                          std::span<const ExplainedNode> path) {
  std::vector<ExplainedNode> rivals;
  const auto told = [&](std::int32_t node) {
    const auto is_node = [&](const ExplainedNode& of) { return of.node == node; };
    return std::any_of(path.begin(), path.end(), is_node) || std::any_of(rivals.begin(), rivals.end(), is_node);
  };
  for (const ExplainedNode& of : path)
    for (std::int32_t rival = of.fate.rival; rival >= 0 && !told(rival); rival = rivals.back().fate.rival)
      rivals.push_back(explain_node(level_sets, selection, fates, tree_index, rival));
  return rivals;
}

ClosestTriangle closest_triangle(const SurfaceView& surface, const Eigen::Vector3d& point) {
  ClosestTriangle closest;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto corner = [&](std::size_t k) -> const Eigen::Vector3d& {
      return surface.positions[static_cast<std::size_t>(surface.triangles[t][k])];
    };
    const double distance = squared_distance(point, corner(0), corner(1), corner(2));
    if (distance < least) {
      least = distance;
      closest.triangle = static_cast<std::int32_t>(t);
    }
  }
  closest.distance = std::sqrt(least);
  return closest;
}

}  // namespace meshmser
