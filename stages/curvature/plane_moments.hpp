#pragma once
#include <cstdint>

#include "stages/common/cell_grid.hpp"
#include "stages/common/least_eigen.hpp"
#include "stages/curvature/block_normals.hpp"

namespace meshmser {

/// Sums over the neighbours of one point, relative to it: how many, their offsets, the products of their offsets.
struct PlaneMoments {
  double count = 0;
  double x = 0, y = 0, z = 0;
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;

  Eigen::Vector3d centroid() const { return Eigen::Vector3d(x, y, z) / count; }
  SymmetricMatrix3 covariance() const {
    const double mx = x / count, my = y / count, mz = z / count;
    return {xx / count - mx * mx, xy / count - mx * my, xz / count - mx * mz,
            yy / count - my * my, yz / count - my * mz, zz / count - mz * mz};
  }
};

/// Moments for each of the block's own points over the candidates within `radius` whose normals are at most 120 degrees
/// from the point's own. `moments` gets own_end - own_begin entries.
void plane_moments(const CellBlock& block, const BlockNormals& normals, double radius,
                   std::vector<PlaneMoments>& moments);
/// The same for any normals.
void plane_moments(const CellBlock& block, double radius, std::vector<PlaneMoments>& moments);

}  // namespace meshmser
