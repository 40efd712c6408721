#include "stages/mser/border_contrast.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <mutex>

#include "stages/common/gather_by_owner.hpp"
#include "stages/common/large_pages.hpp"
#include "stages/common/parallel.hpp"
#include "stages/mser/filters.hpp"
#include "stages/mser/node_attributes.hpp"

namespace meshmser {
namespace {

constexpr std::int64_t kTrianglesPerChunk = 1 << 16;
constexpr std::size_t kBandAhead = 16;  ///< triangles of a front whose neighbours are fetched ahead

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

/// All that a walk needs of a triangle, in half a line of the processor's cache. Places and values count from near the
/// mesh, so that 24 bits are plenty for means over bands.
struct alignas(32) BandTriangle {
  std::array<float, 3> centroid;
  std::array<std::int32_t, 3> neighbours;  ///< itself where there is none
  float area, value;
};

struct BandMesh {
  Eigen::Vector3d origin;
  std::vector<BandTriangle> triangles;
};

BandMesh make_band_mesh(const SurfaceView& surface, std::span<const double> triangle_values,
                        std::span<const double> areas, const Execution& execution) {
  BandMesh mesh;
  const std::size_t n = surface.triangles.size();
  const auto corner = [&](std::size_t t, std::size_t k) -> const Eigen::Vector3d& {
    return surface.positions[static_cast<std::size_t>(surface.triangles[t][k])];
  };
  mesh.origin = corner(0, 0);
  // Triangles that are cut out may have none.
  const auto finite =
      std::find_if(triangle_values.begin(), triangle_values.end(), [](double v) { return std::isfinite(v); });
  const double first_value = finite == triangle_values.end() ? 0 : *finite;
  reserve_on_large_pages(mesh.triangles, n);
  mesh.triangles.resize(n);
  parallel_chunks(static_cast<std::int64_t>(n), kTrianglesPerChunk, "", execution,
                  [&](std::int64_t begin, std::int64_t end) {
                    for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t) {
                      const Eigen::Vector3d centroid = (corner(t, 0) + corner(t, 1) + corner(t, 2)) / 3 - mesh.origin;
                      BandTriangle& of = mesh.triangles[t];
                      for (std::size_t k = 0; k < 3; ++k) {
                        of.centroid[k] = static_cast<float>(centroid[static_cast<Eigen::Index>(k)]);
                        const std::int32_t twin = surface.twins[3 * t + k];
                        of.neighbours[k] = twin < 0 ? static_cast<std::int32_t>(t) : twin / 3;
                      }
                      of.area = static_cast<float>(areas[t]);
                      of.value = static_cast<float>(triangle_values[t] - first_value);
                    }
                  });
  return mesh;
}

/// Walks outward from the level half-edges of one node after the other; a thread has one.
class BandWalk {
 public:
  BandWalk(const ComponentTree& tree, const BandMesh& mesh, double band)
      : tree_(tree), mesh_(mesh), band2_(static_cast<float>(band * band)) {
    reserve_on_large_pages(met_, tree.node_of_triangle.size());
    met_.assign(tree.node_of_triangle.size(), -1);
  }

