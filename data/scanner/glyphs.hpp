#pragma once
#include <Eigen/Core>
#include <vector>

namespace meshmser::scanner {

/// A sign made of straight strokes; coordinates in units of its size, about 0, within -0.5 .. 0.5.
using Glyph = std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>>;

/// The signs of the tablet, in order: cross with foot, K, triangle, ring, saltire, arrow, rhomb, wave.
const std::vector<Glyph>& glyphs();

/// Distance from a point, in units of the sign's size, to the nearest stroke.
double distance_to_glyph(const Glyph& glyph, const Eigen::Vector2d& point);

}  // namespace meshmser::scanner
