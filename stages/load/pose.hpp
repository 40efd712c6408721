#pragma once
#include <Eigen/Geometry>
#include <span>
#include <string>

namespace meshmser {

/// A rigid motion from what a configuration says: 16 numbers, a 4 x 4 matrix row by row; 7, a translation x y z and a
/// quaternion x y z w of length 1 (to 1 %); none, no motion. Rotations are made exactly orthonormal.
/// On failure `problem` says what is wrong and what was expected, and the result is no motion; else it is empty.
Eigen::Isometry3d pose_from_numbers(std::span<const double> numbers, std::string& problem);

}  // namespace meshmser
