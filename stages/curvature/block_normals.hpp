#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <span>
#include <vector>

#include "stages/common/cell_grid.hpp"

namespace meshmser {

/// Points whose normals are more than 120 degrees apart are not neighbours: the faces of a sharp rib stay neighbours,
/// the sheets of a thin wall do not.
inline constexpr double kOpposedCosine = -0.5;

/// Normals of a block's candidates, padded like it; zero where unknown (neighbour of everything).
struct BlockNormals {
  std::vector<double> x, y, z;

  /// Gathers the normals of the block's candidates. False where no two of them can oppose, so that the test for it can
  /// be left out: all lie within 60 degrees of one direction.
  bool gather(const CellBlock& block, std::span<const Eigen::Vector3d> normals) {
    const auto padded = static_cast<std::size_t>(block.padded);
    if (x.size() < padded) x.resize(2 * padded), y.resize(2 * padded), z.resize(2 * padded);
    const Eigen::Vector3d own = normals[static_cast<std::size_t>(block.ids[static_cast<std::size_t>(block.own_begin)])];
    double least = 1;
    for (std::size_t i = 0; i < padded; ++i) {
      const Eigen::Vector3d& n = normals[static_cast<std::size_t>(block.ids[i])];
      x[i] = n.x(), y[i] = n.y(), z[i] = n.z();
      least = std::min(least, n.dot(own));
    }
    return least < -kOpposedCosine;
  }
};

}  // namespace meshmser
