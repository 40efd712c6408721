#include "stages/curvature/scale_space.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>

#include "stages/common/cell_grid.hpp"
#include "stages/curvature/plane_moments.hpp"

namespace meshmser {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// Cells of half a radius: half of what is gathered lies within the ball, and two to five points share a gathering.
constexpr int kReach = 2;

// Share of the radius. The centroid of the points within the radius slides by 0.42 of it at a straight rim, by 0.17
// half a radius away, and by 0.09 on average where fifty points lie at random: beyond that a rim may be near.
constexpr double kSlide = 0.1;
// Half the width, in radii, of the strip toward the missing side that is searched for the last point: narrow enough to
// follow a bent rim, wide enough to hold several points.
constexpr double kStrip = 0.4;

// How far the cloud goes on from a point, along its plane, on the side away from the centroid of its neighbours.
double distance_to_rim(const CellBlock& block, const BlockNormals* normals, std::int64_t own,
                       const Eigen::Vector3d& plane, const Eigen::Vector3d& slide, double radius) {
  const double length = slide.norm();
  if (!(length > kSlide * radius)) return radius;
  const auto at = [](std::int64_t i) { return static_cast<std::size_t>(i); };
  const Eigen::Vector3d out = -slide / length, along = plane.cross(out);
  const Eigen::Vector3d centre(block.x[at(own)], block.y[at(own)], block.z[at(own)]);
  double farthest = 0;
  for (std::int64_t i = 0; i < block.num_candidates; ++i) {
    const Eigen::Vector3d d = Eigen::Vector3d(block.x[at(i)], block.y[at(i)], block.z[at(i)]) - centre;
    const double reach = d.dot(out);
    if (reach <= farthest || std::abs(d.dot(along)) > kStrip * radius || d.squaredNorm() > radius * radius) continue;
    if (normals != nullptr && normals->x[at(i)] * normals->x[at(own)] + normals->y[at(i)] * normals->y[at(own)] +
                                      normals->z[at(i)] * normals->z[at(own)] <
                                  kOpposedCosine)
      continue;
    farthest = reach;
  }
  return farthest;
}

}  // namespace

ScaleSpace scale_space(std::span<const Eigen::Vector3d> points, std::span<const Eigen::Vector3d> normals,
                       const ScaleSpaceParameters& parameters, const Execution& execution) {
  const double radius = parameters.radius;
  if (!(radius > 0) || !std::isfinite(radius))
    throw StageError("the radius of the regression must be positive; it is " + std::to_string(radius) +
                     " (a cloud of fewer than 17 points has no spacing: give the radius in units)");
  const std::size_t n = points.size();
  ScaleSpace result;
  result.positions.assign(points.begin(), points.end());
  result.normals.assign(normals.begin(), normals.end());
  result.mean_curvature.assign(n, kNaN);
  if (parameters.find_rims) result.rim_distance.assign(n, kNaN);
  std::vector<double> residuals(n, kNaN);
  std::vector<std::uint8_t> had_plane(n, 0);
  std::vector<Eigen::Vector3d> next(n);

  for (int step = 0; step < parameters.steps; ++step) {
    const CellGrid grid(result.positions, radius / kReach);
    const bool last = step + 1 == parameters.steps;
    for_each_cell(grid, kReach, "scale space", execution, [&](const CellBlock& block) {
      thread_local BlockNormals block_normals;
      thread_local std::vector<PlaneMoments> moments;
      const bool may_oppose = block_normals.gather(block, normals);
      if (may_oppose)
        plane_moments(block, block_normals, radius, moments);
      else
        plane_moments(block, radius, moments);
      for (std::int64_t own = block.own_begin; own < block.own_end; ++own) {
        const auto id = static_cast<std::size_t>(block.ids[static_cast<std::size_t>(own)]);
        const PlaneMoments& sums = moments[static_cast<std::size_t>(own - block.own_begin)];
        next[id] = result.positions[id];
        const LeastEigen plane = sums.count >= 3 ? least_eigen(sums.covariance()) : LeastEigen{};
        if (!plane.is_plane()) {
          if (last) result.normals[id].setZero();
          continue;
        }
        had_plane[id] = 1;
        if (step == 0) residuals[id] = std::max(0.0, plane.value);
        // The sign is handed on from step to step: the raw normal may be far from that of a much smoother surface.
        const bool oriented = normals[id] != Eigen::Vector3d::Zero();
        const Eigen::Vector3d outward = plane.vector.dot(result.normals[id]) < 0 ? -plane.vector : plane.vector;
        const Eigen::Vector3d centroid = sums.centroid();
        const double displacement = centroid.dot(outward);
        next[id] += displacement * outward;
        if (oriented) result.normals[id] = outward;
        if (last && oriented) result.mean_curvature[id] = -4 * displacement / (radius * radius);
        if (last && parameters.find_rims)
          result.rim_distance[id] = distance_to_rim(block, may_oppose ? &block_normals : nullptr, own, outward,
                                                    centroid - displacement * outward, radius);
      }
    });
    result.positions.swap(next);
  }
  result.num_isolated = std::count(had_plane.begin(), had_plane.end(), std::uint8_t{0});

  std::erase_if(residuals, [](double value) { return std::isnan(value); });
  if (!residuals.empty()) {
    const auto middle = residuals.begin() + static_cast<std::ptrdiff_t>(residuals.size() / 2);
    std::nth_element(residuals.begin(), middle, residuals.end());
    result.noise = std::sqrt(*middle);
  }
  return result;
}

double mean_curvature_noise(double noise, double spacing, const ScaleSpaceParameters& parameters) {
  if (!(spacing > 0)) return 0;
  const double radius = parameters.radius;
  const double floor = 0.0003 / spacing;
  if (parameters.steps <= 1) return std::max(floor, 4 * noise / (radius * radius));
  struct Measured {
    double steps, constant;
  };
  static constexpr std::array<Measured, 5> kMeasured{{{2, 1.25}, {3, 0.40}, {4, 0.237}, {6, 0.122}, {8, 0.077}}};
  std::size_t upper = 1;
  while (upper + 1 < kMeasured.size() && parameters.steps > kMeasured[upper].steps) ++upper;
  const auto &a = kMeasured[upper - 1], &b = kMeasured[upper];
  const double t = std::log(parameters.steps / a.steps) / std::log(b.steps / a.steps);
  const double constant = std::exp(std::log(a.constant) + t * (std::log(b.constant) - std::log(a.constant)));
  return std::max(floor, constant * noise * spacing / (radius * radius * radius));
}

}  // namespace meshmser
