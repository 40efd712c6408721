#include "stages/curvature/line_scale.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/shapes.hpp"

namespace meshmser {
namespace {

// A corrugated plate: ridges and grooves of equal width, rounded.
shapes::Sample corrugated(double width, double height, double spacing, double noise) {
  auto s = shapes::plane(16, spacing);
  for (Eigen::Vector3d& p : s.points) p.z() = height * std::sin(std::numbers::pi * p.x() / width);
  shapes::add_noise(s, noise * spacing, 12);
  return s;
}

TEST(LineScale, FollowsTheWidthOfTheLinesAndNotTheSpacing) {
  const auto measured = [](double width, double spacing, double noise) {
    const auto s = corrugated(width, 0.1 * width, spacing, noise);
    return measure_line_scale(s.points, s.normals, spacing).radius / width;
  };
  const double reference = measured(1, 0.1, 0.1);
  EXPECT_GT(reference, 0.2);
  EXPECT_LT(reference, 0.6);
  EXPECT_NEAR(measured(1, 0.07, 0.1), reference, 0.15 * reference);
  EXPECT_NEAR(measured(1.6, 0.1, 0.1), reference, 0.15 * reference);
  EXPECT_NEAR(measured(1, 0.1, 0.3), reference, 0.15 * reference);
}

TEST(LineScale, DoesNotDependOnThreads) {
  const auto s = corrugated(1, 0.1, 0.1, 0.2);
  Execution one, seven;
  one.threads = 1;
  seven.threads = 7;
  EXPECT_EQ(measure_line_scale(s.points, s.normals, 0.1, one).response,
            measure_line_scale(s.points, s.normals, 0.1, seven).response);
  EXPECT_THROW(measure_line_scale(s.points, s.normals, 0), StageError);
}

}  // namespace
}  // namespace meshmser
