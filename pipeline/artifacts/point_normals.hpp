#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace meshmser {

/// What decided the sign of a component's normals (definitions 2), from the most to the least trustworthy.
enum class SignSource : std::uint8_t { kGiven, kScanner, kViewpoint, kEnclosedVolume, kGuess };

/// A connected component of the neighbour graph over which normals were made consistent.
struct NormalComponent {
  std::int64_t num_points = 0;
  SignSource source = SignSource::kGuess;
  double confidence = 0;  ///< 0 .. 1: how clear the vote or the volume was
  bool flipped_by_user = false;

  template <class Self, class Visitor>
  static void visit(Self& self, Visitor&& field) {
    field("num_points", self.num_points);
    field("source", self.source);
    field("confidence", self.confidence);
    field("flipped_by_user", self.flipped_by_user);
  }
};

/// Oriented unit normals of a cloud's points.
struct PointNormals {
  std::vector<Eigen::Vector3d> normals;            ///< #P; zero: could not be oriented
  std::vector<std::int32_t> component_of_point;    ///< #P; -1: could not be oriented
  std::vector<NormalComponent> components;         ///< by decreasing size, then least point id

  template <class Self, class Visitor>
  static void visit(Self& self, Visitor&& field) {
    field("normals", self.normals);
    field("component_of_point", self.component_of_point);
    field("components", self.components);
  }
};

}  // namespace meshmser
