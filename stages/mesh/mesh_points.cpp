#include "stages/mesh/mesh_points.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "pipeline/execution/error.hpp"
#include "stages/common/adjacency.hpp"
#include "stages/common/mesh_topology.hpp"
#include "stages/mesh/advancing_front.hpp"
#include "stages/mesh/refit_normals.hpp"

namespace meshmser {
namespace {

using Eigen::Vector3d;

std::size_t at(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

// Parts the sheets of thin walls that advancing front has joined. Consistently oriented, such a component turns against
// the normals on a whole sheet: on a large part of its triangles, and in folds, unlike at a patch whose normals have
// the wrong sign, which orient_by_vote mends. The triangles at both sides of every edge between the two parts are taken
// out, and the others face as their normals do. Returns how many were taken out.
std::int64_t part_sheets(std::vector<Triangle>& triangles, const std::vector<Vector3d>& positions,
                         const std::vector<Vector3d>& directions, const Execution& execution) {
  constexpr double kSheet = 0.02;  // share of a component's triangles
  constexpr double kFolded = 0.9;  // mean cosine across the edges between the parts
  const std::vector<std::int32_t> twins = twin_half_edges(triangles, positions.size(), execution);
  std::vector<Vector3d> facing(triangles.size());
  std::vector<bool> agrees(triangles.size()), seen(triangles.size(), false), cut(triangles.size(), false);
  for (std::size_t f = 0; f < triangles.size(); ++f) {
    const auto [a, b, c] = triangles[f];
    facing[f] = (positions[at(b)] - positions[at(a)]).cross(positions[at(c)] - positions[at(a)]).normalized();
    agrees[f] = facing[f].dot(directions[at(a)] + directions[at(b)] + directions[at(c)]) > 0;
  }
  std::vector<std::size_t> component;
  for (std::size_t first = 0; first < triangles.size(); ++first) {
    if (seen[first]) continue;
    execution.check();
    component.assign(1, first);
    seen[first] = true;
    std::size_t num_agreeing = 0;
    for (std::size_t next = 0; next < component.size(); ++next) {
      const std::size_t f = component[next];
      num_agreeing += agrees[f];
      for (std::size_t k = 0; k < 3; ++k) {
        const std::int32_t twin = twins[3 * f + k];
        if (twin < 0 || seen[at(twin) / 3]) continue;
        seen[at(twin) / 3] = true;
        component.push_back(at(twin) / 3);
      }
    }
    const std::size_t fewer = std::min(num_agreeing, component.size() - num_agreeing);
    if (static_cast<double>(fewer) < kSheet * static_cast<double>(component.size())) continue;
    double cosines = 0, num_between = 0;
    for (const std::size_t f : component)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::int32_t twin = twins[3 * f + k];
        if (twin < 0 || agrees[at(twin) / 3] == agrees[f]) continue;
        cosines += facing[f].dot(facing[at(twin) / 3]), num_between += 1;
        cut[f] = true;
      }
    const bool sheets = cosines < kFolded * num_between;
    for (const std::size_t f : component) {
      if (!sheets) cut[f] = false;
      if (sheets && !agrees[f]) std::swap(triangles[f][1], triangles[f][2]);
    }
  }
  std::size_t kept = 0;
  for (std::size_t f = 0; f < triangles.size(); ++f)
    if (!cut[f]) triangles[kept++] = triangles[f];
  const auto num_cut = static_cast<std::int64_t>(triangles.size() - kept);
  triangles.resize(kept);
  if (num_cut > 0) sort_triangles(triangles);
  return num_cut;
}

void check_input(const PointCloud& cloud, const PointNormals& normals, const SmoothedPoints* smoothed,
                 const MeshOptions& options) {
  const std::size_t n = cloud.num_points();
  const auto differ = [&](const char* what, std::size_t m) {
    throw StageError("mesh: " + std::to_string(m) + " " + what + " do not belong to " + std::to_string(n) +
                     " points; give those computed from this cloud");
  };
  if (normals.normals.size() != n) differ("normals", normals.normals.size());
  if (normals.component_of_point.size() != n) differ("components of normals", normals.component_of_point.size());
  if (smoothed != nullptr && smoothed->positions.size() != n) differ("smoothed points", smoothed->positions.size());
  if (!(options.max_edge > 0) || !std::isfinite(options.max_edge))
    throw StageError(
        "mesh: max_edge must be positive and finite, not " + std::to_string(options.max_edge) +
        (cloud.spacing > 0 ? "" : "; the cloud's spacing is 0, so give max_edge in the unit of the coordinates"));
  const std::vector<Vector3d>& positions = smoothed != nullptr ? smoothed->positions : cloud.positions;
  for (std::size_t p = 0; p < n; ++p) {
    if (!cloud.positions[p].allFinite() || !positions[p].allFinite() || !normals.normals[p].allFinite())
      throw StageError("mesh: the position or normal of point " + std::to_string(p) + " is not finite");
  }
}

}  // namespace

MeshedPoints mesh_points(const PointCloud& cloud, const PointNormals& normals, const SmoothedPoints* smoothed,
                         const MeshOptions& options, const Execution& execution) {
  check_input(cloud, normals, smoothed, options);
  const std::vector<Vector3d>& positions = smoothed != nullptr ? smoothed->positions : cloud.positions;
  MeshedPoints result;
  MeshReport& report = result.report;

  const std::vector<Vector3d> directions =
      refit_normals(positions, normals.normals, cloud.spacing, options.max_edge, execution);
  std::vector<Triangle> triangles =
      options.method == MeshMethod::kAdvancingFront
          ? advancing_front(positions, options.max_edge, execution)
          : local_delaunay(positions, directions, cloud.spacing, options.max_edge, execution, &report.votes);
  if (smoothed != nullptr) {
    const double bound = options.max_edge * options.max_edge;
    const auto too_long = [&](std::int32_t a, std::int32_t b) {
      return (cloud.positions[at(a)] - cloud.positions[at(b)]).squaredNorm() > bound;
    };
    report.too_long = static_cast<std::int64_t>(std::erase_if(triangles, [&](const Triangle& t) {
      return too_long(t[0], t[1]) || too_long(t[1], t[2]) || too_long(t[2], t[0]);
    }));
  }
  if (options.method == MeshMethod::kAdvancingFront) {
    triangles = oriented_manifold(std::move(triangles), &report.repair);
    report.between_sheets = part_sheets(triangles, positions, directions, execution);
  }
  if (options.close_loops >= 3)
    report.loops = close_loops(triangles, positions, directions, smoothed != nullptr ? &cloud.positions : nullptr,
                               options.max_edge, options.close_loops, execution);
  if (triangles.empty())
    throw StageError("mesh: no triangle among " + std::to_string(cloud.num_points()) + " points has edges of at most " +
                     std::to_string(options.max_edge) +
                     "; raise max_edge, or check the points (are they on one line?)");

  execution.report("make the mesh", 0, 0);
  CompactMesh compact = split_pinched_vertices(triangles, cloud.num_points());
  triangles = {};
  execution.check();
  report.unused_points = compact.num_unused;
  report.split_vertices = compact.num_split;
  TriangleMesh& mesh = result.mesh;
  mesh.origin = cloud.origin;
  mesh.spacing = cloud.spacing;
  mesh.triangles = std::move(compact.triangles);
  mesh.point_of_vertex = std::move(compact.point_of_vertex);

  std::vector<Vector3d> vertex_positions;
  vertex_positions.reserve(mesh.point_of_vertex.size());
  for (const std::int32_t p : mesh.point_of_vertex) vertex_positions.push_back(positions[at(p)]);
  std::vector<std::int32_t> twins = twin_half_edges(mesh.triangles, vertex_positions.size(), execution);
  report.orientation = orient_by_vote(vertex_positions, mesh.triangles, twins, mesh.point_of_vertex, normals,
                                      mesh.normals, mesh.turned_of_vertex, execution);
  for (std::size_t v = 0; v < vertex_positions.size(); ++v)
    vertex_positions[v] = cloud.positions[at(mesh.point_of_vertex[v])];
  mesh.positions = std::move(vertex_positions);

  execution.report("check the mesh", 0, 0);
  const MeshTopology topology = describe_topology(mesh.triangles, mesh.num_vertices(), execution);
  if (!topology.defect.empty())
    throw StageError("mesh: the mesh made is not a manifold: " + topology.defect + "; this is a fault of the program");
  report.num_components = topology.num_components;
  report.num_border_loops = static_cast<std::int64_t>(topology.border_loops.size());
  report.num_border_edges = topology.num_border_edges;
  report.euler = topology.euler;
  return result;
}

}  // namespace meshmser
