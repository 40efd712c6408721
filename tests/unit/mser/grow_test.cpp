#include "stages/mser/grow.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/mser/height_field.hpp"

namespace meshmser {
namespace {

using ::testing::Each;

TEST(AbsorbSmallPatches, JoinsTheNeighbourOfLongestBorder) {
  // A patch of two squares at x 9 .. 11 between 1 on the left, of height 4, and 2 on the right; it has one edge with 1
  // and the upper and lower border in 2.
  const HeightField field = make_height_field(20, 4);
  const auto labels = field.numbers([](const Eigen::Vector3d& p) {
    if (p.x() > 9 && p.x() < 11 && p.y() > 1 && p.y() < 2) return 3;
    return p.x() < 9 ? 1 : 2;
  });
  const auto absorbed = absorb_small_patches(field.view(), labels, field.areas, 2.5);
  EXPECT_EQ(absorbed, field.numbers([](const Eigen::Vector3d& p) { return p.x() < 9 ? 1 : 2; }));
  EXPECT_EQ(absorb_small_patches(field.view(), labels, field.areas, 2), labels) << "not below the size";
}

TEST(AbsorbSmallPatches, ClosesHolesOfBackground) {
  const HeightField field = make_height_field(10, 10);
  const auto labels = field.numbers([](const Eigen::Vector3d& p) {
    const bool hole = p.x() > 4 && p.x() < 5 && p.y() > 4 && p.y() < 5;
    return p.x() > 1 && p.x() < 9 && p.y() > 1 && p.y() < 9 && !hole ? 1 : 0;
  });
  const auto absorbed = absorb_small_patches(field.view(), labels, field.areas, 3);
  EXPECT_EQ(std::count(absorbed.begin(), absorbed.end(), 1), 2 * 64);
}

TEST(AbsorbSmallPatches, ChainsOfSmallPatchesJoinOneByOne) {
  // Patches of 1, 2, 3 ... squares along a strip; the first joins the second and so on until the size is reached.
  const HeightField field = make_height_field(10, 1);
  const auto labels = field.numbers([](const Eigen::Vector3d& p) {
    return p.x() < 1 ? 1 : p.x() < 3 ? 2 : p.x() < 6 ? 3 : 4;
  });
  EXPECT_THAT(absorb_small_patches(field.view(), labels, field.areas, 100), Each(4));
  EXPECT_EQ(absorb_small_patches(field.view(), labels, field.areas, 2), field.numbers([](const Eigen::Vector3d& p) {
    return p.x() < 3 ? 2 : p.x() < 6 ? 3 : 4;
  }));
}

TEST(FloodByStrength, MeetsOnTheCrest) {
  const HeightField field = make_height_field(30, 6);
  // Seeds near both ends; the strength has its crest at x = 20, far from the middle.
  const auto seeds = field.numbers([](const Eigen::Vector3d& p) { return p.x() < 1 ? 1 : p.x() > 29 ? 2 : 0; });
  const auto strength = field.values([](const Eigen::Vector3d& p) { return 10 - std::abs(p.x() - 20) / 3; });
  const auto grown = flood_by_strength(field.view(), seeds, strength);
  for (std::size_t t = 0; t < grown.size(); ++t) {
    const double x = field.centroid(t).x();
    if (x < 20) {
      EXPECT_EQ(grown[t], 1) << x;
    }
    if (x > 20) {
      EXPECT_EQ(grown[t], 2) << x;
    }
  }
}

TEST(FloodByStrength, LeavesOutWhatIsExcludedAndWhatNoSeedReaches) {
  HeightField field = make_height_field(30, 2);
  const auto excluded = field.numbers([](const Eigen::Vector3d& p) { return p.x() > 10 && p.x() < 11 ? 1 : 0; });
  const std::vector<std::uint8_t> flags(excluded.begin(), excluded.end());
  const auto seeds = field.numbers([](const Eigen::Vector3d& p) { return p.x() < 1 ? 1 : 0; });
  const std::vector<double> flat(field.positions.size(), 0);
  EXPECT_EQ(flood_by_strength(field.view(), seeds, flat, flags),
            field.numbers([](const Eigen::Vector3d& p) { return p.x() < 10 ? 1 : 0; }));
}

// A roof whose ridge bears no curvature over half of its length, as where it runs into a valley; one seed is much
// nearer.
TEST(FloodFacets, DoesNotLeakWhereACrestFades) {
  const auto roof = [](double x, double) { return -0.4 * std::abs(x - 30); };
  const HeightField field = make_height_field(60, 20, roof);
  const auto curvature = field.values(
      [](const Eigen::Vector3d& p) { return p.y() < 10 ? std::max(0.0, 0.2 - 0.05 * std::abs(p.x() - 30)) : 0.0; });
  std::vector<Eigen::Vector3d> normals;
  for (const Eigen::Vector3d& p : field.positions)
    normals.push_back(Eigen::Vector3d(0.4 * std::clamp((p.x() - 30) / 3, -1.0, 1.0), 0, 1).normalized());
  const auto seeds = field.numbers([](const Eigen::Vector3d& p) { return p.x() < 25 ? 1 : p.x() > 50 ? 2 : 0; });
  const auto num_wrong = [&](const std::vector<std::int32_t>& grown) {
    int wrong = 0;
    for (std::size_t t = 0; t < grown.size(); ++t) wrong += grown[t] != (field.centroid(t).x() < 30 ? 1 : 2) ? 1 : 0;
    return wrong;
  };
  EXPECT_EQ(num_wrong(flood_facets(field.view(), seeds, curvature, normals, 4)), 0);
  EXPECT_EQ(num_wrong(flood_facets(field.view(), seeds, {}, normals, 4)), 0) << "normals alone are enough here";
  EXPECT_GT(num_wrong(flood_by_strength(field.view(), seeds, curvature)), 50);
}

TEST(FloodByLikeness, TakesTheStepBetweenTwoMeans) {
  const HeightField field = make_height_field(30, 6);
  const auto seeds = field.numbers([](const Eigen::Vector3d& p) { return p.x() < 1 ? 1 : p.x() > 29 ? 2 : 0; });
  const auto values =
      triangle_means(field.view(), field.values([](const Eigen::Vector3d& p) { return p.x() < 22 ? 0.0 : 7.0; }));
  const auto grown = flood_by_likeness(field.view(), seeds, values, field.areas);
  for (std::size_t t = 0; t < grown.size(); ++t) {
    const double x = field.centroid(t).x();
    if (x < 21) {
      EXPECT_EQ(grown[t], 1) << x;
    }
    if (x > 22) {
      EXPECT_EQ(grown[t], 2) << x;
    }
  }
}

}  // namespace
}  // namespace meshmser
