#pragma once
/// Results as files that other programs read. All coordinates are in the frame of the raw scan: the origin is added
/// back. Numbers in text are the shortest that read back as the same double. Every writer throws CacheError when the
/// disk fails, takes time in proportion to its output and gives the same bytes on every run.

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "pipeline/artifacts/border_set.hpp"
#include "pipeline/artifacts/level_set_trees.hpp"
#include "pipeline/artifacts/point_cloud.hpp"
#include "pipeline/artifacts/point_normals.hpp"
#include "pipeline/artifacts/scalar_fields.hpp"
#include "pipeline/artifacts/segmentation.hpp"
#include "pipeline/artifacts/triangle_mesh.hpp"

namespace meshmser {

/// The label that most triangles around each vertex bear (#V); ties to the smallest label but background, which loses
/// against any; -1 for a vertex without triangles. O(F log F).
std::vector<std::int32_t> label_of_vertices(const TriangleMesh& mesh, std::span<const std::int32_t> label_of_triangle);

/// As label_of_vertices, for the points of a cloud that the mesh's vertices came from (#P).
std::vector<std::int32_t> label_of_points(std::size_t num_points, const TriangleMesh& mesh,
                                          std::span<const std::int32_t> label_of_triangle);

/// What points.ply holds besides positions; null or empty: left out.
struct PointColumns {
  const PointNormals* normals = nullptr;
  std::vector<std::pair<std::string, const ScalarField*>> scalars;  ///< names in the file, fields of #P
  std::span<const std::int32_t> labels;                             ///< #P
};

/// Writes every raw point in raw order as binary PLY: x y z (float if that loses nothing, else double), nx ny nz, the
/// scalars (float), label (int), then the file's own properties in their own types; a property whose name is taken gets
/// `file_` in front. A raw point that was dropped as a duplicate bears what the point that stands for it does; of other
/// dropped points everything but the position is NaN (0 in whole-number properties) and the label -1.
void write_points_ply(const std::filesystem::path& path, const PointCloud& points, const PointColumns& columns);

/// What segments.ply holds besides the mesh; empty: left out.
struct SegmentColumns {
  std::span<const std::int32_t> labels;  ///< #F: face `label`, and colours of faces and vertices
  std::span<const double> quality;       ///< #V: vertex `quality`, the scalar
};

/// Writes the mesh as binary PLY: x y z (as in points.ply), nx ny nz, red green blue, quality; faces with label, red
/// green blue. Colours are those of the pictures: distinct for neighbours, background grey.
void write_segments_ply(const std::filesystem::path& path, const TriangleMesh& mesh, const SegmentColumns& columns);

/// Writes one row a region with the columns that README.md lists. The label is the region's number before splitting and
/// growing; parent: label of the region around it, -1: none. `origin` is added to places.
void write_regions_csv(const std::filesystem::path& path, const Segmentation& segmentation,
                       const Eigen::Vector3d& origin);

/// Writes one row a final label but background: `label,region,triangles,area`.
void write_labels_csv(const std::filesystem::path& path, const Segmentation& segmentation);

/// Writes one row a node, upper tree first: `polarity,node,parent,level,high_level,value,high_value,area,region`.
/// Values are of S (not of -S) at the levels; region: number of the region that the node is, 0: none (`segmentation`
/// may be null).
void write_tree_csv(const std::filesystem::path& path, const LevelSetTrees& trees, const Segmentation* segmentation);

/// Writes one row an edge: `region,loop,edge,x0,y0,z0,x1,y1,z1,kind,neighbour`; loop: from 0 through the file; edge:
/// from 0 in its loop; kind: level or hole; neighbour: number behind the edge, 0 background, -1 hole.
void write_borders_csv(const std::filesystem::path& path, const TriangleMesh& mesh, const BorderLoops& loops);

/// Writes each loop as a closed polyline (`v`, `l`) of Wavefront OBJ, grouped by region (`g region_N`).
void write_borders_obj(const std::filesystem::path& path, const TriangleMesh& mesh, const BorderLoops& loops);

/// Writes each curve as a closed polyline of Wavefront OBJ, grouped by the owner of its loop.
void write_curves_obj(const std::filesystem::path& path, const Eigen::Vector3d& origin, const BorderCurves& curves,
                      std::span<const std::int32_t> owner_of_curve);

}  // namespace meshmser
