#include "stages/mser/border_contrast.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <mutex>

#include "stages/common/gather_by_owner.hpp"
#include "stages/common/large_pages.hpp"
#include "stages/common/owned_edges.hpp"
#include "stages/common/parallel.hpp"

namespace meshmser {
namespace {

constexpr std::size_t kBandAhead = 16;  ///< triangles of a front whose neighbours are fetched ahead

/// All that a walk needs of a triangle, in half a line of the processor's cache. Places and values count from near the
/// mesh, so that 24 bits are plenty for means over bands.
struct alignas(32) BandTriangle {
  std::array<float, 3> centroid;
  std::array<std::uint32_t, 3> neighbours;  ///< itself where there is none
  std::array<float, 2> sums;                ///< area x value, area
};

struct BandMesh {
  std::unique_ptr<BandTriangle[]> triangles;
  std::size_t num_triangles = 0;
  HalfEdgesByOwner level_edges;  ///< of the selected nodes, ascending
};

BandMesh make_band_mesh(const SurfaceView& surface, const ComponentTree& tree, std::span<const std::int32_t> selected,
                        std::span<const double> triangle_values, std::span<const double> areas,
                        const Execution& execution) {
  const NodePlaces places = places_of_nodes(tree, selected, execution);
  BandMesh mesh;
  const auto corner = [&](std::size_t t, std::size_t k) -> const Eigen::Vector3d& {
    return surface.positions[static_cast<std::size_t>(surface.triangles[t][k])];
  };
  const Eigen::Vector3d origin = corner(0, 0);
  // Triangles that are cut out may have none.
  const auto finite =
      std::find_if(triangle_values.begin(), triangle_values.end(), [](double v) { return std::isfinite(v); });
  const double first_value = finite == triangle_values.end() ? 0 : *finite;
  mesh.num_triangles = surface.triangles.size();
  mesh.triangles = make_on_large_pages<BandTriangle>(mesh.num_triangles);
  BandTriangle* const triangles = mesh.triangles.get();
  mesh.level_edges = gather_by_owner(
      mesh.num_triangles, selected.size(),
      [&](std::size_t begin, std::size_t end, std::vector<OwnedHalfEdge>& list) {
        const std::int32_t* twins = surface.twins.data();
        const std::uint32_t* place_of = places.of_triangle.get();
        OwnedEdges found(list, places);
        for (std::size_t t = begin; t < end; ++t) {
          BandTriangle& of = triangles[t];
          const Eigen::Vector3d centroid = (corner(t, 0) + corner(t, 1) + corner(t, 2)) / 3 - origin;
          std::array<std::uint32_t, 3> there{};
          for (std::size_t k = 0; k < 3; ++k) {
            of.centroid[k] = static_cast<float>(centroid[static_cast<Eigen::Index>(k)]);
            const std::int32_t twin = twins[3 * t + k];
            of.neighbours[k] = static_cast<std::uint32_t>(twin < 0 ? t : static_cast<std::uint32_t>(twin) / 3);
            there[k] = place_of[of.neighbours[k]];
          }
          of.sums = {static_cast<float>(areas[t] * (triangle_values[t] - first_value)), static_cast<float>(areas[t])};
          found.put(t, place_of[t], there, [](std::uint32_t place) { return static_cast<std::int32_t>(place); });
        }
        found.finish();
      },
      execution);
  return mesh;
}

/// Walks outward from the level half-edges of one selected node after the other; a thread has one.
class BandWalk {
 public:
  BandWalk(const BandMesh& mesh, double band)
      : triangles_(mesh.triangles.get()), band2_(static_cast<float>(band * band)) {
    reserve_on_large_pages(met_in_, mesh.num_triangles);
    met_in_.resize(mesh.num_triangles, 0);
  }

  /// The contrast of a region from its level half-edges, ascending.
  double contrast(std::span<const std::int32_t> level_edges) {
    if (++round_ == 0) {
      std::fill(met_in_.begin(), met_in_.end(), std::uint8_t{0});
      round_ = 1;
    }
    const std::size_t n = level_edges.size();
    const auto inside_of = [&](std::size_t i) { return static_cast<std::uint32_t>(level_edges[i]) / 3; };
    const auto outside_of = [&](std::size_t i) {
      return triangles_[inside_of(i)].neighbours[static_cast<std::uint32_t>(level_edges[i]) % 3];
    };
    middles_.resize(n);
    for (std::vector<Reached>& front : fronts_) front.resize(std::max(front.size(), n + 1));
    Reached *outer = fronts_[0].data(), *inner = fronts_[1].data();
    for (std::size_t i = 0; i < n; ++i) {
      if (i + 2 * kBandAhead < n) __builtin_prefetch(&triangles_[inside_of(i + 2 * kBandAhead)]);
      if (i + kBandAhead < n) __builtin_prefetch(&triangles_[outside_of(i + kBandAhead)]);
      const std::uint32_t inside = inside_of(i), outside = outside_of(i);
      const std::array<float, 3>&a = triangles_[inside].centroid, &b = triangles_[outside].centroid;
      middles_[i] = {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2, 0};
      outer = reach(outside, i << 32, outer, met_in_.data(), round_);
      inner = reach(inside, i << 32, inner, met_in_.data(), round_);
    }
    // Both sides of the border have been met by now, so that neither front gets across.
    const Sums outside = walk(fronts_[0], static_cast<std::size_t>(outer - fronts_[0].data()));
    const Sums inside = walk(fronts_[1], static_cast<std::size_t>(inner - fronts_[1].data()));
    return outside[1] > 0 && inside[1] > 0 ? inside[0] / inside[1] - outside[0] / outside[1] : 0;
  }

