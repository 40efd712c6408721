#pragma once
/// Small random meshes with every trap: several components, holes, pinched vertices, ties and plateaus.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace meshmser::testing {

struct RandomMesh {
  std::vector<Eigen::Vector3d> positions;
  std::vector<std::array<std::int32_t, 3>> triangles;  ///< each edge in at most two triangles, in opposite directions
  std::vector<double> values;                          ///< per vertex; few distinct ones
};

/// The same mesh for the same seed: one to three sheets, closed pillows or single triangles, some triangles taken out,
/// some vertices glued into bow ties, ids shuffled, coordinates on a small grid so that areas tie and some are zero.
RandomMesh random_mesh(std::uint32_t seed);

}  // namespace meshmser::testing
