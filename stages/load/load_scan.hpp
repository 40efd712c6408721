#pragma once
/// From what the files hold to one cloud in canonical order, or one mesh (definitions 1 and 4).

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/artifacts/point_cloud.hpp"
#include "pipeline/artifacts/point_normals.hpp"
#include "pipeline/artifacts/triangle_mesh.hpp"
#include "pipeline/execution/execution.hpp"
#include "pipeline/formats/geometry.hpp"
#include "stages/load/given_mesh.hpp"
#include "stages/load/outliers.hpp"

namespace meshmser {

/// One scan and where it stands.
struct PosedScan {
  Geometry geometry;
  Eigen::Isometry3d world_from_file = Eigen::Isometry3d::Identity();
  std::optional<Eigen::Vector3d> scanner_position;  ///< in the file's frame; goes before the geometry's own
};

struct LoadScanOptions {
  std::optional<Eigen::AlignedBox3d> crop;  ///< in the frame of the scan; points on its faces are kept
  OutlierOptions outliers;
  MeshRepair repair = MeshRepair::kNone;
  MergeVertices merge_vertices = MergeVertices::kAuto;
  bool turn_faces = false;  ///< every face the other way round, for meshes that are inside out
  bool use_faces = true;    ///< false: the vertices of a mesh are a cloud
};

/// What was counted on the way.
struct LoadReport {
  std::int64_t num_duplicates = 0, num_non_finite = 0, num_cropped = 0, num_outliers = 0;
  std::int64_t num_skipped_lines = 0, num_empty_cells = 0;
  double float_step =
      0;  ///< distance of neighbouring floats at the largest coordinate, where every one is a float; else 0
  GivenMeshReport mesh;
};

struct LoadedScan {
  PointCloud points;
  std::optional<TriangleMesh> mesh;     ///< of files with faces
  std::optional<PointNormals> normals;  ///< of the mesh
  LoadReport report;
};

/// Puts scans into one cloud: poses applied, non-finite and cropped points, exact duplicates and outliers taken away
/// (and listed), the origin subtracted, the rest sorted by Morton code, then x, y, z, then scan; h measured. The origin
/// is zero on an axis unless coordinates are more than 16 times farther from zero than the scan is large; it is chosen
/// so that adding it back gives the very coordinates of the file. Of duplicates the one of the least scan, then least
/// property values stays: a shuffled file gives the same points. Properties that only some scans have are NaN in the
/// others. `nx ny nz` are turned with the pose. Files with faces also give a mesh (given_mesh.hpp); all or none must
/// have faces. Throws InputError when nothing is left, StageError when options contradict the data. O(n log n); the
/// result does not depend on the number of threads.
LoadedScan load_scan(std::vector<PosedScan> scans, const LoadScanOptions& options = {},
                     const Execution& execution = {});

}  // namespace meshmser
