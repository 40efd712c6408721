#include "stages/load/pass_distance.hpp"

#include <gtest/gtest.h>

#include <random>

#include "stages/load/load_scan.hpp"

namespace meshmser {
namespace {

/// Passes over a cylinder of radius 20, each moved along z, its points spaced by 1 and noisy along z.
PointCloud passes(const std::vector<double>& shifts, double noise, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  std::vector<PosedScan> scans;
  for (const double shift : shifts) {
    PosedScan scan;
    scan.geometry.name = "pass";
    for (int i = 0; i < 60; ++i)
      for (int j = 0; j < 60; ++j) {
        const double angle = (i - 30 + uniform(random)) / 40;
        scan.geometry.positions.emplace_back(20 * std::sin(angle), j + uniform(random),
                                             20 * std::cos(angle) + noise * normal(random));
        scan.geometry.positions.back().z() += shift;
      }
    scans.push_back(std::move(scan));
  }
  return load_scan(scans).points;
}

TEST(PassDistance, OneScanHasNone) {
  EXPECT_TRUE(measure_pass_distances(passes({0}, 0.1)).pairs.empty());
}

TEST(PassDistance, NoiseAloneIsNotMisregistration) {
  for (const double noise : {0.05, 0.3, 0.6, 1.0}) {
    const PointCloud points = passes({0, 0}, noise);
    EXPECT_LT(measure_pass_distances(points).median_distance, 0.15 * points.spacing) << noise;
  }
}

TEST(PassDistance, FindsTheShiftOfEachPair) {
  for (const double shift : {0.25, 0.5, 1.0}) {
    const PassDistances found = measure_pass_distances(passes({0, 0, shift}, 0.1));
    ASSERT_EQ(found.pairs.size(), 3u);
    EXPECT_LT(found.pairs[0].median_distance, 0.05);
    // Along the normal, which is inclined to z by up to 40 degrees.
    EXPECT_NEAR(found.pairs[1].median_distance, 0.93 * shift, 0.08 * shift + 0.02);
    EXPECT_NEAR(found.pairs[2].median_distance, 0.93 * shift, 0.08 * shift + 0.02);
    EXPECT_EQ(found.pairs[2].first, 1u);
    EXPECT_EQ(found.pairs[2].second, 2u);
  }
}

TEST(PassDistance, SameForAnyNumberOfThreads) {
  const PointCloud points = passes({0, 0.3}, 0.2);
  const double one = measure_pass_distances(points, Execution{1, nullptr, {}}).median_distance;
  EXPECT_EQ(measure_pass_distances(points, Execution{2, nullptr, {}}).median_distance, one);
}

}  // namespace
}  // namespace meshmser
