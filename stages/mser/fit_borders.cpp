#include "stages/mser/fit_borders.hpp"

#include <tbb/enumerable_thread_specific.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>

#include "stages/common/least_eigen.hpp"
#include "stages/common/parallel.hpp"
#include "stages/mser/patch_walk.hpp"

namespace meshmser {
namespace {

using Eigen::Vector3d;

constexpr double kSampleDistance = 1.5;  // spacings between places along a border
constexpr double kReach = 4;             // spacings from a place over which it decides
constexpr double kAlong = 3;             // spacings along the border over which a side counts
constexpr double kCertain = 1.5;         // spacings within which an edge must be known
constexpr std::size_t kFewest = 12;      // triangles of a side

Vector3d corner(const SurfaceView& surface, std::int32_t half_edge) {
  return surface.positions[static_cast<std::size_t>(
      surface.triangles[static_cast<std::size_t>(half_edge / 3)][static_cast<std::size_t>(half_edge % 3)])];
}

Vector3d middle(const SurfaceView& surface, std::int32_t half_edge) {
  const std::int32_t next = half_edge % 3 == 2 ? half_edge - 2 : half_edge + 1;
  return (corner(surface, half_edge) + corner(surface, next)) / 2;
}

/// A plane through the mean of a side, and how well it is known.
struct Plane {
  Vector3d mean = Vector3d::Zero(), normal = Vector3d::Zero();
  double error = std::numeric_limits<double>::infinity();  ///< standard error of its height
  double above(const Vector3d& p) const { return (p - mean).dot(normal); }
};

/// The triangles of one side of a place.
struct Side {
  std::vector<Vector3d> centroids;
  std::vector<double> areas;
  Vector3d turned = Vector3d::Zero();  ///< sum of the triangles' normals x areas

  void add(const SurfaceView& surface, std::int32_t triangle, const Vector3d& centroid,
           std::span<const double> area_of_triangle) {
    centroids.push_back(centroid);
    areas.push_back(area_of_triangle[static_cast<std::size_t>(triangle)]);
    const Vector3d a = corner(surface, 3 * triangle), b = corner(surface, 3 * triangle + 1),
                   c = corner(surface, 3 * triangle + 2);
    turned += (b - a).cross(c - a);
  }
};

/// The plane of least squares, weighted by area x weight(centroid).
template <class Weight>
Plane fit_plane(const Side& side, Weight weight) {
  Plane plane;
  double total = 0, squares = 0;
  for (std::size_t i = 0; i < side.centroids.size(); ++i) {
    const double w = side.areas[i] * weight(side.centroids[i]);
    plane.mean += w * side.centroids[i];
    total += w;
    squares += w * w;
  }
  if (!(total > 0)) return plane;
  plane.mean /= total;
  SymmetricMatrix3 moments;
  for (std::size_t i = 0; i < side.centroids.size(); ++i) {
    const double w = side.areas[i] * weight(side.centroids[i]) / total;
    const Vector3d d = side.centroids[i] - plane.mean;
    moments.xx += w * d.x() * d.x();
    moments.xy += w * d.x() * d.y();
    moments.xz += w * d.x() * d.z();
    moments.yy += w * d.y() * d.y();
    moments.yz += w * d.y() * d.z();
    moments.zz += w * d.z() * d.z();
  }
  const LeastEigen least = least_eigen(moments);
  if (!least.is_plane()) return plane;
  plane.normal = least.vector.dot(side.turned) < 0 ? -least.vector : least.vector;
  plane.error = std::sqrt(std::max(0.0, least.value) * squares) / total;
  return plane;
}

/// What decides between two labels near a place of their border.
struct Place {
  std::int32_t low = 0, high = 0;  ///< labels
  std::int32_t half_edge = -1;     ///< of `low`
  bool decides = false;
  Vector3d position = Vector3d::Zero(), along = Vector3d::Zero();
  Plane plane_low, plane_high;
  double convex = 1;  ///< -1 in a valley

