#include "stages/mser/describe_regions.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <utility>

#include "stages/common/gather_by_owner.hpp"
#include "stages/common/large_pages.hpp"
#include "stages/common/parallel.hpp"
#include "stages/mser/filters.hpp"
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

/// Fits corners of triangles: all of few, else one of each of kFittedCorners triangles evenly taken, weighing as much as
/// these.
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
    const std::vector<double> levels = finite_levels(tree.levels);
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
      region.polarity = tree.polarity;
      region.node = node;
      region.parent = parents[r];
      region.low_level = tree.lo(node);
      region.high_level = tree.hi_of_node[static_cast<std::size_t>(node)];
      const double low = levels[static_cast<std::size_t>(region.low_level) - 1];
      region.value = tree.polarity == Polarity::kUpper ? low : -low;
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

namespace {

/// The level half-edges of every selected node, by node, then ascending. Of two neighbouring triangles one's node is an
/// ancestor of the other's, so climbing ends at the first selected node that holds both.
HalfEdgesByOwner level_edges_of(const SurfaceView& surface, const ComponentTree& tree,
                                std::span<const std::int32_t> selected, const Execution& execution) {
  const std::vector<std::int32_t> place = smallest_listed_nodes(tree, selected);
  const std::vector<std::int32_t> ancestor = nearest_selected_ancestors(tree, selected);
  return gather_by_owner(
      surface.triangles.size(), selected.size(),
      [&](std::size_t begin, std::size_t end, std::vector<OwnedHalfEdge>& list) {
        const std::int32_t *twins = surface.twins.data(), *node_of = tree.node_of_triangle.data();
        for (std::size_t t = begin; t < end; ++t) {
          const std::int32_t here = node_of[t];
          const std::int32_t smallest = here < 0 ? -1 : place[static_cast<std::size_t>(here)];
          if (smallest < 0) continue;
          for (std::size_t h = 3 * t; h < 3 * t + 3; ++h) {
            if (twins[h] < 0) continue;
            const std::int32_t there = node_of[twins[h] / 3];
            if (there == here) continue;
            for (std::int32_t at = smallest; at >= 0; at = ancestor[static_cast<std::size_t>(at)]) {
              const std::int32_t top = selected[static_cast<std::size_t>(at)];
              if (there >= tree.first_node_of_subtree[static_cast<std::size_t>(top)] && there <= top) break;
              list.push_back({at, static_cast<std::int32_t>(h)});
            }
          }
        }
      },
      execution);
}

/// Walks outward from the level half-edges of one node after the other; a thread has one.
class BandWalk {
 public:
  BandWalk(const SurfaceView& surface, const ComponentTree& tree, std::span<const double> triangle_values,
           std::span<const double> areas, double band)
      : surface_(surface),
        tree_(tree),
        values_(triangle_values),
        areas_(areas),
        band_(band) {
    reserve_on_large_pages(met_, tree.node_of_triangle.size());
    met_.assign(tree.node_of_triangle.size(), -1);
  }

  /// The contrast of a node; every node is asked for once.
  double contrast(std::int32_t top, std::span<const std::int32_t> level_edges) {
    const std::int32_t first = tree_.first_node_of_subtree[static_cast<std::size_t>(top)];
    front_.clear();
    middles_.clear();
    // Triangles at the border itself count whatever their size, so that neither side is empty.
    for (const std::int32_t h : level_edges) {
      const auto from = static_cast<std::int32_t>(middles_.size());
      middles_.push_back((corner(h / 3, h % 3) + corner(h / 3, (h + 1) % 3)) / 2);
      reach({h / 3, from}, top);
      reach({surface_.twins[static_cast<std::size_t>(h)] / 3, from}, top);
    }
    double sum[2] = {0, 0}, weight[2] = {0, 0};
    for (std::size_t f = 0; f < front_.size(); ++f) {
      const Reached reached = front_[f];
      const auto t = static_cast<std::size_t>(reached.triangle);
      const std::int32_t node = tree_.node_of_triangle[t];
      const bool inside = node >= first && node <= top;
      sum[inside ? 1 : 0] += areas_[t] * values_[t];
      weight[inside ? 1 : 0] += areas_[t];
      for (std::size_t k = 0; k < 3; ++k) {
        const std::int32_t twin = surface_.twins[3 * t + k];
        if (twin < 0) continue;
        const Reached next{twin / 3, reached.from};
        if (met_[static_cast<std::size_t>(next.triangle)] != top && near(next)) reach(next, top);
      }
    }
    return weight[0] > 0 && weight[1] > 0 ? sum[1] / weight[1] - sum[0] / weight[0] : 0;
  }