 private:
  /// A triangle and, from bit 32 on, the place in the list of the level half-edge from which it was reached.
  using Reached = std::uint64_t;
  using Sums = std::array<double, 2>;  ///< area x value, area

  /// Puts a triangle at the end of a front, if it was not met in this round, and returns the end. Whether it was is as
  /// good as random, so it is written always and stays there or not.
  static Reached* reach(std::uint32_t triangle, Reached from, Reached* end, std::uint8_t* met_in, std::uint8_t round) {
    *end = from | triangle;
    end += static_cast<std::size_t>(met_in[triangle] != round);
    met_in[triangle] = round;
    return end;
  }

  /// Sums up the triangles at the border, which a front begins with, and what they reach within the band.
  Sums walk(std::vector<Reached>& front, std::size_t at_border) {
    // By value, since a byte that is written may be part of anything to the compiler.
    const BandTriangle* const triangles = triangles_;
    const std::array<float, 4>* const middles = middles_.data();
    const float band2 = band2_;
    const std::uint8_t round = round_;
    std::uint8_t* const met_in = met_in_.data();
    Sums sums{0, 0};
    std::size_t num_reached = at_border;
    for (std::size_t f = 0; f < num_reached;) {
      // Room for all that is reached from those that wait by now, and to look ahead.
      const std::size_t waiting = num_reached, room = waiting + 3 * (waiting - f) + kBandAhead + 1;
      if (front.size() < room) front.resize(2 * room);
      const Reached* const reached = front.data();
      Reached* end = front.data() + waiting;
      double weighted = 0, weight = 0;
      for (; f < waiting; ++f) {
        // Beyond the end lies what was there once, or 0.
        __builtin_prefetch(&triangles[static_cast<std::uint32_t>(reached[f + kBandAhead])]);
        const Reached from = reached[f] >> 32;
        const BandTriangle& here = triangles[static_cast<std::uint32_t>(reached[f])];
        // Triangles at the border itself count whatever their size, so that neither side is empty.
        if (f >= at_border && distance2(here.centroid, middles[from]) > band2) continue;
        weighted += here.sums[0];
        weight += here.sums[1];
        for (const std::uint32_t next : here.neighbours) end = reach(next, from << 32, end, met_in, round);
      }
      sums[0] += weighted;
      sums[1] += weight;
      num_reached = static_cast<std::size_t>(end - front.data());
    }
    return sums;
  }

  static float distance2(const std::array<float, 3>& a, const std::array<float, 4>& b) {
    const float x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
    return x * x + y * y + z * z;
  }

  const BandTriangle* triangles_;
  float band2_;
  std::vector<std::uint8_t> met_in_;  ///< of triangles, the round of the region for which it was last met
  std::uint8_t round_ = 0;
  std::array<std::vector<Reached>, 2> fronts_;  ///< room: outside, inside
  std::vector<std::array<float, 4>> middles_;   ///< of the level half-edges; x, y, z
};

}  // namespace

std::vector<double> border_contrasts(const SurfaceView& surface, const ComponentTree& tree,
                                     std::span<const std::int32_t> selected, std::span<const double> triangle_values,
                                     std::span<const double> areas, double band, const Execution& execution) {
  std::vector<double> contrasts(selected.size(), 0);
  if (selected.empty()) return contrasts;
  const BandMesh mesh = make_band_mesh(surface, tree, selected, triangle_values, areas, execution);
  const auto edges_of = [&](std::size_t i) {
    const std::int64_t first = mesh.level_edges.first_of_owner[i], last = mesh.level_edges.first_of_owner[i + 1];
    return std::span(mesh.level_edges.half_edges)
        .subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(last - first));
  };
  // As many walks as threads work at a time, since each holds a byte a triangle.
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
                    if (!walk) walk = std::make_unique<BandWalk>(mesh, band);
                    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i)
                      contrasts[i] = walk->contrast(edges_of(i));
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
