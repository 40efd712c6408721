#include "data/scanner/glyphs.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace meshmser::scanner {
namespace {

Glyph polyline(const std::vector<Eigen::Vector2d>& points) {
  Glyph strokes;
  for (std::size_t i = 1; i < points.size(); ++i) strokes.emplace_back(points[i - 1], points[i]);
  return strokes;
}

Glyph ring(double radius) {
  std::vector<Eigen::Vector2d> points;
  constexpr int kPieces = 96;
  for (int i = 0; i <= kPieces; ++i) {
    const double angle = 2 * std::numbers::pi * i / kPieces;
    points.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
  }
  return polyline(points);
}

Glyph wave() {
  std::vector<Eigen::Vector2d> points;
  constexpr int kPieces = 64;
  for (int i = 0; i <= kPieces; ++i) {
    const double x = -0.42 + 0.84 * i / kPieces;
    points.emplace_back(x, 0.18 * std::sin(x / 0.42 * 2 * std::numbers::pi));
  }
  return polyline(points);
}

}  // namespace

const std::vector<Glyph>& glyphs() {
  static const std::vector<Glyph> all = {
      {{{0, 0.4}, {0, -0.4}}, {{-0.35, 0.15}, {0.35, 0.15}}, {{-0.25, -0.4}, {0.25, -0.33}}},
      {{{-0.3, 0.4}, {-0.3, -0.4}}, {{-0.3, 0}, {0.32, 0.32}}, {{-0.3, 0}, {0.32, -0.34}}},
      polyline({{-0.36, -0.32}, {0.36, -0.32}, {0, 0.38}, {-0.36, -0.32}}),
      ring(0.35),
      {{{-0.34, -0.34}, {0.34, 0.34}}, {{-0.34, 0.34}, {0.34, -0.34}}},
      {{{0, -0.4}, {0, 0.4}}, {{0, 0.4}, {-0.26, 0.1}}, {{0, 0.4}, {0.26, 0.1}}},
      polyline({{0, -0.4}, {0.3, 0}, {0, 0.4}, {-0.3, 0}, {0, -0.4}}),
      wave()};
  return all;
}

double distance_to_glyph(const Glyph& glyph, const Eigen::Vector2d& point) {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [from, to] : glyph) {
    const Eigen::Vector2d along = to - from;
    const double share = std::clamp((point - from).dot(along) / along.squaredNorm(), 0.0, 1.0);
    least = std::min(least, (from + along * share - point).norm());
  }
  return least;
}

}  // namespace meshmser::scanner
