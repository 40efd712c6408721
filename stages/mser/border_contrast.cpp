#include "stages/mser/border_contrast.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <mutex>

#include "stages/common/adjacency.hpp"
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
/// ancestor of the other's, so what parts them are the selected nodes from one's smallest up to the other's.
HalfEdgesByOwner level_edges_of(const SurfaceView& surface, std::span<const std::int32_t> smallest,
                                std::span<const std::int32_t> ancestor, const Execution& execution) {
  return gather_by_owner(
      surface.triangles.size(), ancestor.size(),
      [&](std::size_t begin, std::size_t end, std::vector<OwnedHalfEdge>& list) {
        const std::int32_t *twins = surface.twins.data(), *smallest_of = smallest.data();
        for (std::size_t t = begin; t < end; ++t) {
          const std::int32_t here = smallest_of[t];
          if (here < 0) continue;
          for (std::size_t h = 3 * t; h < 3 * t + 3; ++h) {
            const std::int32_t there = twins[h] < 0 ? here : smallest_of[static_cast<std::uint32_t>(twins[h]) / 3];
            // Selected nodes ascend, and children come before their parents.
            for (std::int32_t at = here; at >= 0 && (there < 0 || at < there);
                 at = ancestor[static_cast<std::size_t>(at)])
              list.push_back({at, static_cast<std::int32_t>(h)});
          }
        }
      },
      execution);
}

/// Of every triangle, the place in `selected` of the smallest node that holds it; -1: none.
std::vector<std::int32_t> smallest_listed_of_triangles(const ComponentTree& tree,
                                                       std::span<const std::int32_t> selected,
                                                       const Execution& execution) {
  const std::vector<std::int32_t> place = smallest_listed_nodes(tree, selected);
  std::vector<std::int32_t> smallest;
  reserve_on_large_pages(smallest, tree.node_of_triangle.size());
  smallest.resize(tree.node_of_triangle.size());
  parallel_chunks(static_cast<std::int64_t>(smallest.size()), kTrianglesPerChunk, "", execution,
                  [&](std::int64_t begin, std::int64_t end) {
                    for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t) {
                      const std::int32_t node = tree.node_of_triangle[t];
                      smallest[t] = node < 0 ? -1 : place[static_cast<std::size_t>(node)];
                    }
                  });
  return smallest;
}

/// Side k of triangle t is 4 t + k, which parts faster than half-edges 3 t + k do.
std::uint32_t side_of_half_edge(std::int32_t h) {
  const auto half_edge = static_cast<std::uint32_t>(h);
  return half_edge + half_edge / 3;
}

/// All that a walk needs of a triangle, in half a line of the processor's cache. Places and values count from near the
/// mesh, so that 24 bits are plenty for means over bands.
struct alignas(32) BandTriangle {
  std::array<float, 3> centroid;
  std::array<std::uint32_t, 3> sides_behind;  ///< of the neighbours; its own side where there is none
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
                        of.sides_behind[k] = side_of_half_edge(twin < 0 ? static_cast<std::int32_t>(3 * t + k) : twin);
                      }
                      of.area = static_cast<float>(areas[t]);
                      of.value = static_cast<float>(triangle_values[t] - first_value);
                    }
                  });
  return mesh;
}

/// Walks outward from the level half-edges of one selected node after the other; a thread has one.
class BandWalk {
 public:
  /// `smallest`: of every triangle, the place of the smallest selected node that holds it.
  BandWalk(std::span<const std::int32_t> smallest, const BandMesh& mesh, double band)
      : mesh_(mesh), band2_(static_cast<float>(band * band)) {
    reserve_on_large_pages(places_, smallest.size());
    for (const std::int32_t place : smallest) places_.push_back({place, -1});
  }

