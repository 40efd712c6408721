#include "stages/tree/levels.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "pipeline/execution/error.hpp"

namespace meshmser {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::vector<double> hundred_and_one() {
  std::vector<double> values;
  for (int i = 100; i >= 0; --i) values.push_back(i);
  return values;
}

TEST(MakeLevels, LinearOverTheQuantileRange) {
  EXPECT_THAT(make_levels(hundred_and_one(), {}, {.count = 5}, false), ElementsAre(-kInfinity, 26, 50, 74, 98));
}

TEST(MakeLevels, LowerIsTheSameRuleOnTheNegative) {
  std::vector<double> values = hundred_and_one();
  values[0] = 1000;
  std::vector<double> negative;
  for (const double v : values) negative.push_back(-v);
  for (const LevelRule rule : {LevelRule::kLinear, LevelRule::kNoise, LevelRule::kEveryValue, LevelRule::kStep})
    EXPECT_EQ(make_levels(values, {}, {.rule = rule, .step = 7, .noise = 2}, true),
              make_levels(negative, {}, {.rule = rule, .step = 7, .noise = 2}, false));
}

TEST(MakeLevels, OutrightRangeAndListAreMirrored) {
  LevelParameters range{.count = 3};
  range.low_value = 10;
  range.high_value = 30;
  EXPECT_THAT(make_levels(hundred_and_one(), {}, range, false), ElementsAre(-kInfinity, 20, 30));
  EXPECT_THAT(make_levels(hundred_and_one(), {}, range, true), ElementsAre(-kInfinity, -20, -10));
  const LevelParameters list{.rule = LevelRule::kList, .list = {3, 1, 3, 2}};
  EXPECT_THAT(make_levels({}, {}, list, false), ElementsAre(1, 2, 3));
  EXPECT_THAT(make_levels({}, {}, list, true), ElementsAre(-3, -2, -1));
}

TEST(MakeLevels, Step) {
  EXPECT_THAT(make_levels(hundred_and_one(), {}, {.rule = LevelRule::kStep, .step = 40}, false),
              ElementsAre(-kInfinity, 2, 42, 82));
}

TEST(MakeLevels, EqualAreaPutsEqualWeightBetweenLevels) {
  // Half of the weight lies on the value 0.
  const std::vector<double> values{0, 1, 2, 3, 4}, weights{4, 1, 1, 1, 1};
  LevelParameters p{.rule = LevelRule::kEqualArea, .count = 5};
  p.low_quantile = 0;
  p.high_quantile = 1;
  EXPECT_THAT(make_levels(values, weights, p, false), ElementsAre(-kInfinity, 1, 3, 4));
}

TEST(MakeLevels, NoiseStepsAreFineNearZeroAndOdd) {
  LevelParameters p{.rule = LevelRule::kNoise, .count = 5, .noise = 0.5};
  p.low_value = -2 * std::expm1(2);
  p.high_value = 2 * std::expm1(2);
  EXPECT_THAT(make_levels(std::vector<double>{0}, {}, p, false),
              ElementsAre(-kInfinity, DoubleNear(-2 * std::expm1(1), 1e-12), DoubleNear(0, 1e-12),
                          DoubleNear(2 * std::expm1(1), 1e-12), DoubleNear(2 * std::expm1(2), 1e-12)));
}

TEST(MakeLevels, DeltaInsertsLevelsOnBothSides) {
  EXPECT_THAT(make_levels({}, {}, {.rule = LevelRule::kList, .list = {1, 2}, .delta_value = 0.5}, false),
              ElementsAre(0.5, 1, 1.5, 2, 2.5));
}

TEST(MakeLevels, ConstantScalarHasTwoLevelsAndNoneOne) {
  EXPECT_THAT(make_levels(std::vector<double>(9, 4.0), {}, {}, false), ElementsAre(-kInfinity, 4));
  EXPECT_THAT(make_levels({}, {}, {}, false), ElementsAre(-kInfinity));
  EXPECT_THAT(make_levels(std::vector<double>{std::nan("")}, {}, {}, false), ElementsAre(-kInfinity));
}

TEST(MakeLevels, WhatARuleLacksIsAnError) {
  EXPECT_THROW(make_levels(hundred_and_one(), {}, {.rule = LevelRule::kNoise}, false), StageError);
  EXPECT_THROW(make_levels(hundred_and_one(), {}, {.rule = LevelRule::kStep}, false), StageError);
  EXPECT_THROW(make_levels(hundred_and_one(), {}, {.rule = LevelRule::kStep, .step = 1e-9}, false), StageError);
  EXPECT_THROW(make_levels(hundred_and_one(), {}, {.rule = LevelRule::kList}, false), StageError);
  EXPECT_THROW(make_levels(hundred_and_one(), {}, {.rule = LevelRule::kEqualArea}, false), StageError);
  EXPECT_THROW(make_levels(hundred_and_one(), {}, {.count = 1}, false), StageError);
  LevelParameters reversed;
  reversed.low_value = 2;
  reversed.high_value = 1;
  EXPECT_THROW(make_levels(hundred_and_one(), {}, reversed, false), StageError);
}

/// From the definition: count the levels that S reaches.
std::int32_t level_by_counting(double value, const std::vector<double>& levels) {
  std::int32_t level = 0;
  for (const double h : levels) level += value >= h;
  return level;
}

TEST(LevelsOfVertices, AsByCountingOnAwkwardLevelsAndValues) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (int round = 0; round < 200; ++round) {
    std::vector<double> levels, values;
    if (round % 2 == 0) levels.push_back(-kInfinity);
    const double scale = std::pow(10.0, round % 40 - 20);
    for (int i = 0; i < round % 30; ++i)
      levels.push_back(round % 3 == 0 ? scale * normal(random) : scale * std::exp(9 * normal(random)));
    std::sort(levels.begin(), levels.end());
    levels.erase(std::unique(levels.begin(), levels.end()), levels.end());
    for (int i = 0; i < 50; ++i) values.push_back(3 * scale * normal(random));
    for (const double h : levels) {
      values.push_back(h);
      values.push_back(std::nextafter(h, kInfinity));
      values.push_back(std::nextafter(h, -kInfinity));
    }
    values.insert(values.end(), {0.0, -0.0, kInfinity, 1e308, -1e308});
    const std::vector<std::int32_t> result = levels_of_vertices(values, levels, 1);
    const std::vector<std::int32_t> negative = levels_of_vertices(values, levels, -1);
    for (std::size_t v = 0; v < values.size(); ++v) {
      EXPECT_EQ(result[v], level_by_counting(values[v], levels)) << values[v] << " round " << round;
      EXPECT_EQ(negative[v], level_by_counting(-values[v], levels)) << -values[v] << " round " << round;
    }
  }
  EXPECT_THAT(levels_of_vertices(std::vector<double>{std::nan("")}, std::vector<double>{-kInfinity, 0}, 1),
              ElementsAre(0));
}

