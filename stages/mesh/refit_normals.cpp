#include "stages/mesh/refit_normals.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "stages/common/parallel.hpp"
#include "stages/mesh/point_blocks.hpp"

namespace meshmser {
namespace {

using Eigen::Vector3d;

/// Points of a plane that gives a normal, itself included; the least that may.
constexpr std::size_t kPlanePoints = 13, kLeastPlanePoints = 5;
/// Least cosine between a plane's normal and the point's given one; beyond 70 degrees its side would be a guess.
constexpr double kLeastPlaneCosine = 0.34;

std::size_t at(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

}  // namespace

std::vector<Vector3d> refit_normals(const std::vector<Vector3d>& positions, const std::vector<Vector3d>& normals,
                                    double spacing, double max_edge, const Execution& execution) {
  execution.report("sort points into blocks", 0, 0);
  const PointBlocks blocks(positions, block_size(spacing, max_edge));
  std::vector<Vector3d> refitted = normals;
  parallel_chunks(blocks.num_blocks(), 256, "refit normals", execution, [&](std::int64_t begin, std::int64_t end) {
    std::vector<std::int32_t> around;
    std::vector<std::pair<double, std::int32_t>> nearest;
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
    for (std::int64_t block = begin; block < end; ++block) {
      around.clear();
      blocks.gather(block, 1, around);
      for (const std::int32_t* p = blocks.begin(block); p != blocks.end(block); ++p) {
        const Vector3d &centre = positions[at(*p)], &given = normals[at(*p)];
        if (given.isZero(0)) continue;
        nearest.clear();
        for (const std::int32_t q : around) {
          const double squared = (positions[at(q)] - centre).squaredNorm();
          if (squared <= blocks.size() * blocks.size() && normals[at(q)].dot(given) >= 0)
            nearest.emplace_back(squared, q);
        }
        if (nearest.size() < kLeastPlanePoints) continue;
        if (nearest.size() > kPlanePoints) {
          std::nth_element(nearest.begin(), nearest.begin() + kPlanePoints, nearest.end());
          nearest.resize(kPlanePoints);
          std::sort(nearest.begin(), nearest.end());  // the order in which sums are taken
        }
        Vector3d mean = Vector3d::Zero();
        for (const auto& [squared, q] : nearest) mean += positions[at(q)] - centre;
        mean /= static_cast<double>(nearest.size());
        Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
        for (const auto& [squared, q] : nearest) {
          const Vector3d d = positions[at(q)] - centre - mean;
          covariance += d * d.transpose();
        }
        solver.computeDirect(covariance);
        const Vector3d normal = solver.eigenvectors().col(0);
        const double cosine = normal.dot(given);
        if (std::abs(cosine) >= kLeastPlaneCosine) refitted[at(*p)] = cosine > 0 ? normal : Vector3d(-normal);
      }
    }
  });
  return refitted;
}

}  // namespace meshmser