  /// Whether the label `high` should be there, where this place decides.
  bool is_high(const Vector3d& p) const { return convex * (plane_high.above(p) - plane_low.above(p)) > 0; }
};

/// Centroids, each averaged with its neighbours' over edges, several times.
std::vector<Vector3d> even_centroids(const SurfaceView& surface, const Execution& execution) {
  constexpr int kAverages = 4;
  std::vector<Vector3d> now(surface.triangles.size()), next(now.size());
  const auto for_all = [&](auto body) {
    parallel_chunks(static_cast<std::int64_t>(now.size()), 1 << 15, "", execution,
                    [&](std::int64_t begin, std::int64_t end) {
                      for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t) body(t);
                    });
  };
  for_all([&](std::size_t t) {
    Vector3d sum = Vector3d::Zero();
    for (const std::int32_t v : surface.triangles[t]) sum += surface.positions[static_cast<std::size_t>(v)];
    now[t] = sum / 3;
  });
  for (int i = 0; i < kAverages; ++i) {
    for_all([&](std::size_t t) {
      Vector3d sum = now[t];
      int count = 1;
      for (std::size_t h = 3 * t; h < 3 * t + 3; ++h)
        if (surface.twins[h] >= 0) {
          sum += now[static_cast<std::size_t>(surface.twins[h] / 3)];
          ++count;
        }
      next[t] = sum / count;
    });
    now.swap(next);
  }
  return now;
}

/// Places along the borders, of each pair of labels one in every cell of the sample distance that its border meets, and
/// for every border half-edge the place that stands for it.
struct Places {
  std::vector<Place> places;
  std::vector<std::pair<std::int32_t, std::int32_t>> place_of_half_edge;  ///< half-edge of the lower label, place
};

Places find_places(const SurfaceView& surface, std::span<const std::int32_t> labels, double distance) {
  struct Key {
    std::int32_t low, high;
    std::array<std::int64_t, 3> cell;
    std::int32_t half_edge;
    auto place() const { return std::tie(low, high, cell); }
  };
  std::vector<Key> keys;
  for (std::size_t h = 0; h < surface.twins.size(); ++h) {
    if (surface.twins[h] < 0) continue;
    const std::int32_t here = labels[h / 3], there = labels[static_cast<std::size_t>(surface.twins[h] / 3)];
    if (here == 0 || here >= there) continue;
    const Vector3d cell = (middle(surface, static_cast<std::int32_t>(h)) / distance).array().floor();
    keys.push_back({here,
                    there,
                    {static_cast<std::int64_t>(cell.x()), static_cast<std::int64_t>(cell.y()),
                     static_cast<std::int64_t>(cell.z())},
                    static_cast<std::int32_t>(h)});
  }
  std::sort(keys.begin(), keys.end(), [](const Key& a, const Key& b) {
    return a.place() != b.place() ? a.place() < b.place() : a.half_edge < b.half_edge;
  });
  Places found;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (i == 0 || keys[i].place() != keys[i - 1].place()) {
      Place place;
      place.low = keys[i].low;
      place.high = keys[i].high;
      place.half_edge = keys[i].half_edge;
      place.position = middle(surface, keys[i].half_edge);
      found.places.push_back(place);
    }
    found.place_of_half_edge.emplace_back(keys[i].half_edge, static_cast<std::int32_t>(found.places.size()) - 1);
  }
  std::sort(found.place_of_half_edge.begin(), found.place_of_half_edge.end());
  return found;
}

Side gather(const SurfaceView& surface, std::span<const std::int32_t> labels, std::span<const double> areas,
            const Vector3d& position, double radius, std::int32_t first, PatchWalk& walk) {
  Side side;
  const std::int32_t label = labels[static_cast<std::size_t>(first)];
  walk.walk(
      surface, position, radius, first, [&](std::int32_t t) { return labels[static_cast<std::size_t>(t)] == label; },
      [&](std::int32_t t, const Vector3d& centroid) { side.add(surface, t, centroid, areas); });
  return side;
}

