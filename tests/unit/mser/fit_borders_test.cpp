#include "stages/mser/fit_borders.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "stages/mser/grow.hpp"
#include "tests/unit/mser/height_field.hpp"

namespace meshmser {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr FitParameters kParameters{1, 8, 10 * kDegree, 3};

/// Two faces that turn by `degrees` at x = 30, convex or not, and a deterministic noise of each point's height.
HeightField roof(double degrees, bool convex, double noise) {
  std::mt19937 random(7);
  const double slope = std::tan(degrees / 2 * kDegree) * (convex ? -1 : 1);
  return make_height_field(60, 40, [&](double x, double) {
    const double uniform = static_cast<double>(random()) / 4294967296.0 - 0.5;
    return slope * std::abs(x - 30) + noise * std::sqrt(12) * uniform;
  });
}

/// Labels whose border wanders by up to `amplitude` about x = 30.
std::vector<std::int32_t> wandering(const HeightField& field, double amplitude) {
  return field.numbers(
      [&](const Eigen::Vector3d& p) { return p.x() < 30 + amplitude * std::sin(0.7 * p.y()) ? 1 : 2; });
}

/// Borders fitted, and what was cut off on the way absorbed.
std::vector<std::int32_t> settled(const HeightField& field, const std::vector<std::int32_t>& labels) {
  const auto fitted = fit_borders(field.view(), labels, field.areas, kParameters);
  return absorb_small_patches(field.view(), fitted, field.areas, 20);
}

/// Triangles farther than `distance` from x = 30 on the wrong side of it.
std::int64_t num_wrong(const HeightField& field, const std::vector<std::int32_t>& labels, double distance) {
  std::int64_t wrong = 0;
  for (std::size_t t = 0; t < labels.size(); ++t) {
    const double x = field.centroid(t).x() - 30;
    if (std::abs(x) > distance && labels[t] != (x < 0 ? 1 : 2)) ++wrong;
  }
  return wrong;
}

TEST(FitBorders, MovesAWanderingBorderToTheEdge) {
  for (const double degrees : {20.0, 40.0, 90.0})
    for (const bool convex : {true, false}) {
      const HeightField field = roof(degrees, convex, 0.3);
      const auto labels = wandering(field, 4);
      EXPECT_GT(num_wrong(field, labels, 1.5), 50);
      EXPECT_EQ(num_wrong(field, settled(field, labels), 1.5), 0) << degrees << (convex ? " convex" : " concave");
    }
}

TEST(FitBorders, NoiseOfAWholeSpacingMovesItLittle) {
  const HeightField field = roof(40, true, 1);
  EXPECT_EQ(num_wrong(field, settled(field, wandering(field, 4)), 2.5), 0);
}

TEST(FitBorders, LeavesBordersThatNoEdgeExplains) {
  const HeightField flat = roof(0, true, 0.3), gentle = roof(8, true, 0);
  EXPECT_EQ(fit_borders(flat.view(), wandering(flat, 4), flat.areas, kParameters), wandering(flat, 4));
  EXPECT_EQ(fit_borders(gentle.view(), wandering(gentle, 4), gentle.areas, kParameters), wandering(gentle, 4));
}

TEST(FitBorders, LeavesBackground) {
  const HeightField field = roof(40, true, 0);
  std::vector<std::int32_t> labels = wandering(field, 4);
  for (std::int32_t& label : labels) label = label == 2 ? 0 : label;
  EXPECT_EQ(fit_borders(field.view(), labels, field.areas, kParameters), labels);
}

// A step in one half only: a wall at x = 30 for y > 20. Its plane cuts the floor before it, which must stay one.
TEST(FitBorders, DoesNotGoOnWhereAFaceIsOnlyCutByTheOthersPlane) {
  const HeightField field =
      make_height_field(60, 40, [](double x, double y) { return y > 20 ? std::clamp(x - 30, 0.0, 12.0) : 0.0; });
  const auto labels = field.numbers([](const Eigen::Vector3d& p) {
    return p.y() > 21 && p.x() > 30 ? (p.x() < 42 ? 2 : 3) : p.y() > 20 && p.x() > 30 ? 0 : 1;
  });
  const auto fitted = fit_borders(field.view(), labels, field.areas, kParameters);
  for (std::size_t t = 0; t < labels.size(); ++t) {
    if (field.centroid(t).y() >= 18) continue;
    EXPECT_EQ(fitted[t], 1) << field.centroid(t).transpose();
  }
}

TEST(FitBorders, DoesNotDependOnThreads) {
  const HeightField field = roof(40, true, 0.5);
  Execution one, several;
  one.threads = 1;
  several.threads = 5;
  const auto labels = wandering(field, 4);
  EXPECT_EQ(fit_borders(field.view(), labels, field.areas, kParameters, one),
            fit_borders(field.view(), labels, field.areas, kParameters, several));
}

}  // namespace
}  // namespace meshmser