  /// The contrast of the selected node at a place, which holds those from `first` on; every one is asked for once.
  double contrast(std::int32_t first, std::int32_t place, std::span<const std::int32_t> level_edges) {
    const BandTriangle* const triangles = mesh_.triangles.data();
    Places* const places = places_.data();
    std::size_t num_reached = 0;
    // Whether a triangle joins the front is as good as random, so it is put at the end always and stays there or not.
    const auto reach = [&](Reached reached, std::int32_t near) {
      std::int32_t& mark = places[reached.side / 4].met_for;
      const std::int32_t joins = near & static_cast<std::int32_t>(mark != place);
      front_[num_reached] = reached;
      num_reached += static_cast<std::size_t>(joins);
      mark ^= (mark ^ place) & -joins;
    };
    const auto make_room = [&] {
      if (front_.size() < num_reached + 2) front_.resize(2 * num_reached + 2);
    };
    const auto behind = [&](std::uint32_t side) { return triangles[side / 4].sides_behind[side % 4]; };
    const auto prefetch = [&](std::uint32_t side) {
      __builtin_prefetch(&places[side / 4], 1);
      __builtin_prefetch(&triangles[side / 4]);
    };
    // Triangles at the border itself count whatever their size, so that neither side is empty.
    middles_.resize(level_edges.size());
    for (std::size_t i = 0; i < level_edges.size(); ++i) {
      if (i + 2 * kBandAhead < level_edges.size()) prefetch(side_of_half_edge(level_edges[i + 2 * kBandAhead]));
      if (i + kBandAhead < level_edges.size()) prefetch(behind(side_of_half_edge(level_edges[i + kBandAhead])));
      const std::uint32_t inside = side_of_half_edge(level_edges[i]), outside = behind(inside);
      const std::array<float, 3>&a = triangles[inside / 4].centroid, &b = triangles[outside / 4].centroid;
      middles_[i] = {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2};
      make_room();
      reach({inside, static_cast<std::uint32_t>(i)}, 1);
      reach({outside, static_cast<std::uint32_t>(i)}, 1);
    }
    std::array<double, 2> sum{0, 0}, weight{0, 0};
    for (std::size_t f = 0; f < num_reached; ++f) {
      make_room();
      if (f + kBandAhead < num_reached) {
        for (const std::uint32_t other : others(front_[f + kBandAhead].side)) prefetch(behind(other));
      }
      const Reached reached = front_[f];
      const BandTriangle& here = triangles[reached.side / 4];
      const std::int32_t smallest = places[reached.side / 4].smallest;
      const double area = here.area, inside = static_cast<double>((smallest >= first) & (smallest <= place)) * area;
      sum[1] += inside * here.value;
      weight[1] += inside;
      sum[0] += (area - inside) * here.value;
      weight[0] += area - inside;
      const std::array<float, 3> from = middles_[reached.from];
      for (const std::uint32_t other : others(reached.side)) {
        const std::uint32_t next = behind(other);
        reach({next, reached.from}, static_cast<std::int32_t>(distance2(triangles[next / 4].centroid, from) <= band2_));
      }
    }
    return weight[0] > 0 && weight[1] > 0 ? sum[1] / weight[1] - sum[0] / weight[0] : 0;
  }

 private:
  /// Places of selected nodes.
  struct Places {
    std::int32_t smallest;  ///< that holds the triangle
    std::int32_t met_for;   ///< for which the triangle was last met
  };
  struct Reached {
    std::uint32_t side;  ///< of the triangle, behind which the triangle was met before
    std::uint32_t from;  ///< level half-edge, its place in the list
  };

  static float distance2(const std::array<float, 3>& a, const std::array<float, 3>& b) {
    const float x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
    return x * x + y * y + z * z;
  }
  /// The other sides of a side's triangle, ascending: of sides 0, 1, 2 they stand in two bits each, from the right.
  static std::array<std::uint32_t, 2> others(std::uint32_t side) {
    const std::uint32_t first = side & ~3U, k = side & 3U;
    return {first + (0b000001U >> (2 * k) & 3U), first + (0b011010U >> (2 * k) & 3U)};
  }

  const BandMesh& mesh_;
  float band2_;
  std::vector<Places> places_;                 ///< of triangles
  std::vector<Reached> front_;                 ///< room
  std::vector<std::array<float, 3>> middles_;  ///< of the level half-edges
};

}  // namespace

std::vector<double> border_contrasts(const SurfaceView& surface, const ComponentTree& tree,
                                     std::span<const std::int32_t> selected, std::span<const double> triangle_values,
                                     std::span<const double> areas, double band, const Execution& execution) {
  std::vector<double> contrasts(selected.size(), 0);
  if (selected.empty()) return contrasts;
  const std::vector<std::int32_t> smallest = smallest_listed_of_triangles(tree, selected, execution);
  const HalfEdgesByOwner edges =
      level_edges_of(surface, smallest, nearest_selected_ancestors(tree, selected), execution);
  const auto edges_of = [&](std::size_t i) {
    const std::int64_t first = edges.first_of_owner[i];
    return std::span(edges.half_edges)
        .subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(edges.first_of_owner[i + 1] - first));
  };
  const BandMesh mesh = make_band_mesh(surface, triangle_values, areas, execution);
  // As many walks as threads work at a time, since each holds a number a triangle.
  std::mutex mutex;
  std::vector<std::unique_ptr<BandWalk>> idle;
  parallel_chunks(static_cast<std::int64_t>(selected.size()), 8, "", execution,
                  [&](std::int64_t begin, std::int64_t end) {
                    std::unique_ptr<BandWalk> walk;
                    {
                      const std::lock_guard lock(mutex);
                      if (!idle.empty()) {
                        walk = std::move(idle.back());
                        idle.pop_back();
                      }
                    }
                    if (!walk) walk = std::make_unique<BandWalk>(smallest, mesh, band);
                    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
                      const std::int32_t first_node = tree.first_node_of_subtree[static_cast<std::size_t>(selected[i])];
                      const auto first = std::lower_bound(selected.begin(), selected.end(), first_node);
                      contrasts[i] = walk->contrast(static_cast<std::int32_t>(first - selected.begin()),
                                                    static_cast<std::int32_t>(i), edges_of(i));
                    }
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
