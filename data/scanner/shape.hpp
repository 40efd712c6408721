#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "pipeline/artifacts/triangle_mesh.hpp"

namespace meshmser::scanner {

/// An exact mesh with the true face of every triangle. Closed and outward unless its maker says otherwise.
struct Shape {
  TriangleMesh mesh;
  std::vector<std::int32_t> face_of_triangle;  ///< #F, from 1: the plane, cylinder, groove ... it is a part of
};

/// A point on a true edge: where two faces meet.
struct EdgeSample {
  Eigen::Vector3d position;  ///< minus the mesh's origin
  double angle;              ///< by which the surface turns there, in degrees; 0: the faces meet smoothly
};

/// Points at most `step` apart along every mesh edge between two different faces, at the middles of equal pieces. Edges
/// at an open rim are none. Order: by the edge's vertices. O(F log F).
std::vector<EdgeSample> true_edges(const Shape& shape, double step);

/// Faces of a mesh that brings none: triangles joined over edges at which the surface turns by less than `angle`
/// degrees, numbered from 1 by smallest triangle. Vertices with equal positions count as one. O(F log F).
std::vector<std::int32_t> faces_by_angle(const TriangleMesh& mesh, double angle);

/// Numbers the faces 1, 2 ... without gaps, in the order of the numbers they had.
void renumber_faces(Shape& shape);

/// Half the length of the diagonal of the bounding box, and its middle.
struct Extent {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero(), low = Eigen::Vector3d::Zero(), high = Eigen::Vector3d::Zero();
  double radius = 0;
};
Extent extent_of(const TriangleMesh& mesh);

}  // namespace meshmser::scanner
