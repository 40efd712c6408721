#include "stages/mser/label_triangles.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "stages/common/adjacency.hpp"
#include "stages/mser/patches.hpp"
#include "tests/unit/mser/hand_made_tree.hpp"
#include "tests/unit/mser/height_field.hpp"

namespace meshmser {
namespace {

using ::testing::ElementsAre;

TEST(OrderRegions, ByAreaThenSmallestTriangleThenTree) {
  // Nodes 0 and 1 are of equal area; the second tree is the same with its triangles the other way round.
  std::vector<ComponentTree> trees(2, make_tree({{2, 3, 4}, {2, 3, 4}, {-1, 1, 9}}, 3));
  trees[1].node_of_triangle = {1, 0, 2};
  const std::vector<std::vector<std::int32_t>> selected = {{0, 1}, {0, 1, 2}};
  EXPECT_THAT(order_regions(trees, selected), ElementsAre(SelectedNode{1, 2}, SelectedNode{0, 0}, SelectedNode{1, 1},
                                                          SelectedNode{0, 1}, SelectedNode{1, 0}));
}

TEST(LabelTriangles, GivesTheSmallestRegionAcrossTrees) {
  const std::vector<ComponentTree> trees = {make_tree({{1, 3, 1}, {2, 2, 5}, {-1, 1, 9}}, 3),
                                            make_tree({{1, 3, 2}, {2, 2, 4}, {-1, 1, 9}}, 3)};
  const std::vector<std::vector<std::int32_t>> selected = {{0, 1}, {0, 1}};
  const std::vector<SelectedNode> regions = order_regions(trees, selected);
  // Both trees have a region of area 6 with triangles 0 and 1; the upper one bears the number 1 and wins the tie.
  ASSERT_THAT(regions, ElementsAre(SelectedNode{0, 1}, SelectedNode{1, 1}, SelectedNode{1, 0}, SelectedNode{0, 0}));
  EXPECT_THAT(label_triangles(trees, regions), ElementsAre(4, 1, 0));
  EXPECT_THAT(parent_regions(trees, regions), ElementsAre(-1, -1, 2, 1));
}

TEST(SplitPatches, NumbersPartsByAreaThenSmallestTriangle) {
  // A strip of five triangles, each joined to the next; the middle one is another region.
  std::vector<std::int32_t> twins(15, -1);
  for (std::int32_t t = 0; t + 1 < 5; ++t) {
    twins[static_cast<std::size_t>(3 * t + 1)] = 3 * (t + 1);
    twins[static_cast<std::size_t>(3 * (t + 1))] = 3 * t + 1;
  }
  const std::vector<std::int32_t> number = {7, 7, 2, 7, 0};
  const Patches equal = split_patches(twins, number, std::vector<double>{1, 1, 2, 2, 9});
  EXPECT_THAT(equal.patch_of_triangle, ElementsAre(1, 1, 2, 3, 0));
  EXPECT_THAT(equal.number_of_patch, ElementsAre(0, 7, 2, 7));
  EXPECT_THAT(equal.area_of_patch, ElementsAre(0, 2, 2, 2));
  const Patches differing = split_patches(twins, number, std::vector<double>{1, 1, 3, 1e-300, 9});
  EXPECT_THAT(differing.patch_of_triangle, ElementsAre(2, 2, 1, 3, 0));
}

/// Of each triangle the smallest that a walk over neighbours of the same number reaches; -1 for number 0.
std::vector<std::int32_t> smallest_reached(std::span<const std::int32_t> twins, std::span<const std::int32_t> number) {
  std::vector<std::int32_t> smallest(number.size(), -1);
  for (std::size_t seed = 0; seed < number.size(); ++seed) {
    if (number[seed] == 0 || smallest[seed] >= 0) continue;
    std::vector<std::size_t> front{seed};
    smallest[seed] = static_cast<std::int32_t>(seed);
    while (!front.empty()) {
      const std::size_t t = front.back();
      front.pop_back();
      for (std::size_t h = 3 * t; h < 3 * t + 3; ++h) {
        if (twins[h] < 0) continue;
        const auto next = static_cast<std::size_t>(twins[h] / 3);
        if (number[next] != number[t] || smallest[next] >= 0) continue;
        smallest[next] = static_cast<std::int32_t>(seed);
        front.push_back(next);
      }
    }
  }
  return smallest;
}

TEST(SplitPatches, AreThoseOfAWalkOverNeighboursWhateverTheThreads) {
  std::mt19937 random(3);
  for (int repeat = 0; repeat < 200; ++repeat) {
    HeightField field = make_height_field(1 + static_cast<int>(random() % 20), 1 + static_cast<int>(random() % 20));
    if (repeat % 2 == 1) std::shuffle(field.triangles.begin(), field.triangles.end(), random);
    const std::vector<std::int32_t> twins = twin_half_edges(field.triangles, field.positions.size());
    std::vector<std::int32_t> number;
    for (std::size_t t = 0; t < field.triangles.size(); ++t) number.push_back(static_cast<std::int32_t>(random() % 3));
    const std::vector<std::int32_t> expected = smallest_reached(twins, number);
    for (const int threads : {1, 2, 3, 50}) {
      Execution execution;
      execution.threads = threads;
      const Patches patches = split_patches(twins, number, std::vector<double>(number.size(), 1), execution);
      std::vector<std::int32_t> smallest(patches.num_patches() + 1, -1);
      for (std::size_t t = number.size(); t-- > 0;) {
        const auto patch = static_cast<std::size_t>(patches.patch_of_triangle[t]);
        if (patch > 0) smallest[patch] = static_cast<std::int32_t>(t);
      }
      for (std::size_t t = 0; t < number.size(); ++t) {
        const auto patch = static_cast<std::size_t>(patches.patch_of_triangle[t]);
        ASSERT_EQ(smallest[patch], expected[t]) << "triangle " << t << " on " << threads << " threads";
        ASSERT_EQ(patches.number_of_patch[patch], number[t]);
      }
    }
  }
}

TEST(SplitPatches, TakesBackgroundAsAPatchAndWholeNumbersAsTheyAre) {
  std::mt19937 random(11);
  for (int repeat = 0; repeat < 200; ++repeat) {
    HeightField field = make_height_field(1 + static_cast<int>(random() % 20), 1 + static_cast<int>(random() % 20));
    std::vector<std::int32_t> number;
    for (std::size_t t = 0; t < field.triangles.size(); ++t) number.push_back(static_cast<std::int32_t>(random() % 3));
    // Background as a number of its own is what splitting it means.
    std::vector<std::int32_t> shifted;
    for (const std::int32_t n : number) shifted.push_back(n + 1);
    const Patches all = split_patches(field.twins, shifted, field.areas);
    const Patches with_background = split_patches(field.twins, number, field.areas, {}, {.background = true});
    ASSERT_EQ(with_background.patch_of_triangle, all.patch_of_triangle);
    ASSERT_EQ(with_background.first_of_patch, all.first_of_patch);
    ASSERT_EQ(with_background.area_of_patch, all.area_of_patch);
    for (std::size_t p = 1; p <= all.num_patches(); ++p) {
      ASSERT_EQ(with_background.number_of_patch[p] + 1, all.number_of_patch[p]);
      const auto first = std::find(all.patch_of_triangle.begin(), all.patch_of_triangle.end(), p);
      ASSERT_EQ(all.first_of_patch[p], first - all.patch_of_triangle.begin());
    }
    // Patches are whole, whatever they are numbered.
    const Patches patches = split_patches(field.twins, number, field.areas);
    std::vector<std::int32_t> renamed(patches.num_patches() + 1, 0);
    std::iota(renamed.begin() + 1, renamed.end(), 1);
    std::shuffle(renamed.begin() + 1, renamed.end(), random);
    std::vector<std::int32_t> whole;
    for (const std::int32_t p : patches.patch_of_triangle) whole.push_back(renamed[static_cast<std::size_t>(p)]);
    for (const bool background : {false, true}) {
      const Patches seen = split_patches(field.twins, whole, field.areas, {}, {.background = background});
      const Patches told =
          split_patches(field.twins, whole, field.areas, {}, {.background = background, .whole_numbers = true});
      ASSERT_EQ(told.patch_of_triangle, seen.patch_of_triangle);
      ASSERT_EQ(told.number_of_patch, seen.number_of_patch);
      ASSERT_EQ(told.first_of_patch, seen.first_of_patch);
      ASSERT_EQ(told.area_of_patch, seen.area_of_patch);
    }
  }
}

TEST(DropWholeComponents, OnlyWhereOneLabelCoversAll) {
  HeightField field = make_height_field(30, 2);
  // Two components: cut at x = 10.
  const auto cut = field.numbers([](const Eigen::Vector3d& p) { return p.x() > 10 && p.x() < 11 ? 1 : 0; });
  cut_out_triangles(field.twins, std::vector<std::uint8_t>(cut.begin(), cut.end()));
  Patches patches = split_patches(field.twins, field.numbers([](const Eigen::Vector3d& p) {
    return p.x() < 10 ? 4 : p.x() < 11 ? 0 : p.x() < 18 ? 2 : 3;
  }),
                                  field.areas);
  EXPECT_THAT(patches.number_of_patch, ElementsAre(0, 3, 4, 2));
  drop_whole_components(field.twins, patches);
  EXPECT_THAT(patches.number_of_patch, ElementsAre(0, 3, 2));
  EXPECT_THAT(patches.area_of_patch, ElementsAre(0, 24, 14));
  EXPECT_EQ(patches.patch_of_triangle, field.numbers([](const Eigen::Vector3d& p) {
    return p.x() < 11 ? 0 : p.x() < 18 ? 2 : 1;
  }));
}

}  // namespace
}  // namespace meshmser
