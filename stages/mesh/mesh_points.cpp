#include "stages/mesh/mesh_points.hpp"

#include <Eigen/Core>
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
  if (options.method == MeshMethod::kAdvancingFront)
    triangles = oriented_manifold(std::move(triangles), &report.repair);
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
