#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace meshmser {

/// A symmetric 3 by 3 matrix, as covariances come.
struct SymmetricMatrix3 {
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
};

/// The least eigenvalue with its unit eigenvector; zero vector where the two least eigenvalues coincide, so that no
/// plane is defined (points on a line, fewer than three points).
struct LeastEigen {
  double value = 0;
  Eigen::Vector3d vector = Eigen::Vector3d::Zero();
  bool is_plane() const { return vector != Eigen::Vector3d::Zero(); }
};

/// Least eigenpair of a positive semi-definite matrix; the vector's sign is arbitrary but determined by the input.
///
/// Newton's iteration on the characteristic polynomial from 0, which lies left of all roots, so that it rises to the
/// least one without overshoot; the vector is the longest cross product of two rows of A - value I. Only + - * / and
/// sqrt are used: the library's sine and cosine differ in the last bit from processor to processor.
inline LeastEigen least_eigen(const SymmetricMatrix3& a) {
  LeastEigen result;
  const double trace = a.xx + a.yy + a.zz;
  if (!(trace > 0) || !std::isfinite(trace)) return result;
  // Scaled to trace 1: no overflow, and tolerances are plain numbers.
  const double scale = 1 / trace;
  const double xx = a.xx * scale, xy = a.xy * scale, xz = a.xz * scale;
  const double yy = a.yy * scale, yz = a.yz * scale, zz = a.zz * scale;
  const double minors = xx * yy - xy * xy + (xx * zz - xz * xz) + (yy * zz - yz * yz);
  const double determinant = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
  double value = 0;
  for (int iteration = 0; iteration < 60; ++iteration) {
    const double polynomial = ((value - 1) * value + minors) * value - determinant;
    const double slope = (3 * value - 2) * value + minors;
    if (!(slope > 0)) break;
    const double step = polynomial / slope;
    if (!(step < 0)) break;
    value -= step;
    if (-step < 1e-16) break;
  }
  const Eigen::Vector3d row0(xx - value, xy, xz), row1(xy, yy - value, yz), row2(xz, yz, zz - value);
  const Eigen::Vector3d cross01 = row0.cross(row1), cross02 = row0.cross(row2), cross12 = row1.cross(row2);
  const double n01 = cross01.squaredNorm(), n02 = cross02.squaredNorm(), n12 = cross12.squaredNorm();
  const double longest = std::max({n01, n02, n12});
  result.value = value * trace;
  // The product of the two gaps to the other eigenvalues is the length of the cross product.
  constexpr double kNoGap = 1e-10;
  if (longest <= kNoGap * kNoGap) return result;
  result.vector = (n01 == longest ? cross01 : n02 == longest ? cross02 : cross12) / std::sqrt(longest);
  return result;
}

}  // namespace meshmser
