#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace meshmser {

/// The points of a cloud after some scale-space steps (definitions 3).
struct SmoothedPoints {
  std::vector<Eigen::Vector3d> positions;  ///< #P, minus the cloud's origin
  double radius = 0;                       ///< of a step, in coordinate units
  std::int32_t steps = 0;

  template <class Self, class Visitor>
  static void visit(Self& self, Visitor&& field) {
    field("positions", self.positions);
    field("radius", self.radius);
    field("steps", self.steps);
  }
};

}  // namespace meshmser