 private:
  struct Reached {
    std::int32_t triangle;
    std::int32_t from;  ///< level half-edge, its place in the list
  };

  const Eigen::Vector3d& corner(std::int32_t t, std::int32_t k) const {
    return surface_.positions[static_cast<std::size_t>(
        surface_.triangles[static_cast<std::size_t>(t)][static_cast<std::size_t>(k)])];
  }
  bool near(const Reached& reached) const {
    const Eigen::Vector3d centroid =
        (corner(reached.triangle, 0) + corner(reached.triangle, 1) + corner(reached.triangle, 2)) / 3;
    return (centroid - middles_[static_cast<std::size_t>(reached.from)]).squaredNorm() <= band_ * band_;
  }
  void reach(const Reached& reached, std::int32_t mark) {
    const auto t = static_cast<std::size_t>(reached.triangle);
    if (met_[t] == mark) return;
    met_[t] = mark;
    front_.push_back(reached);
    __builtin_prefetch(&surface_.twins[3 * t]);
    __builtin_prefetch(&tree_.node_of_triangle[t]);
    __builtin_prefetch(&areas_[t]);
    __builtin_prefetch(&values_[t]);
  }

  const SurfaceView& surface_;
  const ComponentTree& tree_;
  std::span<const double> values_, areas_;
  double band_;
  std::vector<std::int32_t> met_;  ///< the node a triangle was last met for
  std::vector<Reached> front_;
  std::vector<Eigen::Vector3d> middles_;  ///< of the level half-edges
};

}  // namespace

std::vector<double> border_contrasts(const SurfaceView& surface, const ComponentTree& tree,
                                     std::span<const std::int32_t> selected, std::span<const double> triangle_values,
                                     std::span<const double> areas, double band, const Execution& execution) {
  const HalfEdgesByOwner edges = level_edges_of(surface, tree, selected, execution);
  const auto edges_of = [&](std::size_t i) {
    const std::int64_t first = edges.first_of_owner[i];
    return std::span(edges.half_edges)
        .subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(edges.first_of_owner[i + 1] - first));
  };
  std::vector<double> contrasts(selected.size(), 0);
  // As many walks as threads work at a time, since each holds a number a triangle.
  std::mutex mutex;
  std::vector<std::unique_ptr<BandWalk>> idle;
  parallel_chunks(static_cast<std::int64_t>(selected.size()), 64, "", execution,
                  [&](std::int64_t begin, std::int64_t end) {
                    std::unique_ptr<BandWalk> walk;
                    {
                      const std::lock_guard lock(mutex);
                      if (!idle.empty()) {
                        walk = std::move(idle.back());
                        idle.pop_back();
                      }
                    }
                    if (!walk) walk = std::make_unique<BandWalk>(surface, tree, triangle_values, areas, band);
                    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i)
                      contrasts[i] = walk->contrast(selected[i], edges_of(i));
                    const std::lock_guard lock(mutex);
                    idle.push_back(std::move(walk));
                  });
  return contrasts;
}

double noise_of_values(const SurfaceView& surface, std::span<const double> triangle_values) {
  std::vector<double> deviations;
  const std::size_t stride = triangle_values.size() / 65536 + 1;
  for (std::size_t t = 0; t < triangle_values.size(); t += stride) {
    double around = 0;
    bool inner = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t twin = surface.twins[3 * t + k];
      inner = inner && twin >= 0;
      if (inner) around += triangle_values[static_cast<std::size_t>(twin / 3)] / 3;
    }
    if (inner) deviations.push_back(std::abs(triangle_values[t] - around));
  }
  if (deviations.size() < 16) return 0;
  const auto middle = deviations.begin() + static_cast<std::ptrdiff_t>(deviations.size() / 2);
  std::nth_element(deviations.begin(), middle, deviations.end());
  return 1.4826 * std::sqrt(0.75) * *middle;
}

}  // namespace meshmser
