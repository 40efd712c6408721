#include "stages/mser/segment.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/unit/mser/height_field.hpp"
#include "tests/unit/mser/height_field_trees.hpp"

namespace meshmser {
namespace {

std::vector<double> ten_levels() {
  std::vector<double> levels;
  for (int k = 0; k < 10; ++k) levels.push_back(k + 0.5);
  return levels;
}

// The trap of image MSER: a square frame with a hole in it is two regions, whatever min_diversity.
TEST(Segment, ASquareWithAHoleIsTwoRegions) {
  const HeightField field = make_height_field(40, 40);
  const auto inside = [](const Eigen::Vector3d& p, double from, double to) {
    return p.x() >= from && p.x() <= to && p.y() >= from && p.y() <= to;
  };
  const auto values = field.values([&](const Eigen::Vector3d& p) {
    return inside(p, 12, 18) ? 0.0 : inside(p, 5, 25) ? 10.0 : 5.0;
  });
  const LevelSetTrees trees = make_trees(field, values, ten_levels(), true);
  for (const double diversity : {0.0, 0.2, 0.99}) {
    SegmentParameters parameters;
    parameters.delta = 2;
    parameters.min_diversity = diversity;
    parameters.max_area = 500;  // the frame's surroundings, and all but the hole, are stable as well
    const Segmentation result = segment({field.view(), trees, {}, {}, {}}, parameters);
    ASSERT_EQ(result.regions.size(), 2U) << diversity;
    EXPECT_EQ(result.regions[0].polarity, Polarity::kUpper);
    EXPECT_EQ(result.regions[1].polarity, Polarity::kLower);
    EXPECT_EQ(result.regions[0].stability, 0);
    EXPECT_NEAR(result.regions[0].scalar_mean, 10, 1e-12);
    EXPECT_NEAR(result.regions[1].scalar_mean, 0, 1e-12);
    EXPECT_EQ(result.regions[1].num_triangles, 2 * 36);
    EXPECT_DOUBLE_EQ(result.regions[1].area, 36);
    EXPECT_NEAR((result.regions[1].centroid - Eigen::Vector3d(15, 15, 0)).norm(), 0, 1e-12);
    EXPECT_GT(result.regions[0].contrast, 0);
    EXPECT_LT(result.regions[1].contrast, 0);
    EXPECT_GT(result.regions[0].persistence, 4);
  }
}

TEST(Segment, EveryFilterReportsWhatItRemoved) {
  const HeightField field = make_height_field(60, 20);
  // Three bumps of growing size.
  const auto values = field.values([](const Eigen::Vector3d& p) {
    for (int bump = 1; bump <= 3; ++bump)
      if (std::abs(p.x() - 15 * bump) <= bump && std::abs(p.y() - 10) <= bump) return 3.0 * bump;
    return 0.0;
  });
  const LevelSetTrees trees = make_trees(field, values, ten_levels(), false);
  SegmentParameters parameters;
  parameters.delta = 1;
  EXPECT_EQ(segment({field.view(), trees, {}, {}, {}}, parameters).regions.size(), 3U);
  const auto count_of = [&](const SegmentParameters& given, const std::string& name) {
    const Segmentation result = segment({field.view(), trees, {}, {}, {}}, given);
    for (const FilterCount& count : result.filters)
      if (count.filter == name) {
        EXPECT_EQ(count.seen, 3);
        EXPECT_EQ(static_cast<std::int64_t>(result.regions.size()), count.seen - count.removed);
        return count.removed;
      }
    return std::int64_t{-1};
  };
  const auto with = [&](auto member, auto value) {
    SegmentParameters changed = parameters;
    changed.*member = value;
    return changed;
  };
  EXPECT_EQ(count_of(with(&SegmentParameters::min_area, 5.0), "min_area"), 1);
  EXPECT_EQ(count_of(with(&SegmentParameters::max_area, 20.0), "max_area"), 1);
  EXPECT_EQ(count_of(with(&SegmentParameters::min_persistence, 5.0), "min_persistence"), 1);
  EXPECT_EQ(count_of(with(&SegmentParameters::max_variation, -1.0), "max_variation"), 3);
  EXPECT_EQ(count_of(with(&SegmentParameters::keep_largest, std::int64_t{2}), "keep_largest"), 1);
  EXPECT_EQ(count_of(parameters, "min_area"), -1) << "a filter not asked for is not reported";
  // Means over bands of one unit: the whole step inside, about half of it on the slope outside.
  SegmentParameters contrast = with(&SegmentParameters::min_contrast, 2.0);
  contrast.band = 1;
  LevelSetTrees noisy = trees;
  noisy.noise = 1;
  const Segmentation result = segment({field.view(), noisy, {}, {}, {}}, contrast);
  ASSERT_EQ(result.regions.size(), 2U);
  EXPECT_NEAR(result.regions[0].contrast, 4.5, 0.5);
  EXPECT_NEAR(result.regions[1].contrast, 3, 0.5);
}

TEST(Segment, FacetsMeetOnTheCreaseAndNoneIsLeftOver) {
  // Two flat halves with a crease at x = 30 that fades at one end: strength 0 but near the crease.
  const HeightField field = make_height_field(60, 20);
  const auto crease =
      field.values([](const Eigen::Vector3d& p) { return std::max(0.0, 8 - 2 * std::abs(p.x() - 30)); });
  std::vector<double> minus(crease.size());
  std::transform(crease.begin(), crease.end(), minus.begin(), std::negate<>());
  std::vector<double> levels;
  for (int k = -10; k < 0; ++k) levels.push_back(k + 0.5);
  const LevelSetTrees trees = make_trees(field, minus, levels, false);
  SegmentParameters parameters;
  parameters.select = Select::kStableBranch;
  parameters.min_persistence = 3;
  parameters.grow = Grow::kWatershed;
  const Segmentation result = segment({field.view(), trees, crease, {}, {}}, parameters);
  EXPECT_EQ(result.regions.size(), 2U);
  EXPECT_EQ(result.label_of_triangle, field.numbers([](const Eigen::Vector3d& p) { return p.x() < 30 ? 1 : 2; }));
  EXPECT_DOUBLE_EQ(result.area_of_label[1], 600);
  EXPECT_THAT(result.region_of_label, ::testing::ElementsAre(0, 1, 2));

  parameters.merge = Merge::kSaliency;
  parameters.saliency = 100;
  const Segmentation merged = segment({field.view(), trees, crease, {}, {}}, parameters);
  EXPECT_THAT(merged.label_of_triangle, ::testing::Each(0)) << "what covers everything is background";
  EXPECT_THAT(merged.region_of_label, ::testing::ElementsAre(0));
}

TEST(Segment, SaysWhatDoesNotFit) {
  const HeightField field = make_height_field(3, 3);
  LevelSetTrees trees = make_trees(field, std::vector<double>(field.positions.size(), 0), ten_levels(), false);
  SegmentParameters parameters;
  parameters.merge = Merge::kTurning;
  EXPECT_THROW(segment({field.view(), trees, {}, {}, {}}, parameters), StageError);
  parameters.merge = Merge::kNone;
  EXPECT_NO_THROW(segment({field.view(), trees, {}, {}, {}}, parameters));
  parameters.grow = Grow::kWatershed;
  parameters.flood_by = FloodBy::kFacets;
  parameters.flood_width = 1;
  EXPECT_THROW(segment({field.view(), trees, {}, {}, {}}, parameters), StageError) << "no normals";
  parameters.grow = Grow::kNone;
  trees.values.pop_back();
  EXPECT_THROW(segment({field.view(), trees, {}, {}, {}}, parameters), StageError);
}

}  // namespace
}  // namespace meshmser
