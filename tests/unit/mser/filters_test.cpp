#include "stages/mser/filters.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "stages/common/tree_nodes.hpp"
#include "tests/unit/mser/hand_made_tree.hpp"

namespace meshmser {
namespace {

using ::testing::ElementsAre;

// A chain of areas 90, 95, 100, 200 with the root on top.
ComponentTree chain() {
  return make_tree({{1, 4, 90}, {2, 3, 5}, {3, 2, 5}, {-1, 1, 100}}, 4);
}

/// Changes that give the nodes of a tree the wanted q, in hundredths.
std::vector<std::int64_t> changes_for(ComponentTree& tree, std::vector<std::int64_t> hundredths) {
  for (std::size_t n = 0; n < hundredths.size(); ++n) {
    hundredths[n] *= tree.area_of_node[n];
    tree.area_of_node[n] *= 100;
  }
  return hundredths;
}

TEST(FilterArea, KeepsBothEnds) {
  const std::vector<std::int32_t> selected = {0, 1, 2};
  EXPECT_THAT(filter_area(chain(), selected, 95, 100), ElementsAre(1, 2));
  EXPECT_THAT(filter_area(chain(), selected, 95.5, std::numeric_limits<double>::infinity()), ElementsAre(2));
}

TEST(FilterDiversity, KeepsTheMoreStableOfLikeSizes) {
  ComponentTree tree = chain();
  const auto changes = changes_for(tree, {3, 2, 1, 0});
  const std::vector<std::int32_t> selected = {0, 1, 2};
  EXPECT_THAT(filter_diversity(tree, changes, selected, 0), ElementsAre(0, 1, 2));
  EXPECT_THAT(filter_diversity(tree, changes, selected, 0.02), ElementsAre(0, 1, 2));
  EXPECT_THAT(filter_diversity(tree, changes, selected, 0.2), ElementsAre(2));
}

// Each pair loses someone, yet the chain never vanishes: 0 against 1 leaves 0, which then meets 2.
TEST(FilterDiversity, OfAChainOneAlwaysStays) {
  ComponentTree tree = chain();
  const auto changes = changes_for(tree, {1, 2, 1, 0});
  const std::vector<std::int32_t> selected = {0, 1, 2};
  EXPECT_THAT(filter_diversity(tree, changes, selected, 0.06), ElementsAre(0, 2)) << "0 is 10 % smaller than 2";
  EXPECT_THAT(filter_diversity(tree, changes, selected, 0.2), ElementsAre(2)) << "ties keep the ancestor";
}

// Two siblings of almost half the area each: the one of the smaller triangle id meets the parent first.
TEST(FilterDiversity, SiblingsBySmallestTriangle) {
  ComponentTree tree = make_tree({{2, 4, 45}, {2, 4, 50}, {3, 2, 5}, {-1, 1, 100}}, 4);
  const auto changes = changes_for(tree, {1, 3, 2, 0});
  const std::vector<std::int32_t> selected = {0, 1, 2};
  EXPECT_THAT(filter_diversity(tree, changes, selected, 0.6), ElementsAre(0, 1)) << "0 removes 2, so 1 has no rival";
  tree.node_of_triangle = {1, 0, 2, 3};
  EXPECT_THAT(filter_diversity(tree, changes, selected, 0.6), ElementsAre(0)) << "2 removes 1, then 0 removes 2";
}

TEST(FilterDiversity, OfUnrelatedNodesRemovesNone) {
  ComponentTree tree = make_tree({{2, 4, 50}, {2, 4, 50}, {-1, 1, 100}}, 4);
  const auto changes = changes_for(tree, {1, 1, 1});
  const std::vector<std::int32_t> selected = {0, 1};
  EXPECT_THAT(filter_diversity(tree, changes, selected, 1), ElementsAre(0, 1));
}

TEST(FilterNested, KeepsWhatIsAskedFor) {
  // 0 < 1 < 3 and 2 < 3.
  ComponentTree tree = make_tree({{1, 5, 10}, {3, 4, 10}, {3, 4, 15}, {4, 2, 5}, {-1, 1, 100}}, 5);
  const auto changes = changes_for(tree, {5, 4, 9, 6, 0});
  const std::vector<std::int32_t> selected = {0, 1, 2, 3};
  EXPECT_THAT(nearest_listed_ancestors(tree, selected), ElementsAre(1, 3, 3, -1));
  EXPECT_THAT(filter_nested(tree, changes, selected, Nested::kKeep), ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(filter_nested(tree, changes, selected, Nested::kOutermost), ElementsAre(3));
  EXPECT_THAT(filter_nested(tree, changes, selected, Nested::kInnermost), ElementsAre(0, 2));
  EXPECT_THAT(filter_nested(tree, changes, selected, Nested::kMostStable), ElementsAre(1, 2));
}

}  // namespace
}  // namespace meshmser
