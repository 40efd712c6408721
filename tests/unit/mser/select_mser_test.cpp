#include "stages/mser/select_mser.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "pipeline/execution/error.hpp"
#include "stages/mser/stability.hpp"
#include "tests/unit/mser/hand_made_tree.hpp"

namespace meshmser {
namespace {

using ::testing::ElementsAre;

TEST(ChangeOfNodes, IsUpMinusDownAtTheMiddleLevel) {
  // A chain of one-level nodes: areas 1, 3, 7, 15 from the leaf to the root, at levels 4 .. 1.
  const ComponentTree tree = make_tree({{1, 4, 1}, {2, 3, 2}, {3, 2, 4}, {-1, 1, 8}}, 4);
  EXPECT_THAT(change_of_nodes(tree, 1), ElementsAre(3 - 0, 7 - 1, 15 - 3, 15 - 7));
  EXPECT_THAT(change_of_nodes(tree, 2), ElementsAre(7 - 0, 15 - 0, 15 - 1, 15 - 3));
  EXPECT_THAT(change_of_nodes(tree, 1000), ElementsAre(15, 15, 15, 15));
}

TEST(ChangeOfNodes, OfARegionThatLastsLongIsZero) {
  // The leaf lasts from level 2 to 10, m = 6.
  const ComponentTree tree = make_tree({{1, 10, 5}, {-1, 1, 8}}, 12);
  for (const std::int32_t delta : {1, 2, 3, 4}) EXPECT_EQ(change_of_nodes(tree, delta)[0], 0) << delta;
  EXPECT_EQ(change_of_nodes(tree, 5)[0], 13);
}

TEST(ChangeOfNodes, AddsUpAllDescendantsThatAreLeft) {
  // Two leaves at level 4, in a node that lasts over levels 2 and 3, in the root.
  const ComponentTree tree = make_tree({{2, 4, 1}, {2, 4, 2}, {3, 3, 4}, {-1, 1, 8}}, 4);
  EXPECT_THAT(change_of_nodes(tree, 2), ElementsAre(7 - 0, 7 - 0, 15 - 3, 15 - 7));
}

TEST(ChangeOfNodes, ByValueTakesTheLevelsAtLeastThatFar) {
  // Levels -infinity (counted as 0), 1, 2, 3: areas 1, 3, 7, 15 from the leaf to the root.
  ComponentTree tree = make_tree({{1, 4, 1}, {2, 3, 2}, {3, 2, 4}, {-1, 1, 8}}, 4);
  EXPECT_EQ(change_of_nodes_by_value(tree, 1), change_of_nodes(tree, 1));
  EXPECT_EQ(change_of_nodes_by_value(tree, 2), change_of_nodes(tree, 2));
  EXPECT_EQ(change_of_nodes_by_value(tree, 1.5), change_of_nodes(tree, 2));
  EXPECT_EQ(change_of_nodes_by_value(tree, 0.1), change_of_nodes(tree, 1));
  EXPECT_EQ(change_of_nodes_by_value(tree, 99), change_of_nodes(tree, 99));
  // Uneven levels: from h = 1.5 down to 0.5 and up to 2.5, past those in between.
  tree.levels = {0.5, 1.5, 1.75, 2.5};
  EXPECT_THAT(change_of_nodes_by_value(tree, 1), ElementsAre(7 - 0, 15 - 0, 15 - 1, 15 - 7));
  EXPECT_THROW(change_of_nodes_by_value(tree, 0), StageError);
}

TEST(ChangeOfNodes, RejectsADeltaBelowOne) {
  EXPECT_THROW(change_of_nodes(make_tree({{-1, 1, 1}}, 1), 0), StageError);
}

TEST(CompareStability, IsExactWhereDoublesRound) {
  const std::int64_t big = (std::int64_t{1} << 61) + 1;
  EXPECT_TRUE(compare_stability(big - 1, big, big, big) < 0);
  EXPECT_TRUE(compare_stability(1, 3, 2, 6) == 0);
  EXPECT_TRUE(compare_stability(0, 0, big, 1) > 0) << "zero area: infinite";
  EXPECT_TRUE(compare_stability(0, 0, 5, 0) == 0);
}

TEST(CompareArea, BringsUnitsTogether) {
  EXPECT_TRUE(compare_area(1, 0, 2, 1) == 0);
  EXPECT_TRUE(compare_area(1, 0, 3, 1) < 0);
  EXPECT_TRUE(compare_area(std::int64_t{1} << 61, 200, 1, 0) < 0);
  EXPECT_TRUE(compare_area(1, -200, std::int64_t{1} << 61, 0) > 0);
  EXPECT_TRUE(compare_area(0, -200, 1, 300) < 0);
}

// The largest node of a plateau of equal q wins, unless a node below any part of the plateau is better.
TEST(SelectMser, TakesAPlateauAsOne) {
  const ComponentTree chain = make_tree({{1, 5, 1}, {2, 4, 1}, {3, 3, 1}, {4, 2, 1}, {-1, 1, 1}}, 5);
  const auto changes_for = [&](std::vector<std::int64_t> q) {
    for (std::size_t n = 0; n < q.size(); ++n) q[n] *= chain.area_of_node[n];
    return q;
  };
  const SelectMserParameters parameters;
  EXPECT_THAT(select_mser(chain, changes_for({9, 2, 2, 2, 9}), parameters), ElementsAre(3));
  EXPECT_THAT(select_mser(chain, changes_for({1, 2, 2, 2, 9}), parameters), ElementsAre(0));
  EXPECT_THAT(select_mser(chain, changes_for({9, 2, 2, 2, 1}), parameters), ElementsAre());
  EXPECT_THAT(select_mser(chain, changes_for({9, 2, 9, 1, 9}), parameters), ElementsAre(1, 3));
  // Stands still at all of these: every one is selected.
  EXPECT_THAT(select_mser(chain, changes_for({9, 0, 0, 0, 9}), parameters), ElementsAre(1, 2, 3));
}

TEST(SelectMser, RootsCompeteButAreSelectedOnlyWhereOpen) {
  const ComponentTree chain = make_tree({{1, 2, 1}, {-1, 1, 1}}, 2);
  const std::vector<std::int64_t> root_better = {5, 2};
  EXPECT_THAT(select_mser(chain, root_better, SelectMserParameters{}), ElementsAre());
  const std::vector<std::uint8_t> open_root = {0, 1};
  EXPECT_THAT(select_mser(chain, root_better, SelectMserParameters{}, open_root), ElementsAre(1));
}

// A speck of lower q in a facet: compared with every child the facet loses, with its main child it wins.
TEST(SelectMser, MainChildIgnoresASpeck) {
  const ComponentTree tree = make_tree({{2, 4, 1}, {2, 4, 10}, {3, 2, 20}, {-1, 1, 50}}, 4);
  const std::vector<std::int64_t> changes = {1, 50, 93, 729};
  ASSERT_TRUE(compare_stability(changes[0], 1, changes[2], 31) < 0);
  ASSERT_TRUE(compare_stability(changes[1], 10, changes[2], 31) > 0);
  EXPECT_THAT(select_mser(tree, changes, {1, Against::kChildren}), ElementsAre(0));
  EXPECT_THAT(select_mser(tree, changes, {1, Against::kMainChild}), ElementsAre(0, 2));
}

}  // namespace
}  // namespace meshmser
