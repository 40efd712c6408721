#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/artifacts/point_cloud.hpp"
#include "pipeline/artifacts/point_normals.hpp"
#include "pipeline/artifacts/smoothed_points.hpp"
#include "pipeline/artifacts/triangle_mesh.hpp"
#include "pipeline/execution/execution.hpp"
#include "stages/mesh/close_loops.hpp"
#include "stages/mesh/local_delaunay.hpp"
#include "stages/mesh/manifold.hpp"
#include "stages/mesh/orientation_vote.hpp"

namespace meshmser {

enum class MeshMethod : std::uint8_t { kLocalDelaunay, kAdvancingFront };

struct MeshOptions {
  MeshMethod method = MeshMethod::kLocalDelaunay;
  double max_edge = 0;   ///< in coordinate units; no longer edge is made, on smoothed or on raw positions
  int close_loops = 12;  ///< loops of at most so many edges are filled where possible; below 3: none
};

/// What came of the points, for the user and for tests.
struct MeshReport {
  std::int64_t too_long = 0;        ///< triangles left out because an edge between raw points is longer than max_edge
  std::int64_t between_sheets = 0;  ///< triangles of advancing front taken out where they join two sheets of a wall
  ManifoldRepair repair;            ///< of advancing front
  LocalDelaunayCounts votes;        ///< of local Delaunay
  LoopCounts loops;
  std::int64_t unused_points = 0;
  std::int64_t split_vertices = 0;
  OrientationReport orientation;
  std::int64_t num_components = 0, num_border_loops = 0, num_border_edges = 0;
  std::int64_t euler = 0;  ///< vertices - edges + triangles
};

struct MeshedPoints {
  TriangleMesh mesh;
  MeshReport report;
};

/// An interpolating mesh of a cloud (definitions 4): triangles found on the smoothed positions, vertices at the raw
/// ones.
///
/// `normals` #P; `smoothed` #P or null (then the raw positions serve). The mesh is an oriented manifold with one fan at
/// each vertex, gaps wider than max_edge stay open, sides are those of the vote (orient_by_vote). Vertices by point id,
/// triangles sorted. Throws StageError where arrays differ in length, max_edge is not positive, or no triangle is
/// found.
MeshedPoints mesh_points(const PointCloud& cloud, const PointNormals& normals, const SmoothedPoints* smoothed,
                         const MeshOptions& options, const Execution& execution = {});

}  // namespace meshmser
