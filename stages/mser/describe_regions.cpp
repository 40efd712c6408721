#include "stages/mser/describe_regions.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "stages/common/parallel.hpp"
#include "stages/common/tree_nodes.hpp"
#include "stages/mser/fit_shapes.hpp"
#include "stages/mser/node_attributes.hpp"
#include "stages/mser/stability.hpp"

namespace meshmser {
namespace {

/// So many corners of a region's triangles are enough for its shape.
constexpr std::int64_t kFittedCorners = 192;

/// The triangles of listed nodes, descendants included, as intervals of one list.
class TrianglesOfNodes {
 public:
  TrianglesOfNodes(const ComponentTree& tree, std::span<const std::int32_t> nodes)
      : first_place_(nodes.size()), first_(nodes.size() + 1, 0) {
    const std::vector<std::int32_t> place = smallest_listed_nodes(tree, nodes);
    const auto place_of = [&](std::size_t t) {
      const std::int32_t node = tree.node_of_triangle[t];
      return node < 0 ? -1 : place[static_cast<std::size_t>(node)];
    };
    const std::size_t num_triangles = tree.node_of_triangle.size();
    for (std::size_t t = 0; t < num_triangles; ++t)
      if (place_of(t) >= 0) ++first_[static_cast<std::size_t>(place_of(t)) + 1];
    for (std::size_t i = 0; i < nodes.size(); ++i) first_[i + 1] += first_[i];
    triangles_.resize(static_cast<std::size_t>(first_.back()));
    std::vector<std::int64_t> next(first_.begin(), first_.end() - 1);
    for (std::size_t t = 0; t < num_triangles; ++t)
      if (place_of(t) >= 0)
        triangles_[static_cast<std::size_t>(next[static_cast<std::size_t>(place_of(t))]++)] =
            static_cast<std::int32_t>(t);
    // Nodes are in postorder: those of a subtree stand together, its root last.
    for (std::size_t i = 0; i < nodes.size(); ++i)
      first_place_[i] = static_cast<std::size_t>(
          std::lower_bound(nodes.begin(), nodes.end(), tree.first_node_of_subtree[static_cast<std::size_t>(nodes[i])]) -
          nodes.begin());
  }
  std::span<const std::int32_t> of(std::size_t place) const {
    return std::span(triangles_)
        .subspan(static_cast<std::size_t>(first_[first_place_[place]]),
                 static_cast<std::size_t>(first_[place + 1] - first_[first_place_[place]]));
  }

