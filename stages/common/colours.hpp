#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/artifacts/triangle_mesh.hpp"

namespace meshmser {

/// Red, green, blue.
using Colour = std::array<std::uint8_t, 3>;

inline constexpr Colour kBackgroundLabelColour = {200, 200, 196};  ///< of label 0
inline constexpr Colour kUndefinedColour = {120, 120, 120};        ///< of NaN
inline constexpr Colour kLevelEdgeColour = {16, 16, 20};
inline constexpr Colour kHoleEdgeColour = {122, 40, 220};

/// One colour per label, distinct for labels that share an edge of the mesh, the same on every picture and page of a
/// run. `label_of_triangle`: #F, from 0. Result: index = label, [0] = kBackgroundLabelColour. Labels are coloured in
/// ascending order, each with the colour of a palette of 20 that none of its coloured neighbours bears, the least used
/// so far first; where neighbours bear all of them, with the least used. O(F log F); deterministic.
std::vector<Colour> label_colours(const TriangleMesh& mesh, std::span<const std::int32_t> label_of_triangle);

/// A colour map over a range of values, readable with any kind of colour blindness: diverging (blue, white, red about
/// 0) where the values have both signs, else sequential (pale yellow to dark red; for negative values from dark blue).
struct ColourMap {
  double low = -1, high = 1;  ///< values beyond are drawn as the nearer end

  /// Symmetric about 0 where both signs occur. The ends are the `clip` and 1 - `clip` quantiles of the finite values,
  /// so that a few outliers do not bleach the picture. No finite value: -1 .. 1.
  static ColourMap of_values(std::span<const double> values, double clip = 0.01);
  /// NaN: kUndefinedColour.
  Colour operator()(double value) const;
};

}  // namespace meshmser
