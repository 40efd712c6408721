#include "stages/export/drawing.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <utility>

namespace meshmser {

Eigen::Vector3d triangle_normal(const TriangleMesh& mesh, std::int32_t triangle) {
  const auto& [a, b, c] = mesh.triangles[static_cast<std::size_t>(triangle)];
  const Eigen::Vector3d& corner = mesh.positions[static_cast<std::size_t>(a)];
  return (mesh.positions[static_cast<std::size_t>(b)] - corner)
      .cross(mesh.positions[static_cast<std::size_t>(c)] - corner);
}

Eigen::Vector3d facing_of_sheet(const TriangleMesh& mesh) {
  Eigen::Vector3d facing = Eigen::Vector3d::Zero();
  for (int round = 0; round < 3; ++round) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double area = 0;
    for (std::size_t t = 0; t < mesh.num_triangles(); ++t) {
      const Eigen::Vector3d normal = triangle_normal(mesh, static_cast<std::int32_t>(t));
      if (round > 0 && normal.dot(facing) < 0.6 * normal.norm()) continue;
      sum += normal;
      area += normal.norm();
    }
    if (round == 0 && sum.norm() <= 0.5 * area) return Eigen::Vector3d::Zero();
    facing = sum.normalized();
  }
  return facing;
}

Drawing::Drawing(const TriangleMesh& given) : mesh(given), scene(given.positions, given.triangles) {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const Eigen::Vector3d& position : mesh.positions) {
    low = low.cwiseMin(position);
    high = high.cwiseMax(position);
  }
  diagonal = (high - low).norm();
  if (mesh.normals.size() != mesh.num_vertices()) return;
  normals = mesh.normals;
  double edges = 0;
  for (const auto& triangle : mesh.triangles)
    edges +=
        (mesh.positions[static_cast<std::size_t>(triangle[0])] - mesh.positions[static_cast<std::size_t>(triangle[1])])
            .norm();
  roughness = std::min(edges / static_cast<double>(mesh.num_triangles()), 0.005 * diagonal);
  // Twice the mean over the neighbours: the noise of single points would hide the relief.
  for (int round = 0; round < 2; ++round) {
    std::vector<Eigen::Vector3d> sum(normals.size(), Eigen::Vector3d::Zero());
    for (const auto& triangle : mesh.triangles) {
      Eigen::Vector3d mean = Eigen::Vector3d::Zero();
      for (std::int32_t v : triangle) mean += normals[static_cast<std::size_t>(v)];
      for (std::int32_t v : triangle) sum[static_cast<std::size_t>(v)] += mean;
    }
    for (Eigen::Vector3d& normal : sum) normal.normalize();
    normals = std::move(sum);
  }
}

Eigen::Vector3d Drawing::normal_at(const RayScene::Hit& hit) const {
  if (!normals.empty()) {
    const auto& [a, b, c] = mesh.triangles[static_cast<std::size_t>(hit.triangle)];
    const Eigen::Vector3d smooth = normals[static_cast<std::size_t>(a)] * (1 - hit.u - hit.v) +
                                   normals[static_cast<std::size_t>(b)] * hit.u +
                                   normals[static_cast<std::size_t>(c)] * hit.v;
    if (smooth.squaredNorm() > 0) return smooth.normalized();
  }
  return triangle_normal(mesh, hit.triangle).normalized();
}

}  // namespace meshmser
