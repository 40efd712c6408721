#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "pipeline/artifacts/property.hpp"

namespace meshmser {

/// An oriented 2-manifold with boundary (definitions 4). Half-edge 3 t + k runs from corner k to corner (k + 1) % 3 of
/// triangle t.
struct TriangleMesh {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();        ///< was subtracted from every coordinate
  double spacing = 0;                                      ///< h of definitions 1, in coordinate units
  std::vector<Eigen::Vector3d> positions;                  ///< #V, minus the origin: raw positions
  std::vector<std::array<std::int32_t, 3>> triangles;      ///< #F, counter-clockwise seen from outside
  std::vector<std::int32_t> point_of_vertex;               ///< #V: the cloud's point; several vertices may share one
  std::vector<Eigen::Vector3d> normals;                    ///< #V: agree with the triangles
  std::vector<std::uint8_t> turned_of_vertex;              ///< #V: 1 where the mesh turned the point's normal, so that odd scalars change sign
  std::vector<Property> properties;                        ///< each #V values; of a given mesh

  std::size_t num_vertices() const { return positions.size(); }
  std::size_t num_triangles() const { return triangles.size(); }

  template <class Self, class Visitor>
  static void visit(Self& self, Visitor&& field) {
    field("origin", self.origin);
    field("spacing", self.spacing);
    field("positions", self.positions);
    field("triangles", self.triangles);
    field("point_of_vertex", self.point_of_vertex);
    field("normals", self.normals);
    field("turned_of_vertex", self.turned_of_vertex);
    field("properties", self.properties);
  }
};

}  // namespace meshmser
