#pragma once
/// Points scattered over shapes with known topology, spacing about 1, in no particular order of space.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

#include "pipeline/artifacts/point_cloud.hpp"
#include "pipeline/artifacts/point_normals.hpp"

namespace meshmser {

struct ScatteredShape {
  PointCloud cloud;
  PointNormals normals;

  /// Adds a point with its outward normal.
  void add(const Eigen::Vector3d& position, const Eigen::Vector3d& normal) {
    cloud.positions.push_back(position);
    normals.normals.push_back(normal);
    normals.component_of_point.push_back(0);
  }
  /// Declares what decided the normals' signs.
  ScatteredShape& finish(SignSource source = SignSource::kScanner) {
    cloud.spacing = 1;
    normals.components = {NormalComponent{static_cast<std::int64_t>(cloud.num_points()), source, 1, false}};
    return *this;
  }
};

using Keep = std::function<bool(double, double)>;

/// A jittered square grid in the plane z = 0 over [0, side] x [0, side], where `keep(x, y)`.
inline ScatteredShape scattered_plane(int side, double jitter, const Keep& keep = {}, std::uint32_t seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-jitter, jitter);
  ScatteredShape shape;
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      const double x = i + shift(random), y = j + shift(random);
      if (!keep || keep(x, y)) shape.add({x, y, 0}, {0, 0, 1});
    }
  }
  return shape.finish();
}

/// A sphere of this radius about `centre`, evenly covered (Fibonacci lattice), where `keep(direction)`.
inline void add_sphere(ScatteredShape& shape, double radius, const Eigen::Vector3d& centre = Eigen::Vector3d::Zero(),
                       const std::function<bool(const Eigen::Vector3d&)>& keep = {}) {
  const int n = static_cast<int>(4 * std::numbers::pi * radius * radius);
  const double turn = std::numbers::pi * (3 - std::sqrt(5.0));
  for (int i = 0; i < n; ++i) {
    const double z = 1 - 2 * (i + 0.5) / n, r = std::sqrt(1 - z * z);
    const Eigen::Vector3d direction(r * std::cos(turn * i), r * std::sin(turn * i), z);
    if (!keep || keep(direction)) shape.add(centre + radius * direction, direction);
  }
}

inline ScatteredShape scattered_sphere(double radius) {
  ScatteredShape shape;
  add_sphere(shape, radius);
  return shape.finish();
}

/// A torus about z, jittered.
inline ScatteredShape scattered_torus(double major, double minor, std::uint32_t seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-0.3, 0.3);
  ScatteredShape shape;
  const int rows = static_cast<int>(2 * std::numbers::pi * minor);
  for (int i = 0; i < rows; ++i) {
    const double ring = major + minor * std::cos(2 * std::numbers::pi * i / rows);
    const int columns = static_cast<int>(2 * std::numbers::pi * ring);
    for (int j = 0; j < columns; ++j) {
      const double u = 2 * std::numbers::pi * (i + shift(random)) / rows,
                   v = 2 * std::numbers::pi * (j + shift(random)) / columns;
      const Eigen::Vector3d normal(std::cos(u) * std::cos(v), std::cos(u) * std::sin(v), std::sin(u));
      shape.add(Eigen::Vector3d(major * std::cos(v), major * std::sin(v), 0) + minor * normal, normal);
    }
  }
  return shape.finish();
}

/// The volume that a closed mesh encloses, positive if it faces outward.
inline double signed_volume(const std::vector<Eigen::Vector3d>& positions,
                            const std::vector<std::array<std::int32_t, 3>>& triangles) {
  double six = 0;
  for (const auto& t : triangles) {
    const auto p = [&](int k) -> const Eigen::Vector3d& {
      return positions[static_cast<std::size_t>(t[static_cast<std::size_t>(k)])];
    };
    six += p(0).dot(p(1).cross(p(2)));
  }
  return six / 6;
}

}  // namespace meshmser
