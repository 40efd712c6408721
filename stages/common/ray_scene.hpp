#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>

namespace meshmser {

/// Triangles to shoot rays at. Thread-safe once made. Positions are held in single precision relative to the centre of
/// their bounding box; hits carry the triangle and barycentric coordinates, from which the caller gets the exact point.
class RayScene {
 public:
  struct Hit {
    std::int32_t triangle = -1;                                 ///< -1: nothing hit
    double distance = std::numeric_limits<double>::infinity();  ///< in lengths of the ray's direction
    double u = 0, v = 0;                                        ///< weights of corners 1 and 2
  };

  /// `positions`: #V; `triangles`: #F. Built by one thread so that the same input always gives the same answers at
  /// shared edges. O(F log F).
  RayScene(std::span<const Eigen::Vector3d> positions, std::span<const std::array<std::int32_t, 3>> triangles);
  ~RayScene();
  RayScene(const RayScene&) = delete;
  RayScene& operator=(const RayScene&) = delete;

  /// The first triangle, seen from either side, that the ray meets between the distances.
  Hit intersect(const Eigen::Vector3d& from, const Eigen::Vector3d& direction, double nearest = 0,
                double farthest = std::numeric_limits<double>::infinity()) const;
  /// Whether the ray meets any triangle between the distances.
  bool occluded(const Eigen::Vector3d& from, const Eigen::Vector3d& direction, double nearest, double farthest) const;

 private:
  struct Handles;
  std::unique_ptr<Handles> handles_;
  Eigen::Vector3d centre_;
};

}  // namespace meshmser
