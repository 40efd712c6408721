#include "stages/mser/merge.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/unit/mser/height_field.hpp"

namespace meshmser {
namespace {

using ::testing::Each;

constexpr double kDegree = std::numbers::pi / 180;

std::vector<std::int32_t> thirds(const HeightField& field) {
  return field.numbers([](const Eigen::Vector3d& p) { return p.x() < 20 ? 1 : p.x() < 40 ? 2 : 3; });
}

TEST(MergeBySaliency, JoinsAcrossTheWeakBorderOnly) {
  const HeightField field = make_height_field(60, 10);
  const auto strength = field.values([](const Eigen::Vector3d& p) {
    return p.x() == 20 ? 1.5 : p.x() == 40 ? 9.0 : 1.0;
  });
  const auto merged = merge_by_saliency(field.view(), thirds(field), strength, field.areas, 2);
  EXPECT_EQ(merged, field.numbers([](const Eigen::Vector3d& p) { return p.x() < 40 ? 1 : 3; }));
  EXPECT_EQ(merge_by_saliency(field.view(), thirds(field), strength, field.areas, 0.1), thirds(field));
  EXPECT_THAT(merge_by_saliency(field.view(), thirds(field), strength, field.areas, 100), Each(1));
}

TEST(MergeBySaliency, NeverJoinsBackground) {
  const HeightField field = make_height_field(60, 10);
  const auto labels = field.numbers([](const Eigen::Vector3d& p) { return p.x() < 20 ? 1 : p.x() < 40 ? 0 : 2; });
  const std::vector<double> flat(field.positions.size(), 0);
  EXPECT_EQ(merge_by_saliency(field.view(), labels, flat, field.areas, 1), labels);
}

// Three facets: an edge of 2 degrees at x = 20 and of 30 degrees at x = 40.
HeightField folded() {
  return make_height_field(60, 20, [](double x, double) {
    return x < 20   ? 0
           : x < 40 ? std::tan(2 * kDegree) * (x - 20)
                    : std::tan(2 * kDegree) * 20 + std::tan(32 * kDegree) * (x - 40);
  });
}

TEST(MergeByTurning, JoinsWhereTheSurfaceHardlyTurns) {
  const HeightField field = folded();
  const auto merge = [&](double degrees) {
    return merge_by_turning(field.view(), thirds(field), {}, field.areas, {degrees * kDegree, 6, 60, 0.1});
  };
  EXPECT_EQ(merge(1.5), thirds(field));
  EXPECT_EQ(merge(5), field.numbers([](const Eigen::Vector3d& p) { return p.x() < 40 ? 1 : 3; }));
  EXPECT_EQ(merge(29), field.numbers([](const Eigen::Vector3d& p) { return p.x() < 40 ? 1 : 3; }));
  EXPECT_THAT(merge(31), Each(1));
}

// A cylinder of radius 40 cut in two turns by more than 5 degrees within 6, but no more than it does anywhere.
TEST(MergeByTurning, ForgivesWhatTheOwnCurvatureExplains) {
  const HeightField field =
      make_height_field(60, 20, [](double x, double) { return std::sqrt(1600 - (x - 30) * (x - 30)); });
  const auto labels = field.numbers([](const Eigen::Vector3d& p) { return p.x() < 30 ? 1 : 2; });
  const std::vector<double> curvature(field.triangles.size(), 1.0 / 40);
  const TurningParameters parameters{5 * kDegree, 6, 60, 0.1};
  EXPECT_EQ(merge_by_turning(field.view(), labels, {}, field.areas, parameters), labels);
  EXPECT_THAT(merge_by_turning(field.view(), labels, curvature, field.areas, parameters), Each(1));
}

// Where curvature is measured with noise, floods meet where the face seems to bend most, and its lower quantile would
// part a bore in two. A median that comes from edges nearby explains nothing.
TEST(MergeByTurning, TakesTheMedianOfAFaceThatBendsEvenly) {
  const HeightField field =
      make_height_field(60, 20, [](double x, double) { return std::sqrt(1600 - (x - 30) * (x - 30)); });
  const auto labels = field.numbers([](const Eigen::Vector3d& p) { return p.x() < 30 ? 1 : 2; });
  std::vector<double> even(field.triangles.size()), uneven(field.triangles.size());
  for (std::size_t t = 0; t < even.size(); ++t) {
    even[t] = (t % 5 < 2 ? 0.75 : 1.0) / 40;
    uneven[t] = (t % 5 < 2 ? 0.25 : 1.0) / 40;
  }
  const TurningParameters parameters{1 * kDegree, 6, 60, 0.2};
  EXPECT_THAT(merge_by_turning(field.view(), labels, even, field.areas, parameters), Each(1));
  EXPECT_EQ(merge_by_turning(field.view(), labels, uneven, field.areas, parameters), labels);
}

// The same where the little common border runs to and fro.
TEST(MergeByTurning, AZigzagAtACornerIsNoBorder) {
  const HeightField field = make_height_field(60, 60);
  const auto labels = field.numbers([](const Eigen::Vector3d& p) {
    if (std::abs(p.x() - 30) < 2 && std::abs(p.y() - 30) < 2) {
      const double tooth = std::fmod(p.y(), 1.0) < 0.5 ? -2 : 2;
      return p.x() < 30 + tooth ? 1 : 2;
    }
    return p.x() < 30 && p.y() < 30 ? 1 : p.x() > 30 && p.y() > 30 ? 2 : 0;
  });
  double length = 0;
  for (std::size_t h = 0; h < field.twins.size(); ++h)
    if (labels[h / 3] == 1 && field.twins[h] >= 0 && labels[static_cast<std::size_t>(field.twins[h] / 3)] == 2)
      length += (field.positions[static_cast<std::size_t>(field.triangles[h / 3][h % 3])] -
                 field.positions[static_cast<std::size_t>(field.triangles[h / 3][(h + 1) % 3])])
                    .norm();
  EXPECT_GT(length, 6);
  const TurningParameters parameters{5 * kDegree, 6, 60, 0.1};
  EXPECT_EQ(merge_by_turning(field.view(), labels, {}, field.areas, parameters), labels);
}

// Four flat quarters: neighbours join along their sides, but not those that meet at a corner only.
TEST(MergeByTurning, DoesNotJoinAcrossACorner) {
  const HeightField field = make_height_field(60, 60);
  const auto labels = field.numbers([](const Eigen::Vector3d& p) {
    if (std::abs(p.x() - 30) < 2 && std::abs(p.y() - 30) < 2) return p.x() < 30 ? 1 : 2;
    return p.x() < 30 && p.y() < 30 ? 1 : p.x() > 30 && p.y() > 30 ? 2 : 0;
  });
  const TurningParameters parameters{5 * kDegree, 6, 60, 0.1};
  EXPECT_EQ(merge_by_turning(field.view(), labels, {}, field.areas, parameters), labels);
  const auto halves = field.numbers([](const Eigen::Vector3d& p) { return p.x() < 30 ? 1 : 2; });
  EXPECT_THAT(merge_by_turning(field.view(), halves, {}, field.areas, parameters), Each(1));
}

TEST(MergeByTurning, DoesNotDependOnThreads) {
  const HeightField field = folded();
  const auto labels = field.numbers(
      [](const Eigen::Vector3d& p) { return 1 + static_cast<int>(p.x() / 7) + 9 * static_cast<int>(p.y() / 7); });
  Execution one, seven;
  one.threads = 1;
  seven.threads = 7;
  const TurningParameters parameters{5 * kDegree, 6, 60, 0.1};
  const auto merged = merge_by_turning(field.view(), labels, {}, field.areas, parameters, one);
  EXPECT_EQ(merged, merge_by_turning(field.view(), labels, {}, field.areas, parameters, seven));
  EXPECT_NE(merged, labels);
}

}  // namespace
}  // namespace meshmser
