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
#include "stages/mser/stability.hpp"

namespace meshmser {
namespace {

/// Sums over triangles.
struct Sums {
  std::int64_t num_triangles = 0;
  double area = 0, first = 0, second = 0;  ///< integrals of 1, S, S^2
  double least = std::numeric_limits<double>::infinity(), greatest = -std::numeric_limits<double>::infinity();
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::Zero();

  void add(const Sums& other) {
    num_triangles += other.num_triangles;
    area += other.area;
    first += other.first;
    second += other.second;
    least = std::min(least, other.least);
    greatest = std::max(greatest, other.greatest);
    centroid += other.centroid;
    normal += other.normal;
  }
};

/// The place in `selected` of the smallest selected node at or above each node; -1: none.
std::vector<std::int32_t> selected_of_nodes(const ComponentTree& tree, std::span<const std::int32_t> selected) {
  std::vector<std::int32_t> place(tree.num_nodes(), -1);
  for (std::size_t i = 0; i < selected.size(); ++i)
    place[static_cast<std::size_t>(selected[i])] = static_cast<std::int32_t>(i);
  for (std::size_t n = tree.num_nodes(); n-- > 0;)
    if (place[n] < 0 && tree.parent_of_node[n] >= 0) place[n] = place[static_cast<std::size_t>(tree.parent_of_node[n])];
  return place;
}

Sums sums_of_triangle(const SurfaceView& surface, std::span<const double> values, double area, std::size_t t) {
  Sums sums;
  Eigen::Vector3d corners[3];
  double s[3];
  for (std::size_t k = 0; k < 3; ++k) {
    const auto v = static_cast<std::size_t>(surface.triangles[t][k]);
    corners[k] = surface.positions[v];
    s[k] = values[v];
  }
  const double total = s[0] + s[1] + s[2];
  sums.num_triangles = 1;
  sums.area = area;
  sums.first = area * total / 3;
  // The integral of the square of a linear function over a triangle.
  sums.second = area * (total * total + s[0] * s[0] + s[1] * s[1] + s[2] * s[2]) / 12;
  sums.least = std::min({s[0], s[1], s[2]});
  sums.greatest = std::max({s[0], s[1], s[2]});
  sums.centroid = area / 3 * (corners[0] + corners[1] + corners[2]);
  sums.normal = 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  return sums;
}

/// The sums over each selected node of a tree, descendants included, by place in `selected`.
std::vector<Sums> sums_of_selected(const SurfaceView& surface, const ComponentTree& tree,
                                   std::span<const std::int32_t> selected, std::span<const double> values,
                                   std::span<const double> areas) {
  std::vector<Sums> sums(selected.size());
  const std::vector<std::int32_t> place = selected_of_nodes(tree, selected);
  for (std::size_t t = 0; t < tree.node_of_triangle.size(); ++t) {
    if (tree.node_of_triangle[t] < 0) continue;
    const std::int32_t at = place[static_cast<std::size_t>(tree.node_of_triangle[t])];
    if (at >= 0) sums[static_cast<std::size_t>(at)].add(sums_of_triangle(surface, values, areas[t], t));
  }
  const std::vector<std::int32_t> ancestor = nearest_selected_ancestors(tree, selected);
  for (std::size_t i = 0; i < selected.size(); ++i)
    if (ancestor[i] >= 0) sums[static_cast<std::size_t>(ancestor[i])].add(sums[i]);
  return sums;
}

}  // namespace

std::vector<Region> describe_regions(const SurfaceView& surface, std::span<const ComponentTree> trees,
                                     std::span<const TreeSelection> selections, std::span<const SelectedNode> regions,
                                     std::span<const double> values, std::span<const double> areas) {
  std::vector<Region> described(regions.size());
  const std::vector<std::int32_t> parents = parent_regions(trees, regions);
  for (std::size_t i = 0; i < trees.size(); ++i) {
    const ComponentTree& tree = trees[i];
    const std::vector<double> levels = finite_levels(tree.levels);
    std::vector<std::int32_t> selected;
    for (const SelectedNode& region : regions)
      if (region.tree == static_cast<std::int32_t>(i)) selected.push_back(region.node);
    std::sort(selected.begin(), selected.end());
    const std::vector<Sums> all_sums = sums_of_selected(surface, tree, selected, values, areas);
    for (std::size_t r = 0; r < regions.size(); ++r) {
      if (regions[r].tree != static_cast<std::int32_t>(i)) continue;
      const std::int32_t node = regions[r].node;
      const Sums& sums = all_sums[static_cast<std::size_t>(std::lower_bound(selected.begin(), selected.end(), node) -
                                                           selected.begin())];
      Region& region = described[r];
      region.polarity = tree.polarity;
      region.node = node;
      region.parent = parents[r];
      region.low_level = tree.lo(node);
      region.high_level = tree.hi_of_node[static_cast<std::size_t>(node)];
      const double low = levels[static_cast<std::size_t>(region.low_level) - 1];
      region.value = tree.polarity == Polarity::kUpper ? low : -low;
      region.num_triangles = sums.num_triangles;
      region.area = area_of_node(tree, node);
      region.stability = stability_of_node(tree, selections[i].changes, node);
      region.persistence = selections[i].maxima.persistence_of_node(node);
      region.scalar_min = sums.least;
      region.scalar_max = sums.greatest;
      if (sums.area > 0) {
        region.scalar_mean = sums.first / sums.area;
        region.scalar_deviation =
            std::sqrt(std::max(0.0, sums.second / sums.area - region.scalar_mean * region.scalar_mean));
        region.centroid = sums.centroid / sums.area;
      }
      if (sums.normal.norm() > 0) region.mean_normal = sums.normal.normalized();
    }
  }
  return described;
}

namespace {

/// The level half-edges of every selected node, by node, then ascending. Of two neighbouring triangles one's node is an
/// ancestor of the other's, so climbing ends at the first selected node that holds both.
HalfEdgesByOwner level_edges_of(const SurfaceView& surface, const ComponentTree& tree,
                                std::span<const std::int32_t> selected, const Execution& execution) {
  const std::vector<std::int32_t> place = selected_of_nodes(tree, selected);
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