TEST(LevelsOfTriangles, TheLeastCornerCountsAndExcludedHaveNone) {
  const std::vector<std::array<std::int32_t, 3>> triangles{{0, 1, 2}, {2, 1, 3}};
  EXPECT_THAT(levels_of_triangles(triangles, std::vector<std::int32_t>{5, 3, 4, 1}, {}), ElementsAre(3, 1));
  EXPECT_THAT(levels_of_triangles(triangles, std::vector<std::int32_t>{5, 3, 4, 1}, std::vector<std::uint8_t>{0, 1}),
              ElementsAre(3, 0));
}

TEST(RankValues, RanksOfDistinctValuesOfEitherSign) {
  const std::vector<double> values{2, -1, 0.0, -0.0, 2, std::nan(""), -1e300, 1e-300};
  const RankedValues up = rank_values(values, 1), down = rank_values(values, -1);
  EXPECT_THAT(up.levels, ElementsAre(-1e300, -1, 0, 1e-300, 2));
  EXPECT_THAT(up.level_of_vertex, ElementsAre(5, 2, 3, 3, 5, 0, 1, 4));
  EXPECT_THAT(down.levels, ElementsAre(-2, -1e-300, 0, 1, 1e300));
  EXPECT_THAT(down.level_of_vertex, ElementsAre(1, 4, 3, 3, 1, 0, 5, 2));
}

TEST(LineStrength, IsThatOfTheLinesWhateverTheirShare) {
  for (const std::size_t num_lines : {50u, 100u, 900u}) {
    std::vector<double> values(1000 - num_lines, 0.01);
    values.insert(values.end(), num_lines, 2.0);
    values.insert(values.end(), 20, 100.0);  // outliers
    values.insert(values.end(), 300, -5.0);
    EXPECT_EQ(line_strength(values), 2) << num_lines;
  }
  EXPECT_EQ(line_strength(std::vector<double>{-1, 0}), 0);
  LevelParameters levels;
  levels.count = 3;
  levels.low_strength = 0.5;
  levels.high_strength = 1.5;
  std::vector<double> values(100, 2.0);
  EXPECT_EQ(make_levels(values, {}, levels, false), (std::vector<double>{-std::numeric_limits<double>::infinity(), 2, 3}));
}

}  // namespace
}  // namespace meshmser