/// Fits both planes; the place decides where they tell where the edge is.
void measure(const SurfaceView& surface, std::span<const std::int32_t> labels, std::span<const double> areas,
             const FitParameters& parameters, PatchWalk& walk, Place& place) {
  const Side low = gather(surface, labels, areas, place.position, parameters.radius, place.half_edge / 3, walk);
  const Side high = gather(surface, labels, areas, place.position, parameters.radius,
                           surface.twins[static_cast<std::size_t>(place.half_edge)] / 3, walk);
  if (std::min(low.centroids.size(), high.centroids.size()) < kFewest) return;
  // At first without a direction of the border. What is far from the border belongs to its side for certain.
  const auto far = [&](const Vector3d& p) { return (p - place.position).squaredNorm(); };
  place.along = fit_plane(low, far).normal.cross(fit_plane(high, far).normal);
  if (place.along.squaredNorm() < 1e-6) return;
  place.along.normalize();
  const auto beside = [&](const Vector3d& p) {
    const double l = (p - place.position).dot(place.along) / (kAlong * parameters.spacing);
    return far(p) * std::exp(-0.5 * l * l);
  };
  place.plane_low = fit_plane(low, beside);
  place.plane_high = fit_plane(high, beside);
  const Vector3d turn = place.plane_high.normal - place.plane_low.normal;
  const double sine = turn.norm();  // 2 sin(half the angle)
  if (!(sine >= 2 * std::sin(parameters.least_turn / 2))) return;
  if (!(place.plane_low.error + place.plane_high.error <= kCertain * parameters.spacing * sine / 2)) return;
  place.convex = turn.dot(place.plane_high.mean - place.plane_low.mean) >= 0 ? 1 : -1;
  // An edge that lies beyond the reach is not that of this border.
  const double off = std::abs(place.plane_high.above(place.position) - place.plane_low.above(place.position)) / sine;
  place.decides = off <= kReach * parameters.spacing;
}

/// Triangles on their way from the places near them, nearest first as far as steps over edges tell.
void decide(const SurfaceView& surface, std::span<const Vector3d> centroids, const Places& places, double spacing,
            std::vector<std::int32_t>& labels) {
  const std::vector<std::int32_t> before = labels;
  std::vector<std::int32_t> place_of_triangle(labels.size(), -1);
  std::vector<std::int32_t> front;
  const auto reach = [&](std::int32_t t, std::int32_t p) {
    std::int32_t& met = place_of_triangle[static_cast<std::size_t>(t)];
    const Place& place = places.places[static_cast<std::size_t>(p)];
    const std::int32_t label = before[static_cast<std::size_t>(t)];
    if (met >= 0 || (label != place.low && label != place.high)) return;
    const Vector3d way = centroids[static_cast<std::size_t>(t)] - place.position;
    if (way.squaredNorm() > kReach * kReach * spacing * spacing) return;
    met = p;
    front.push_back(t);
    if (!place.decides) return;
    const Vector3d& centroid = centroids[static_cast<std::size_t>(t)];
    const bool high = place.is_high(centroid);
    if ((label == place.high) == high) return;
    // Past the border's end a face may go on where the other's plane is only cut: there it must be the nearer plane
    // too.
    const bool beside = std::abs(way.dot(place.along)) <= kSampleDistance * spacing;
    const double to_low = std::abs(place.plane_low.above(centroid)),
                 to_high = std::abs(place.plane_high.above(centroid));
    if (beside || (high ? to_high < to_low : to_low < to_high))
      labels[static_cast<std::size_t>(t)] = high ? place.high : place.low;
  };
  for (const auto& [half_edge, place] : places.place_of_half_edge) {
    reach(half_edge / 3, place);
    reach(surface.twins[static_cast<std::size_t>(half_edge)] / 3, place);
  }
  for (std::size_t i = 0; i < front.size(); ++i) {
    const auto t = static_cast<std::size_t>(front[i]);
    for (std::size_t h = 3 * t; h < 3 * t + 3; ++h)
      if (surface.twins[h] >= 0) reach(surface.twins[h] / 3, place_of_triangle[t]);
  }
}

}  // namespace

std::vector<std::int32_t> fit_borders(const SurfaceView& surface, std::span<const std::int32_t> labels,
                                      std::span<const double> areas, const FitParameters& parameters,
                                      const Execution& execution) {
  std::vector<std::int32_t> fitted(labels.begin(), labels.end());
  const std::vector<Vector3d> centroids = even_centroids(surface, execution);
  tbb::enumerable_thread_specific<PatchWalk> walks;
  for (std::int32_t round = 0; round < parameters.rounds; ++round) {
    Places places = find_places(surface, fitted, kSampleDistance * parameters.spacing);
    parallel_chunks(static_cast<std::int64_t>(places.places.size()), 64, "fitting borders", execution,
                    [&](std::int64_t begin, std::int64_t end) {
                      for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i)
                        measure(surface, fitted, areas, parameters, walks.local(), places.places[i]);
                    });
    decide(surface, centroids, places, parameters.spacing, fitted);
  }
  return fitted;
}

}  // namespace meshmser
