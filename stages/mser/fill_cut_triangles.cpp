#include "stages/mser/fill_cut_triangles.hpp"

#include <Eigen/Core>
#include <array>

namespace meshmser {

std::vector<std::int32_t> fill_cut_triangles(const SurfaceView& surface, std::span<const std::int32_t> labels,
                                             std::span<const LabelLevel> level_of_label,
                                             std::span<const double> triangle_values,
                                             std::span<const std::uint8_t> excluded) {
  // A cut triangle with one corner in the region meets it across another cut one.
  constexpr int kRounds = 3;
  std::vector<std::int32_t> result(labels.begin(), labels.end());
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<std::int32_t> before = result;
    for (std::size_t t = 0; t < before.size(); ++t) {
      if (before[t] != 0 || (!excluded.empty() && excluded[t] != 0)) continue;
      std::array<std::int32_t, 3> label{};
      std::array<double, 3> length{};
      for (std::size_t k = 0; k < 3; ++k) {
        const std::int32_t twin = surface.twins[3 * t + k];
        if (twin < 0) continue;
        const std::int32_t beyond = before[static_cast<std::size_t>(twin) / 3];
        if (beyond == 0) continue;
        const LabelLevel& level = level_of_label[static_cast<std::size_t>(beyond)];
        if (level.is_upper ? triangle_values[t] < level.value : triangle_values[t] > level.value) continue;
        const auto corner = [&](std::size_t i) -> const Eigen::Vector3d& {
          return surface.positions[static_cast<std::size_t>(surface.triangles[t][i % 3])];
        };
        std::size_t slot = 0;
        while (label[slot] != 0 && label[slot] != beyond) ++slot;
        label[slot] = beyond;
        length[slot] += (corner(k + 1) - corner(k)).norm();
      }
      std::size_t best = 0;
      for (std::size_t i = 1; i < 3; ++i)
        if (label[i] != 0 && (length[i] > length[best] || (length[i] == length[best] && label[i] < label[best])))
          best = i;
      result[t] = label[best];
    }
  }
  return result;
}

}  // namespace meshmser
