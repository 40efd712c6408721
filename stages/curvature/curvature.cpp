#include "stages/curvature/curvature.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "stages/curvature/quadric.hpp"
#include "stages/curvature/scale_space.hpp"

namespace meshmser {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// The quadric sees somewhat less than the scale-space step, which blurs less: 3.5 spacings for a radius of 4.
constexpr double kQuadricShare = 0.875;
constexpr double kNoiseRadius = 4;  // spacings
constexpr double kRimShare = 0.5;   // of the radius: a sphere loses a fifth or more of its curvature nearer to a rim

std::vector<double> crease_of(const std::vector<double>& largest, const std::vector<double>& mean) {
  std::vector<double> crease(mean.size());
  for (std::size_t i = 0; i < crease.size(); ++i)
    crease[i] = std::sqrt(largest[i] * largest[i] + 4 * mean[i] * mean[i]);
  return crease;
}

}  // namespace

Curvature measure_curvature(const PointCloud& cloud, const PointNormals& normals, const CurvatureOptions& options,
                            const Execution& execution) {
  const std::size_t n = cloud.num_points();
  Curvature result;
  const ScaleSpaceParameters scale{options.radius, options.steps, true};
  ScaleSpace space = scale_space(cloud.positions, normals.normals, scale, execution);
  // A wide neighbourhood's residuals hold the relief itself: sigma_z is measured at 4 spacings at most.
  const double near = kNoiseRadius * cloud.spacing;
  if (near > 0 && options.radius > 1.1 * near)
    space.noise = scale_space(cloud.positions, normals.normals, {near, 1}, execution).noise;
  result.report.noise = space.noise;
  result.report.num_isolated = space.num_isolated;
  for (const Eigen::Vector3d& normal : normals.normals)
    result.report.num_unoriented += normal == Eigen::Vector3d::Zero();

  const bool raw = options.method == CurvatureMethod::kQuadric;
  PrincipalCurvatures principal =
      raw ? fit_quadrics(cloud.positions, space.normals, options.radius, execution)
          : fit_quadrics(space.positions, space.normals, kQuadricShare * options.radius, execution);
  std::vector<double> mean = std::move(space.mean_curvature);
  std::vector<double> largest(n, kNaN);
  for (std::size_t i = 0; i < n; ++i) {
    const bool fitted = !std::isnan(principal.k1[i]);
    if (!fitted && !std::isnan(mean[i])) {
      ++result.report.num_without_quadric;
      principal.k1[i] = principal.k2[i] = mean[i];
    } else if (raw) {
      mean[i] = (principal.k1[i] + principal.k2[i]) / 2;
    }
    if (std::isnan(mean[i])) principal.k1[i] = principal.k2[i] = kNaN;
    largest[i] = std::max(std::abs(principal.k1[i]), std::abs(principal.k2[i]));
  }

  std::vector<double> rim_distance = std::move(space.rim_distance);
  for (std::size_t i = 0; i < n; ++i) {
    if (std::isnan(mean[i])) rim_distance[i] = kNaN;
    if (!(rim_distance[i] < kRimShare * options.radius)) continue;
    ++result.report.num_at_rims;
    if (options.rims == RimTreatment::kExclude) mean[i] = principal.k1[i] = principal.k2[i] = largest[i] = kNaN;
  }

  const double sigma = raw ? quadric_noise(space.noise, cloud.spacing, options.radius)
                           : mean_curvature_noise(space.noise, cloud.spacing, scale);
  std::vector<double> crease = crease_of(largest, mean);
  auto& fields = result.scalars.fields;
  fields.push_back({"mean_curvature", "1/unit", Parity::kOdd, sigma, std::move(mean)});
  fields.push_back({"k1", "1/unit", Parity::kOdd, sigma, std::move(principal.k1)});
  fields.push_back({"k2", "1/unit", Parity::kOdd, sigma, std::move(principal.k2)});
  fields.push_back({"max_abs_curvature", "1/unit", Parity::kEven, sigma, std::move(largest)});
  fields.push_back({"crease", "1/unit", Parity::kEven, sigma, std::move(crease)});

  if (options.height_radius > 0) {
    const ScaleSpace large =
        scale_space(cloud.positions, normals.normals, {options.height_radius, options.height_steps}, execution);
    std::vector<double> height(n, kNaN);
    for (std::size_t i = 0; i < n; ++i)
      if (!std::isnan(large.mean_curvature[i]))
        height[i] = (cloud.positions[i] - large.positions[i]).dot(large.normals[i]);
    // The large-scale surface averages over so many points that what is left is the raw point's own noise.
    fields.push_back({"height", "unit", Parity::kOdd, space.noise, std::move(height)});
  }
  fields.push_back({"rim_distance", "unit", Parity::kEven, kNaN, std::move(rim_distance)});
  result.scalars.radius = options.radius;
  result.smoothed = {std::move(space.positions), options.radius, options.steps};
  return result;
}

}  // namespace meshmser
