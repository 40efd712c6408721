#include "stages/mser/persistence.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "stages/mser/stability.hpp"
#include "tests/unit/mser/hand_made_tree.hpp"

namespace meshmser {
namespace {

using ::testing::ElementsAre;

// Levels -inf, 1, 2 ... 9. Leaves: 0 at level 9, 1 at level 6, 3 at level 6; 0 and 1 meet at level 4, all at level 1.
ComponentTree two_hills() {
  return make_tree({{2, 9, 4}, {2, 6, 2}, {4, 4, 8}, {4, 6, 5}, {-1, 1, 50}}, 10);
}

TEST(FiniteLevels, PutsTheLowEndOneStepBelow) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_THAT(finite_levels(std::vector<double>{-kInfinity, 2, 5}), ElementsAre(-1, 2, 5));
  EXPECT_THAT(finite_levels(std::vector<double>{-kInfinity, 2}), ElementsAre(2, 2));
  EXPECT_THAT(finite_levels(std::vector<double>{3, 5}), ElementsAre(3, 5));
}

TEST(FindMaxima, TheHigherLivesOn) {
  const Maxima maxima = find_maxima(two_hills());
  EXPECT_THAT(maxima.highest_of_node, ElementsAre(0, 1, 0, 3, 0));
  // The highest lasts over the whole range 0 .. 9; 1 falls from 5 to 3; 3 falls from 5 to the low end, 0.
  EXPECT_THAT(maxima.persistence_of_leaf, ElementsAre(9, 2, 0, 5, 0));
  EXPECT_THAT(maxima.top_of_leaf, ElementsAre(4, 1, -1, 3, -1));
}

TEST(FindMaxima, OfEqualHeightsTheSmallerTriangleLivesOn) {
  ComponentTree tree = make_tree({{2, 3, 1}, {2, 3, 1}, {-1, 1, 1}}, 3);
  EXPECT_EQ(find_maxima(tree).highest_of_node[2], 0);
  tree.node_of_triangle = {1, 0, 2};
  EXPECT_EQ(find_maxima(tree).highest_of_node[2], 1);
}

TEST(SelectPersistence, TakesTheLargestNodesWithOneSignificantMaximum) {
  const ComponentTree tree = two_hills();
  const Maxima maxima = find_maxima(tree);
  EXPECT_THAT(select_persistence(tree, maxima, {1, 0}), ElementsAre(0, 1, 3));
  EXPECT_THAT(select_persistence(tree, maxima, {2, 0}), ElementsAre(2, 3)) << "must last longer";
  EXPECT_THAT(select_persistence(tree, maxima, {5, 0}), ElementsAre()) << "a root that holds one only";
  EXPECT_THAT(select_persistence(tree, maxima, {1, 5}), ElementsAre(2, 3)) << "the second hill is too small";
}

TEST(SelectStableBranch, TakesTheLeastChangeBelowTheFirstMerge) {
  const ComponentTree tree = two_hills();
  const Maxima maxima = find_maxima(tree);
  const std::vector<std::int64_t> leaf_better = {1, 0, 14, 1, 50}, equal = {2, 0, 7, 1, 50};
  EXPECT_THAT(select_stable_branch(tree, maxima, leaf_better, {2, 0}), ElementsAre(0, 3));
  EXPECT_THAT(select_stable_branch(tree, maxima, equal, {2, 0}), ElementsAre(2, 3)) << "ties to the larger";
}

// A node of few triangles changes little from level to level because it is small.
TEST(SelectStableBranch, LeavesOutSpecksAtTheMaximum) {
  const ComponentTree tree = two_hills();
  const Maxima maxima = find_maxima(tree);
  const std::vector<std::int64_t> still = {0, 0, 14, 0, 50};
  EXPECT_THAT(select_stable_branch(tree, maxima, still, {2, 4}), ElementsAre(0, 3));
  EXPECT_THAT(select_stable_branch(tree, maxima, still, {2, 5}), ElementsAre(2, 3)) << "node 0 has an area of 4";
  EXPECT_THAT(select_stable_branch(tree, maxima, still, {1, 4}), ElementsAre(0, 3)) << "node 1 is not significant";
}

}  // namespace
}  // namespace meshmser