  /// The contrast of a node; every node is asked for once.
  double contrast(std::int32_t top, std::span<const std::int32_t> level_edges) {
    num_reached_ = 0;
    middles_.clear();
    // Triangles at the border itself count whatever their size, so that neither side is empty.
    const BandTriangle* triangles = mesh_.triangles.data();
    for (std::size_t i = 0; i < level_edges.size(); ++i) {
      if (i + 2 * kBandAhead < level_edges.size()) prefetch(level_edges[i + 2 * kBandAhead] / 3);
      if (i + kBandAhead < level_edges.size()) prefetch(beyond(level_edges[i + kBandAhead]));
      const std::int32_t inside = level_edges[i] / 3, outside = beyond(level_edges[i]);
      const std::array<float, 3>&a = triangles[inside].centroid, &b = triangles[outside].centroid;
      middles_.push_back({(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2});
      make_room();
      for (const std::int32_t triangle : {inside, outside}) reach(triangle, static_cast<std::int32_t>(i), top, 1);
    }
    const std::int32_t first = tree_.first_node_of_subtree[static_cast<std::size_t>(top)];
    const std::int32_t* node_of = tree_.node_of_triangle.data();
    std::array<double, 2> sum{0, 0}, weight{0, 0};
    for (std::size_t f = 0; f < num_reached_; ++f) {
      make_room();
      if (f + kBandAhead < num_reached_) prefetch_around(front_[f + kBandAhead].triangle);
      const Reached reached = front_[f];
      const BandTriangle& here = triangles[reached.triangle];
      const std::int32_t node = node_of[reached.triangle];
      const double area = here.area, inside = static_cast<double>((node >= first) & (node <= top)) * area;
      sum[1] += inside * here.value;
      weight[1] += inside;
      sum[0] += (area - inside) * here.value;
      weight[0] += area - inside;
      const std::array<float, 3> from = middles_[static_cast<std::size_t>(reached.from)];
      for (const std::int32_t next : here.neighbours)
        reach(next, reached.from, top, static_cast<std::int32_t>(distance2(triangles[next].centroid, from) <= band2_));
    }
    return weight[0] > 0 && weight[1] > 0 ? sum[1] / weight[1] - sum[0] / weight[0] : 0;
  }

 private:
  struct Reached {
    std::int32_t triangle;
    std::int32_t from;  ///< level half-edge, its place in the list
  };

  static float distance2(const std::array<float, 3>& a, const std::array<float, 3>& b) {
    const float x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
    return x * x + y * y + z * z;
  }
  /// The triangle on the other side of a level half-edge.
  std::int32_t beyond(std::int32_t h) const {
    return mesh_.triangles[static_cast<std::size_t>(h / 3)].neighbours[static_cast<std::size_t>(h % 3)];
  }
  void prefetch(std::int32_t triangle) const {
    const auto t = static_cast<std::size_t>(triangle);
    __builtin_prefetch(&met_[t], 1);
    __builtin_prefetch(&mesh_.triangles[t]);
  }
  void prefetch_around(std::int32_t triangle) const {
    for (const std::int32_t next : mesh_.triangles[static_cast<std::size_t>(triangle)].neighbours) prefetch(next);
  }
  /// For the neighbours of one more triangle.
  void make_room() {
    if (front_.size() < num_reached_ + 3) front_.resize(2 * num_reached_ + 3);
  }
  /// A triangle joins the front where `near` is 1 and it was not met for this node. Whether it does is as good as
  /// random, so it is put at the end always and stays there or not.
  void reach(std::int32_t triangle, std::int32_t from, std::int32_t top, std::int32_t near) {
    std::int32_t& mark = met_[static_cast<std::size_t>(triangle)];
    const std::int32_t joins = near & static_cast<std::int32_t>(mark != top);
    front_[num_reached_] = {triangle, from};
    num_reached_ += static_cast<std::size_t>(joins);
    mark ^= (mark ^ top) & -joins;
  }

  const ComponentTree& tree_;
  const BandMesh& mesh_;
  float band2_;
  std::vector<std::int32_t> met_;  ///< the node a triangle was last met for
  std::vector<Reached> front_;     ///< the first `num_reached_` count
  std::size_t num_reached_ = 0;
  std::vector<std::array<float, 3>> middles_;  ///< of the level half-edges
};

}  // namespace

std::vector<double> border_contrasts(const SurfaceView& surface, const ComponentTree& tree,
                                     std::span<const std::int32_t> selected, std::span<const double> triangle_values,
                                     std::span<const double> areas, double band, const Execution& execution) {
  std::vector<double> contrasts(selected.size(), 0);
  if (selected.empty()) return contrasts;
  const HalfEdgesByOwner edges = level_edges_of(surface, tree, selected, execution);
  const auto edges_of = [&](std::size_t i) {
    const std::int64_t first = edges.first_of_owner[i];
    return std::span(edges.half_edges)
        .subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(edges.first_of_owner[i + 1] - first));
  };
  const BandMesh mesh = make_band_mesh(surface, triangle_values, areas, execution);
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
                    if (!walk) walk = std::make_unique<BandWalk>(tree, mesh, band);
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
