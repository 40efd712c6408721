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
/// Least cosine between a plane's normal and the side it is put on; beyond 70 degrees its side would be a guess.
constexpr double kLeastPlaneCosine = 0.34;
/// Least length of the mean of the neighbours' normals that may overrule a point's own: they agree within some 60
/// degrees.
constexpr double kLeastAgreement = 0.5;

std::size_t at(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

/// What one thread needs to refit normals.
class Refitter {
 public:
  Refitter(const std::vector<Vector3d>& positions, const std::vector<Vector3d>& normals, const PointBlocks& blocks)
      : positions_(positions), normals_(normals), squared_reach_(blocks.size() * blocks.size()) {}

  std::vector<std::int32_t>& around() { return around_; }

  /// The new normal of p, from the points around.
  Vector3d refit(std::int32_t p) {
    const Vector3d& given = normals_[at(p)];
    near_.clear();
    for (const std::int32_t q : around_) {
      const double squared = (positions_[at(q)] - positions_[at(p)]).squaredNorm();
      if (squared <= squared_reach_) near_.emplace_back(squared, q);
    }
    if (near_.size() < kLeastPlanePoints) return given;
    keep_nearest();

    // A point on the wrong side of all its neighbours is where normals were measured across a sharp edge.
    Vector3d side = Vector3d::Zero();
    for (const auto& [squared, q] : near_) side += q == p ? Vector3d::Zero() : normals_[at(q)];
    const bool overruled =
        !(side.dot(given) > 0) && side.norm() >= kLeastAgreement * static_cast<double>(near_.size() - 1);
    side = overruled ? side.normalized() : given;
    if (side.isZero(0)) return given;

    const auto opposes = [&](const Neighbour& neighbour) {
      return neighbour.second != p && normals_[at(neighbour.second)].dot(side) < 0;
    };
    if (std::any_of(near_.begin(), near_.end(), opposes)) {
      near_.clear();
      for (const std::int32_t q : around_) {
        const Neighbour neighbour((positions_[at(q)] - positions_[at(p)]).squaredNorm(), q);
        if (neighbour.first <= squared_reach_ && !opposes(neighbour)) near_.push_back(neighbour);
      }
      if (near_.size() < kLeastPlanePoints) return side;
      keep_nearest();
    }
    const Vector3d normal = plane_normal(p);
    const double cosine = normal.dot(side);
    if (std::abs(cosine) < kLeastPlaneCosine) return side;
    return cosine > 0 ? normal : Vector3d(-normal);
  }

 private:
  using Neighbour = std::pair<double, std::int32_t>;

  void keep_nearest() {
    if (near_.size() > kPlanePoints) {
      std::nth_element(near_.begin(), near_.begin() + kPlanePoints, near_.end());
      near_.resize(kPlanePoints);
    }
    std::sort(near_.begin(), near_.end());  // the order in which sums are taken
  }
  Vector3d plane_normal(std::int32_t p) {
    const Vector3d& centre = positions_[at(p)];
    Vector3d mean = Vector3d::Zero();
    for (const auto& [squared, q] : near_) mean += positions_[at(q)] - centre;
    mean /= static_cast<double>(near_.size());
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (const auto& [squared, q] : near_) {
      const Vector3d d = positions_[at(q)] - centre - mean;
      covariance += d * d.transpose();
    }
    solver_.computeDirect(covariance);
    return solver_.eigenvectors().col(0);
  }

  const std::vector<Vector3d>& positions_;
  const std::vector<Vector3d>& normals_;
  double squared_reach_;
  std::vector<std::int32_t> around_;
  std::vector<Neighbour> near_;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver_;
};

}  // namespace

std::vector<Vector3d> refit_normals(const std::vector<Vector3d>& positions, const std::vector<Vector3d>& normals,
                                    double spacing, double max_edge, const Execution& execution) {
  execution.report("sort points into blocks", 0, 0);
  const PointBlocks blocks(positions, block_size(spacing, max_edge));
  std::vector<Vector3d> refitted(normals.size());
  parallel_chunks(blocks.num_blocks(), 256, "refit normals", execution, [&](std::int64_t begin, std::int64_t end) {
    Refitter refitter(positions, normals, blocks);
    for (std::int64_t block = begin; block < end; ++block) {
      refitter.around().clear();
      blocks.gather(block, 1, refitter.around());
      for (const std::int32_t* p = blocks.begin(block); p != blocks.end(block); ++p)
        refitted[at(*p)] = refitter.refit(*p);
    }
  });
  return refitted;
}

}  // namespace meshmser
