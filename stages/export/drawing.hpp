#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "pipeline/artifacts/triangle_mesh.hpp"
#include "stages/common/ray_scene.hpp"

namespace meshmser {

/// Twice the area of a triangle, along its normal.
Eigen::Vector3d triangle_normal(const TriangleMesh& mesh, std::int32_t triangle);

/// The side that a sheet-like mesh shows: the mean of its triangles' normals by area, walls at its rim left out; unit
/// length. Zero for a mesh that faces nowhere in particular (mean shorter than 0.5; 1 is a flat sheet, 0 a closed
/// surface).
Eigen::Vector3d facing_of_sheet(const TriangleMesh& mesh);

/// A mesh made ready for drawing. Keeps a reference to the mesh.
struct Drawing {
  const TriangleMesh& mesh;
  RayScene scene;
  std::vector<Eigen::Vector3d> normals;  ///< #V: the mesh's, smoothed; empty where it has none: triangles are flat
  double diagonal = 0;                   ///< of the bounding box
  double roughness = 0;  ///< how far above the surface ambient rays start, so that its noise does not shade it

  explicit Drawing(const TriangleMesh& given);

  /// Unit normal at a hit, on the outside of the surface.
  Eigen::Vector3d normal_at(const RayScene::Hit& hit) const;
};

}  // namespace meshmser
