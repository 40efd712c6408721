#pragma once
/// The triangles of a patch around a place.

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <vector>

#include "stages/common/surface.hpp"

namespace meshmser {

/// Walks from triangle to triangle without leaving a patch and a ball. Keeps its memory from walk to walk; one for each
/// thread.
class PatchWalk {
 public:
  /// Calls visit(triangle, centroid) for the triangle `first` and every other that is reached from it over edges
  /// through triangles for which belongs(triangle) holds and whose centroids are within `radius` of `place`; breadth
  /// first, so the order depends on the mesh only. The first one counts wherever its centroid lies, so that no side is
  /// empty.
  template <class Belongs, class Visit>
  void walk(const SurfaceView& surface, const Eigen::Vector3d& place, double radius, std::int32_t first,
            Belongs&& belongs, Visit&& visit) {
    met_.resize(surface.triangles.size(), 0);
    if (++round_ == 0) {
      std::fill(met_.begin(), met_.end(), 0);
      round_ = 1;
    }
    const double radius2 = radius * radius;
    front_.assign(1, first);
    met_[static_cast<std::size_t>(first)] = round_;
    for (std::size_t i = 0; i < front_.size(); ++i) {
      const std::int32_t t = front_[i];
      const auto& corners = surface.triangles[static_cast<std::size_t>(t)];
      const Eigen::Vector3d centroid = (surface.positions[static_cast<std::size_t>(corners[0])] +
                                        surface.positions[static_cast<std::size_t>(corners[1])] +
                                        surface.positions[static_cast<std::size_t>(corners[2])]) /
                                       3;
      if ((centroid - place).squaredNorm() > radius2 && i > 0) continue;
      visit(t, centroid);
      for (std::int32_t k = 0; k < 3; ++k) {
        const std::int32_t twin = surface.twins[static_cast<std::size_t>(3 * t + k)];
        if (twin < 0) continue;
        std::uint32_t& met = met_[static_cast<std::size_t>(twin / 3)];
        if (met == round_) continue;
        met = round_;
        if (belongs(twin / 3)) front_.push_back(twin / 3);
      }
    }
  }

 private:
  std::vector<std::uint32_t> met_;
  std::uint32_t round_ = 0;
  std::vector<std::int32_t> front_;
};

}  // namespace meshmser
