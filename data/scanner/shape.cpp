#include "data/scanner/shape.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <compare>
#include <numbers>
#include <numeric>
#include <tuple>

namespace meshmser::scanner {
namespace {

struct EdgeSide {
  std::int32_t a, b, triangle;
  auto operator<=>(const EdgeSide&) const = default;
};

std::vector<EdgeSide> sorted_sides(const std::vector<std::array<std::int32_t, 3>>& triangles) {
  std::vector<EdgeSide> sides;
  sides.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t a = triangles[t][k], b = triangles[t][(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), static_cast<std::int32_t>(t)});
    }
  std::sort(sides.begin(), sides.end());
  return sides;
}

Eigen::Vector3d unit_normal(const TriangleMesh& mesh, std::int32_t triangle) {
  const auto& [a, b, c] = mesh.triangles[static_cast<std::size_t>(triangle)];
  const Eigen::Vector3d& p = mesh.positions[static_cast<std::size_t>(a)];
  return (mesh.positions[static_cast<std::size_t>(b)] - p)
      .cross(mesh.positions[static_cast<std::size_t>(c)] - p)
      .normalized();
}

/// Degrees between two unit vectors, accurate near 0.
double angle_between(const Eigen::Vector3d& one, const Eigen::Vector3d& two) {
  return std::atan2(one.cross(two).norm(), one.dot(two)) * 180 / std::numbers::pi;
}

}  // namespace

std::vector<EdgeSample> true_edges(const Shape& shape, double step) {
  const std::vector<EdgeSide> sides = sorted_sides(shape.mesh.triangles);
  std::vector<EdgeSample> samples;
  for (std::size_t i = 1; i < sides.size(); ++i) {
    const EdgeSide &one = sides[i - 1], &two = sides[i];
    if (one.a != two.a || one.b != two.b) continue;
    if (shape.face_of_triangle[static_cast<std::size_t>(one.triangle)] ==
        shape.face_of_triangle[static_cast<std::size_t>(two.triangle)])
      continue;
    const double angle = angle_between(unit_normal(shape.mesh, one.triangle), unit_normal(shape.mesh, two.triangle));
    const Eigen::Vector3d& from = shape.mesh.positions[static_cast<std::size_t>(one.a)];
    const Eigen::Vector3d& to = shape.mesh.positions[static_cast<std::size_t>(one.b)];
    const int pieces = std::max(1, static_cast<int>(std::ceil((to - from).norm() / step)));
    for (int piece = 0; piece < pieces; ++piece)
      samples.push_back({from + (to - from) * ((piece + 0.5) / pieces), angle});
  }
  return samples;
}

std::vector<std::int32_t> faces_by_angle(const TriangleMesh& mesh, double angle) {
  // Vertices at the same place become one.
  std::vector<std::int32_t> order(mesh.num_vertices());
  std::iota(order.begin(), order.end(), 0);
  auto key = [&](std::int32_t v) {
    const Eigen::Vector3d& p = mesh.positions[static_cast<std::size_t>(v)];
    return std::make_tuple(p.x(), p.y(), p.z());
  };
  std::sort(order.begin(), order.end(),
            [&](std::int32_t a, std::int32_t b) { return std::make_pair(key(a), a) < std::make_pair(key(b), b); });
  std::vector<std::int32_t> first(mesh.num_vertices());
  for (std::size_t i = 0; i < order.size(); ++i)
    first[static_cast<std::size_t>(order[i])] =
        i > 0 && key(order[i]) == key(order[i - 1]) ? first[static_cast<std::size_t>(order[i - 1])] : order[i];
  std::vector<std::array<std::int32_t, 3>> triangles = mesh.triangles;
  for (auto& triangle : triangles)
    for (std::int32_t& v : triangle) v = first[static_cast<std::size_t>(v)];

  std::vector<std::int32_t> parent(triangles.size());
  std::iota(parent.begin(), parent.end(), 0);
  auto root = [&](std::int32_t t) {
    while (parent[static_cast<std::size_t>(t)] != t) {
      std::int32_t& up = parent[static_cast<std::size_t>(t)];
      up = parent[static_cast<std::size_t>(up)];
      t = up;
    }
    return t;
  };
  const std::vector<EdgeSide> sides = sorted_sides(triangles);
  for (std::size_t i = 1; i < sides.size(); ++i) {
    const EdgeSide &one = sides[i - 1], &two = sides[i];
    if (one.a != two.a || one.b != two.b) continue;
    if (angle_between(unit_normal(mesh, one.triangle), unit_normal(mesh, two.triangle)) >= angle) continue;
    const std::int32_t a = root(one.triangle), b = root(two.triangle);
    parent[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);  // the smallest triangle is the root
  }
  std::vector<std::int32_t> face(triangles.size());
  std::int32_t num_faces = 0;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const std::int32_t r = root(static_cast<std::int32_t>(t));
    face[t] = static_cast<std::size_t>(r) == t ? ++num_faces : face[static_cast<std::size_t>(r)];
  }
  return face;
}

void renumber_faces(Shape& shape) {
  std::vector<std::int32_t> used = shape.face_of_triangle;
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  for (std::int32_t& face : shape.face_of_triangle)
    face = static_cast<std::int32_t>(std::lower_bound(used.begin(), used.end(), face) - used.begin()) + 1;
}

Extent extent_of(const TriangleMesh& mesh) {
  Extent extent;
  if (mesh.positions.empty()) return extent;
  extent.low = extent.high = mesh.positions.front();
  for (const Eigen::Vector3d& position : mesh.positions) {
    extent.low = extent.low.cwiseMin(position);
    extent.high = extent.high.cwiseMax(position);
  }
  extent.centre = (extent.low + extent.high) / 2;
  extent.radius = (extent.high - extent.low).norm() / 2;
  return extent;
}

}  // namespace meshmser::scanner
