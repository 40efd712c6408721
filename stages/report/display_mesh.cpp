#include "stages/report/display_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace meshmser {
namespace {

using Triangle = std::array<std::int32_t, 3>;

/// For each vertex the first vertex in its cell.
std::vector<std::int32_t> first_in_cell(const std::vector<Eigen::Vector3d>& positions, double cell) {
  Eigen::Vector3d low = positions.front();
  for (const Eigen::Vector3d& p : positions) low = low.cwiseMin(p);
  struct Place {
    std::array<std::int64_t, 3> cell;
    std::int32_t vertex;
    auto operator<=>(const Place&) const = default;
  };
  std::vector<Place> places(positions.size());
  for (std::size_t v = 0; v < positions.size(); ++v) {
    const Eigen::Vector3d at = (positions[v] - low) / cell;
    places[v] = {{std::llround(std::floor(at.x())), std::llround(std::floor(at.y())), std::llround(std::floor(at.z()))},
                 static_cast<std::int32_t>(v)};
  }
  std::sort(places.begin(), places.end());
  std::vector<std::int32_t> first(positions.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    const bool same = i > 0 && places[i].cell == places[i - 1].cell;
    first[static_cast<std::size_t>(places[i].vertex)] =
        same ? first[static_cast<std::size_t>(places[i - 1].vertex)] : places[i].vertex;
  }
  return first;
}

/// Triangles with three different corners after joining, each set of corners once, by ascending triangle.
std::vector<std::int32_t> kept_triangles(const std::vector<Triangle>& triangles,
                                         const std::vector<std::int32_t>& representative) {
  struct Corners {
    Triangle sorted;
    std::int32_t triangle;
    auto operator<=>(const Corners&) const = default;
  };
  std::vector<Corners> all;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    Triangle corners;
    for (std::size_t k = 0; k < 3; ++k) corners[k] = representative[static_cast<std::size_t>(triangles[t][k])];
    std::sort(corners.begin(), corners.end());
    if (corners[0] != corners[1] && corners[1] != corners[2]) all.push_back({corners, static_cast<std::int32_t>(t)});
  }
  std::sort(all.begin(), all.end());
  std::vector<std::int32_t> kept;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (i == 0 || all[i].sorted != all[i - 1].sorted) kept.push_back(all[i].triangle);
  std::sort(kept.begin(), kept.end());
  return kept;
}

Eigen::Vector3d normal_of(const TriangleMesh& mesh, const Triangle& corners) {
  const Eigen::Vector3d& a = mesh.positions[static_cast<std::size_t>(corners[0])];
  return (mesh.positions[static_cast<std::size_t>(corners[1])] - a)
      .cross(mesh.positions[static_cast<std::size_t>(corners[2])] - a);
}

/// Whether joining vertices makes a triangle face the other way, which would be drawn as a dark speck.
bool turned_over(const TriangleMesh& mesh, std::int32_t triangle, const std::vector<std::int32_t>& representative) {
  const Triangle& full = mesh.triangles[static_cast<std::size_t>(triangle)];
  Triangle joined;
  for (std::size_t k = 0; k < 3; ++k) joined[k] = representative[static_cast<std::size_t>(full[k])];
  return normal_of(mesh, full).dot(normal_of(mesh, joined)) < 0;
}

}  // namespace

DisplayMesh display_mesh(const TriangleMesh& mesh, std::size_t max_triangles, const Execution& execution) {
  DisplayMesh display;
  std::vector<std::int32_t> representative(mesh.num_vertices());
  std::iota(representative.begin(), representative.end(), 0);
  std::vector<std::int32_t>& kept = display.triangle_of_display_triangle;
  kept.resize(mesh.num_triangles());
  std::iota(kept.begin(), kept.end(), 0);
  if (mesh.num_triangles() > max_triangles) {
    double area = 0;
    for (const Triangle& t : mesh.triangles) area += normal_of(mesh, t).norm() / 2;
    // A cell of edge c holds about c^2 of the surface and gives two triangles; walls across cells make it fewer.
    display.cell = std::sqrt(2 * area / static_cast<double>(max_triangles)) * 0.8;
    if (!(display.cell > 0)) display.cell = 1;
    do {
      execution.report("simplify for display", 0, 0);
      representative = first_in_cell(mesh.positions, display.cell);
      kept = kept_triangles(mesh.triangles, representative);
      display.cell *= 1.15;
    } while (kept.size() > max_triangles);
    display.cell /= 1.15;
  }
  std::vector<std::int32_t> display_vertex(mesh.num_vertices(), -1);
  display.triangles.reserve(kept.size());
  for (const std::int32_t t : kept) {
    Triangle corners;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t v = representative[static_cast<std::size_t>(mesh.triangles[static_cast<std::size_t>(t)][k])];
      std::int32_t& place = display_vertex[static_cast<std::size_t>(v)];
      if (place < 0) {
        place = static_cast<std::int32_t>(display.vertex_of_display_vertex.size());
        display.vertex_of_display_vertex.push_back(v);
      }
      corners[k] = place;
    }
    if (display.cell > 0 && turned_over(mesh, t, representative)) std::swap(corners[1], corners[2]);
    display.triangles.push_back(corners);
  }
  return display;
}

}  // namespace meshmser