 private:
  std::vector<std::size_t> first_place_;
  std::vector<std::int64_t> first_;
  std::vector<std::int32_t> triangles_;
};

/// Fits corners of triangles: all of few, else one of each of kFittedCorners triangles evenly taken, weighing as much
/// as these.
FittedShapes fit_triangles(const SurfaceView& surface, std::span<const std::int32_t> triangles,
                           std::span<const double> areas) {
  struct Corner {
    std::int32_t vertex, triangle;
  };
  std::vector<Corner> corners;
  const auto all = static_cast<std::int64_t>(triangles.size());
  const std::int64_t taken = std::min(all, kFittedCorners);
  for (std::int64_t i = 0; i < taken; ++i) {
    const std::int32_t t = triangles[static_cast<std::size_t>(i * all / taken)];
    if (!(areas[static_cast<std::size_t>(t)] > 0)) continue;
    const auto& of_triangle = surface.triangles[static_cast<std::size_t>(t)];
    if (3 * all > kFittedCorners)
      corners.push_back({of_triangle[static_cast<std::size_t>(i % 3)], t});
    else
      for (const std::int32_t vertex : of_triangle) corners.push_back({vertex, t});
  }
  std::sort(corners.begin(), corners.end(), [](const Corner& a, const Corner& b) {
    return a.vertex != b.vertex ? a.vertex < b.vertex : a.triangle < b.triangle;
  });
  std::vector<Eigen::Vector3d> points, normals;
  std::vector<double> weights;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (i == 0 || corners[i].vertex != corners[i - 1].vertex) {
      points.push_back(surface.positions[static_cast<std::size_t>(corners[i].vertex)]);
      normals.push_back(Eigen::Vector3d::Zero());
      weights.push_back(0);
    }
    const auto t = static_cast<std::size_t>(corners[i].triangle);
    const auto corner = [&](std::size_t k) -> const Eigen::Vector3d& {
      return surface.positions[static_cast<std::size_t>(surface.triangles[t][k])];
    };
    weights.back() += areas[t];
    normals.back() += (corner(1) - corner(0)).cross(corner(2) - corner(0));
  }
  return fit_shapes(points, weights, normals);
}

void take(const NodeAttributes& of, Region& region) {
  region.num_triangles = of.num_triangles;
  region.area = of.area;
  region.scalar_min = of.scalar_min;
  region.scalar_max = of.scalar_max;
  region.scalar_mean = of.scalar_mean;
  region.scalar_deviation = of.scalar_deviation;
  region.centroid = of.centroid;
  region.mean_normal = of.mean_normal();
  region.level_length = of.level_length;
  region.hole_length = of.hole_length;
  region.depth = of.depth;
  region.euler = of.euler;
  region.flatness = of.flatness();
  region.box_min = of.box_min;
  region.box_max = of.box_max;
  const PrincipalAxes axes = principal_axes(of.covariance);
  region.axis_1 = axes.axes.col(0);
  region.axis_2 = axes.axes.col(1);
  region.axis_3 = axes.axes.col(2);
  region.spread = axes.deviations;
}

void take(const FittedShapes& of, Region& region) {
  region.best_fit = of.best;
  region.plane_residual = of.plane_residual;
  region.sphere_residual = of.sphere_residual;
  region.sphere_radius = of.sphere_radius;
  region.sphere_centre = of.sphere_centre;
  region.cylinder_residual = of.cylinder_residual;
  region.cylinder_radius = of.cylinder_radius;
  region.cylinder_point = of.cylinder_point;
  region.cylinder_axis = of.cylinder_axis;
}

}  // namespace

std::vector<Region> describe_regions(const SurfaceView& surface, std::span<const ComponentTree> trees,
                                     std::span<const TreeSelection> selections, std::span<const SelectedNode> regions,
                                     std::span<const double> values, std::span<const double> areas,
                                     const Execution& execution) {
  std::vector<Region> described(regions.size());
  const std::vector<std::int32_t> parents = parent_regions(trees, regions);
  for (std::size_t i = 0; i < trees.size(); ++i) {
    const ComponentTree& tree = trees[i];
    std::vector<std::int32_t> nodes;
    for (const SelectedNode& region : regions)
      if (region.tree == static_cast<std::int32_t>(i)) nodes.push_back(region.node);
    if (nodes.empty()) continue;
    std::sort(nodes.begin(), nodes.end());
    execution.check();
    const std::vector<NodeAttributes> attributes = attributes_of_nodes(surface, tree, nodes, values, areas);
    const TrianglesOfNodes triangles(tree, nodes);
    const auto describe = [&](std::size_t r) {
      const std::int32_t node = regions[r].node;
      const auto at = static_cast<std::size_t>(std::lower_bound(nodes.begin(), nodes.end(), node) - nodes.begin());
      Region& region = described[r];
      region.polarity = tree.side(node);
      region.node = node;
      region.parent = parents[r];
      region.low_level = tree.lo(node);
      region.high_level = tree.hi_of_node[static_cast<std::size_t>(node)];
      region.value = tree.value(node);
      region.stability = stability_of_node(tree, selections[i].changes, node);
      region.persistence = selections[i].maxima.persistence_of_node(node);
      take(attributes[at], region);
      take(fit_triangles(surface, triangles.of(at), areas), region);
    };
    parallel_chunks(static_cast<std::int64_t>(regions.size()), 16, "", execution,
                    [&](std::int64_t begin, std::int64_t end) {
                      for (auto r = static_cast<std::size_t>(begin); r < static_cast<std::size_t>(end); ++r)
                        if (regions[r].tree == static_cast<std::int32_t>(i)) describe(r);
                    });
  }
  return described;
}

}  // namespace meshmser
