#pragma once
/// The faces of a file as an oriented 2-manifold with boundary.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "pipeline/artifacts/point_cloud.hpp"
#include "pipeline/artifacts/point_normals.hpp"
#include "pipeline/artifacts/triangle_mesh.hpp"

namespace meshmser {

/// What to do about edges of three or more triangles and about neighbours that disagree which side is out.
enum class MeshRepair {
  kNone,   ///< they are errors
  kSplit,  ///< turn triangles where that helps, then cut the mesh along what remains
  kDrop,   ///< turn triangles where that helps, then drop all but the two largest at an edge
};
enum class MergeVertices {
  kAuto,  ///< as kYes where a file has loose facets (STL), else kNo
  kNo,
  kYes
};

/// Faces by raw vertex: vertices count through all files in order, as raw points do.
struct RawFaces {
  std::vector<std::int64_t> first_corner_of_face;  ///< #F + 1
  std::vector<std::int64_t> corners;
  std::vector<std::int64_t> first_face_of_file;  ///< with the name of each file, for messages
  std::vector<std::string> file_names;
};

struct GivenMeshReport {
  std::int64_t num_polygons_cut = 0;         ///< faces of more than three corners
  std::int64_t num_degenerate = 0;           ///< triangles that name a vertex twice: dropped
  std::int64_t num_cropped = 0;              ///< triangles with a vertex outside the crop box: dropped
  std::int64_t num_non_manifold_edges = 0;   ///< found, then repaired
  std::int64_t num_inconsistent_edges = 0;   ///< found, then repaired
  std::int64_t num_turned = 0;               ///< triangles turned by the repair
  std::int64_t num_dropped = 0;              ///< triangles dropped by the repair
  std::int64_t num_split_vertices = 0;       ///< vertices added where fans met at one vertex
  std::int64_t num_unused_vertices = 0;      ///< points without a triangle
  std::int64_t num_coincident_vertices = 0;  ///< vertices at the place of another that were not merged
  std::int64_t num_inside_out = 0;           ///< closed components of negative volume
};

struct GivenMesh {
  TriangleMesh mesh;
  PointNormals normals;
  GivenMeshReport report;
};

/// Makes the mesh of `cloud`, whose points are the files' vertices. Vertices are in the order of their points, then raw
/// index; vertices without triangles are left out. Polygons are cut into triangles by ears, in the plane of their
/// Newell normal; triangles keep the order of the file. Each vertex gets one fan of triangles: vertices where several
/// meet are split. Vertex normals are the triangles' weighted by their angle (Thuermer and Wuethrich 1998).
/// `raw_properties` have one value for each raw vertex; the mesh's properties are taken from there.
/// Throws InputError naming the first ten non-manifold or inconsistent edges unless `repair` says otherwise, and faces
/// with non-finite vertices. O(n log n), one thread.
GivenMesh build_given_mesh(const RawFaces& faces, const PointCloud& cloud, const std::vector<Property>& raw_properties,
                           MeshRepair repair, bool merge_vertices);

}  // namespace meshmser
