#pragma once
/// Surfaces over a square grid, with what segmentation needs of them.

#include <Eigen/Core>
#include <array>
#include <functional>
#include <vector>

#include "stages/common/adjacency.hpp"
#include "stages/common/surface.hpp"

namespace meshmser {

struct HeightField {
  std::vector<Eigen::Vector3d> positions;
  std::vector<std::array<std::int32_t, 3>> triangles;
  std::vector<std::int32_t> twins;
  std::vector<double> areas;

  SurfaceView view() const { return {positions, triangles, twins}; }
  Eigen::Vector3d centroid(std::size_t t) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const std::int32_t v : triangles[t]) sum += positions[static_cast<std::size_t>(v)];
    return sum / 3;
  }
  /// A number for each triangle from its centroid.
  std::vector<std::int32_t> numbers(const std::function<std::int32_t(const Eigen::Vector3d&)>& of) const {
    std::vector<std::int32_t> result;
    for (std::size_t t = 0; t < triangles.size(); ++t) result.push_back(of(centroid(t)));
    return result;
  }
  std::vector<double> values(const std::function<double(const Eigen::Vector3d&)>& of) const {
    std::vector<double> result;
    for (const Eigen::Vector3d& p : positions) result.push_back(of(p));
    return result;
  }
};

/// columns x rows unit squares, two triangles each: those of the square at (i, j) are 2 (j columns + i) and the next.
inline HeightField make_height_field(
    std::int32_t columns, std::int32_t rows,
    const std::function<double(double, double)>& height = [](double, double) { return 0.0; }) {
  HeightField field;
  for (std::int32_t j = 0; j <= rows; ++j)
    for (std::int32_t i = 0; i <= columns; ++i) field.positions.emplace_back(i, j, height(i, j));
  for (std::int32_t j = 0; j < rows; ++j)
    for (std::int32_t i = 0; i < columns; ++i) {
      const std::int32_t a = j * (columns + 1) + i, b = a + 1, c = b + columns + 1, d = c - 1;
      field.triangles.push_back({a, b, c});
      field.triangles.push_back({a, c, d});
    }
  field.twins = twin_half_edges(field.triangles, field.positions.size());
  field.areas = triangle_areas(field.positions, field.triangles);
  return field;
}

}  // namespace meshmser
