#include "stages/load/pose.hpp"

#include <fmt/format.h>

#include <cmath>

namespace meshmser {

Eigen::Isometry3d pose_from_numbers(std::span<const double> numbers, std::string& problem) {
  constexpr double kTolerance = 1e-2;
  problem.clear();
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  if (numbers.empty()) return pose;
  if (numbers.size() == 7) {
    const Eigen::Quaterniond turn(numbers[6], numbers[3], numbers[4], numbers[5]);
    if (!(std::abs(turn.norm() - 1) < kTolerance)) {
      problem = fmt::format(
          "the quaternion of a pose has length {:.4g}; expected x y z qx qy qz qw with a quaternion of length 1",
          turn.norm());
      return pose;
    }
    pose.linear() = turn.normalized().toRotationMatrix();
    pose.translation() = Eigen::Vector3d(numbers[0], numbers[1], numbers[2]);
    return pose;
  }
  if (numbers.size() != 16) {
    problem = fmt::format("a pose has {} numbers; expected 16 (a 4 x 4 matrix, row by row) or 7 (x y z qx qy qz qw)",
                          numbers.size());
    return pose;
  }
  const Eigen::Matrix4d matrix = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers.data());
  const Eigen::Matrix3d turn = matrix.topLeftCorner<3, 3>();
  if (matrix.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
    problem =
        "the last row of a pose is not 0 0 0 1; expected a 4 x 4 matrix row by row, the translation in its last column";
  } else if (!((turn * turn.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < kTolerance)) {
    problem = "a pose scales or shears; expected a rotation and a translation";
  } else if (turn.determinant() < 0) {
    problem = "a pose mirrors; expected a rotation and a translation";
  }
  if (!problem.empty() || matrix.isIdentity(0)) return pose;
  // A turn by whole right angles stays as exact as it was given.
  const bool exact = turn.unaryExpr([](double v) { return v == std::round(v) ? 0.0 : 1.0; }).isZero(0);
  pose.linear() = exact ? turn : Eigen::Quaterniond(turn).normalized().toRotationMatrix();
  pose.translation() = matrix.topRightCorner<3, 1>();
  return pose;
}

}  // namespace meshmser
