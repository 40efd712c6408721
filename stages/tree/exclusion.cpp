#include "stages/tree/exclusion.hpp"

#include <cmath>

#include "stages/tree/rims.hpp"

namespace meshmser {

Exclusion exclude_triangles(std::span<const Eigen::Vector3d> positions,
                            std::span<const std::array<std::int32_t, 3>> triangles, std::span<const std::int32_t> twins,
                            std::span<const double> values, double rim_distance, double min_rim,
                            std::span<const std::uint8_t> fallen, const Execution& execution) {
  Exclusion result;
  std::vector<std::uint8_t> near(positions.size(), 0);
  if (rim_distance > 0) {
    LongRims rims = find_long_rims(positions, triangles, twins, min_rim);
    result.num_rims = rims.num_rims;
    if (!fallen.empty()) {
      // Of what has fallen its border is enough: the rest is excluded by itself.
      std::vector<std::uint8_t> at_border(positions.size(), 0);
      for (const auto& corners : triangles) {
        int num_fallen = 0;
        for (const std::int32_t corner : corners) num_fallen += fallen[static_cast<std::size_t>(corner)];
        if (num_fallen == 1 || num_fallen == 2)
          for (const std::int32_t corner : corners) at_border[static_cast<std::size_t>(corner)] = 1;
      }
      for (std::size_t v = 0; v < positions.size(); ++v)
        if (fallen[v] != 0 && at_border[v] != 0) rims.segments.emplace_back(positions[v], positions[v]);
    }
    near = points_near(positions, rims.segments, rim_distance, execution);
    for (std::size_t v = 0; v < fallen.size(); ++v) near[v] |= fallen[v];
  }
  result.excluded_of_triangle.assign(triangles.size(), 0);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    bool nan = false, rim = false;
    for (const std::int32_t corner : triangles[t]) {
      nan |= !std::isfinite(values[static_cast<std::size_t>(corner)]);
      rim |= near[static_cast<std::size_t>(corner)] != 0;
    }
    result.excluded_of_triangle[t] = nan || rim;
    result.num_nan += nan;
    result.num_near_rim += !nan && rim;
  }
  return result;
}

}  // namespace meshmser
