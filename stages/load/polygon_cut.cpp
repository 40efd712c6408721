#include "stages/load/polygon_cut.hpp"

#include <Eigen/Geometry>

namespace meshmser {
namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

bool is_ear(const std::vector<Eigen::Vector2d>& flat, const std::vector<int>& left, std::size_t i) {
  const std::size_t n = left.size();
  const int ia = left[(i + n - 1) % n], ib = left[i], ic = left[(i + 1) % n];
  const Eigen::Vector2d &a = flat[static_cast<std::size_t>(ia)], &b = flat[static_cast<std::size_t>(ib)],
                        &c = flat[static_cast<std::size_t>(ic)];
  if (cross(b - a, c - b) <= 0) return false;
  for (const int other : left) {
    if (other == ia || other == ib || other == ic) continue;
    const Eigen::Vector2d& p = flat[static_cast<std::size_t>(other)];
    if (p == a || p == b || p == c) continue;
    if (cross(b - a, p - a) >= 0 && cross(c - b, p - b) >= 0 && cross(a - c, p - c) >= 0) return false;
  }
  return true;
}

}  // namespace

std::vector<std::array<int, 3>> cut_polygon(std::span<const Eigen::Vector3d> corners) {
  const int n = static_cast<int>(corners.size());
  std::vector<std::array<int, 3>> triangles;
  std::vector<int> left;
  for (int i = 0; i < n; ++i) left.push_back(i);
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector3d &a = corners[i] - corners[0], &b = corners[(i + 1) % corners.size()] - corners[0];
    normal += a.cross(b);
  }
  std::vector<Eigen::Vector2d> flat(corners.size());
  if (normal.norm() > 0) {
    normal.normalize();
    const Eigen::Vector3d u = normal.unitOrthogonal(), v = normal.cross(u);
    for (std::size_t i = 0; i < corners.size(); ++i)
      flat[i] = {u.dot(corners[i] - corners[0]), v.dot(corners[i] - corners[0])};
  }
  while (left.size() > 3) {
    std::size_t best = 0;
    double shortest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < left.size(); ++i) {
      const std::size_t before = static_cast<std::size_t>(left[(i + left.size() - 1) % left.size()]);
      const std::size_t after = static_cast<std::size_t>(left[(i + 1) % left.size()]);
      const double length = (corners[after] - corners[before]).squaredNorm();
      if (length < shortest && is_ear(flat, left, i)) {
        shortest = length;
        best = i;
      }
    }
    const std::size_t m = left.size();
    triangles.push_back({left[(best + m - 1) % m], left[best], left[(best + 1) % m]});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(best));
  }
  triangles.push_back({left[0], left[1], left[2]});
  return triangles;
}

}  // namespace meshmser
