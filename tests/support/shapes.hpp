#pragma once
/// Point samples of surfaces whose normals and curvatures are known, for the tests of points' stages.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "pipeline/artifacts/point_cloud.hpp"

namespace meshmser::shapes {

struct Sample {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector3d> normals;  ///< outward, unit
  std::vector<double> mean_curvature;    ///< H; > 0 where the surface bends away from the normal
};

/// Evenly spread points (golden-angle spiral), about 4 pi radius^2 / spacing^2 of them.
inline Sample sphere(double radius, double spacing) {
  Sample s;
  const auto n = static_cast<int>(4 * std::numbers::pi * radius * radius / (spacing * spacing));
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  for (int i = 0; i < n; ++i) {
    const double z = 1 - (2.0 * i + 1) / n, r = std::sqrt(1 - z * z);
    const Eigen::Vector3d d(r * std::cos(golden * i), r * std::sin(golden * i), z);
    s.points.push_back(radius * d);
    s.normals.push_back(d);
    s.mean_curvature.push_back(1 / radius);
  }
  return s;
}

/// A square grid, slightly shaken within its plane z = 0, of side length `side`; its normal is +z.
inline Sample plane(double side, double spacing, std::uint32_t seed = 1) {
  Sample s;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shake(-0.3 * spacing, 0.3 * spacing);
  const int n = static_cast<int>(side / spacing);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const double x = (i + 0.5) * spacing - side / 2 + shake(random);
      const double y = (j + 0.5) * spacing - side / 2 + shake(random);
      s.points.emplace_back(x, y, 0);
      s.normals.emplace_back(0, 0, 1);
      s.mean_curvature.push_back(0);
    }
  return s;
}

/// The side of a cylinder about the z axis, open at both ends. Points are shaken along the surface: a lattice holds up
/// to a tenth more or fewer points within a radius than a disk of its density, which would hide a method's own error.
inline Sample cylinder(double radius, double length, double spacing, std::uint32_t seed = 1) {
  Sample s;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shake(-0.4, 0.4);
  const int around = static_cast<int>(2 * std::numbers::pi * radius / spacing);
  const int along = static_cast<int>(length / spacing);
  for (int j = 0; j < along; ++j)
    for (int i = 0; i < around; ++i) {
      const double angle = 2 * std::numbers::pi * (i + shake(random)) / around;
      const double z = (j + 0.5 + shake(random)) * length / along - length / 2;
      const Eigen::Vector3d d(std::cos(angle), std::sin(angle), 0);
      s.points.push_back(radius * d + Eigen::Vector3d(0, 0, z));
      s.normals.push_back(d);
      s.mean_curvature.push_back(1 / (2 * radius));
    }
  return s;
}

/// A torus about the z axis: `major` from the axis to the tube's centre, `minor` the tube's radius. Shaken as the
/// cylinder.
inline Sample torus(double major, double minor, double spacing, std::uint32_t seed = 1) {
  Sample s;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shake(-0.4, 0.4);
  const int tube = static_cast<int>(2 * std::numbers::pi * minor / spacing);
  for (int j = 0; j < tube; ++j) {
    const int around =
        static_cast<int>(2 * std::numbers::pi * (major + minor * std::cos(2 * std::numbers::pi * j / tube)) / spacing);
    for (int i = 0; i < around; ++i) {
      const double v = 2 * std::numbers::pi * (j + shake(random)) / tube, ring = major + minor * std::cos(v);
      const double u = 2 * std::numbers::pi * (i + shake(random)) / around;
      const Eigen::Vector3d out(std::cos(u), std::sin(u), 0);
      s.points.push_back(ring * out + Eigen::Vector3d(0, 0, minor * std::sin(v)));
      s.normals.push_back(std::cos(v) * out + Eigen::Vector3d(0, 0, std::sin(v)));
      s.mean_curvature.push_back((1 / minor + std::cos(v) / ring) / 2);
    }
  }
  return s;
}

/// The closed surface of a box centred at the origin, points half a spacing away from its edges.
inline Sample box(const Eigen::Vector3d& size, double spacing) {
  Sample s;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0}) {
      const int a = (axis + 1) % 3, b = (axis + 2) % 3;
      const int na = std::max(1, static_cast<int>(std::lround(size[a] / spacing)));
      const int nb = std::max(1, static_cast<int>(std::lround(size[b] / spacing)));
      for (int i = 0; i < na; ++i)
        for (int j = 0; j < nb; ++j) {
          Eigen::Vector3d p, n = Eigen::Vector3d::Zero();
          p[axis] = side * size[axis] / 2;
          p[a] = (i + 0.5) * size[a] / na - size[a] / 2;
          p[b] = (j + 0.5) * size[b] / nb - size[b] / 2;
          n[axis] = side;
          s.points.push_back(p);
          s.normals.push_back(n);
          s.mean_curvature.push_back(0);
        }
    }
  return s;
}

/// Moves every point along its normal by independent Gaussian noise.
inline void add_noise(Sample& s, double sigma, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, sigma);
  for (std::size_t i = 0; i < s.points.size(); ++i) s.points[i] += noise(random) * s.normals[i];
}

/// The sample as a cloud of one scan, points in the sample's order.
inline PointCloud cloud_of(const Sample& s, double spacing) {
  PointCloud cloud;
  cloud.spacing = spacing;
  cloud.positions = s.points;
  cloud.num_raw_points = static_cast<std::int64_t>(s.points.size());
  for (std::size_t i = 0; i < s.points.size(); ++i) cloud.raw_index_of_point.push_back(static_cast<std::int64_t>(i));
  cloud.scan_of_point.assign(s.points.size(), 0);
  cloud.scans.push_back({"shape", std::nullopt, cloud.num_raw_points});
  return cloud;
}

}  // namespace meshmser::shapes
