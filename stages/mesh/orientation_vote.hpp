#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "pipeline/artifacts/point_normals.hpp"
#include "pipeline/execution/execution.hpp"
#include "stages/mesh/triangle.hpp"

namespace meshmser {

/// What decided the outside of each mesh component, and what was turned to agree.
struct OrientationReport {
  std::int64_t by_vote = 0;            ///< components decided by normals that are not guesses
  std::int64_t by_volume = 0;          ///< closed components decided by their signed volume
  std::int64_t by_guess = 0;           ///< components decided by the guess of the normals' own stage
  std::int64_t undecided = 0;          ///< components without any normal: left as they were
  std::int64_t vertices_by_guess = 0;  ///< in the components of the two kinds above
  std::int64_t turned_vertices = 0;    ///< vertices whose normal was turned
  std::int64_t turned_components = 0;  ///< mesh components most of whose normals were turned
};

/// Turns each edge-connected component of the mesh outside out, and tells which normals had to turn (definitions 2).
///
/// `positions` #V (the smoothed ones, where there are), `triangles` an oriented manifold (turned in place), `twins` its
/// twin half-edges (a turned component's are brought up to date), `point_of_vertex` #V into `normals`. A component
/// faces the side that most of its vertices' non-guessed normals face; where they tie, or all are guesses, the side of
/// positive volume if it has no rim; else the side that most guesses face. Results: `vertex_normals` #V, the point's
/// normal, turned where it opposes the triangles around; the triangles' own where the point has none; `turned` #V, 1
/// where the point's normal was turned. A normal nearly in the surface (within 12 degrees) says nothing about sides and
/// turns if most of its component's normals turn. Linear, deterministic, one thread.
OrientationReport orient_by_vote(const std::vector<Eigen::Vector3d>& positions, std::vector<Triangle>& triangles,
                                 std::vector<std::int32_t>& twins, const std::vector<std::int32_t>& point_of_vertex,
                                 const PointNormals& normals, std::vector<Eigen::Vector3d>& vertex_normals,
                                 std::vector<std::uint8_t>& turned, const Execution& execution = {});

}  // namespace meshmser
