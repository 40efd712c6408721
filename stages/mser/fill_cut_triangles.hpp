#pragma once
/// Borders on their level line instead of inside it.

#include <cstdint>
#include <span>
#include <vector>

#include "stages/common/surface.hpp"

namespace meshmser {

/// The level line of a label's region: the values of S from `value` on, or down from it.
struct LabelLevel {
  double value = 0;
  bool is_upper = true;
};

/// A region holds the triangles all of whose corners reach its level, so its border lies inside the level line, by half
/// a spacing on average. Here each unlabelled triangle whose *mean* of S (`triangle_values`, #F) reaches the level of a
/// label beyond one of its edges joins that label (of several, the one with the longest common edges, then the
/// smallest); three rounds, each from the labels of the one before. `labels`: #F, 0 is none; `level_of_label`: #L + 1;
/// triangles with excluded[t] != 0 (#F or empty) stay out. O(F).
std::vector<std::int32_t> fill_cut_triangles(const SurfaceView& surface, std::span<const std::int32_t> labels,
                                             std::span<const LabelLevel> level_of_label,
                                             std::span<const double> triangle_values,
                                             std::span<const std::uint8_t> excluded = {});

}  // namespace meshmser
