#include "stages/mser/explain_triangle.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "stages/mser/stability.hpp"
#include "stages/tree/component_tree.hpp"
#include "stages/tree/levels.hpp"
#include "tests/unit/mser/height_field.hpp"

namespace meshmser {
namespace {

using Kind = NodeFate::Kind;

LevelSetTrees upper_tree_of(const HeightField& field, std::vector<double> values, int num_levels) {
  LevelSetTrees trees;
  trees.values = std::move(values);
  std::vector<double> levels = {-std::numeric_limits<double>::infinity()};
  for (int k = 0; k < num_levels; ++k) levels.push_back(k + 0.5);
  const auto of_vertex = levels_of_vertices(trees.values, levels, 1);
  ComponentTree tree =
      build_component_tree(field.twins, field.areas, levels_of_triangles(field.triangles, of_vertex, {}),
                           static_cast<std::int32_t>(levels.size()));
  tree.levels = levels;
  trees.trees.push_back(std::move(tree));
  return trees;
}

LevelSetTrees rough(const HeightField& field, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<double> values;
  for (const Eigen::Vector3d& p : field.positions)
    values.push_back(std::floor(4 + 4 * std::sin(p.x() / 4) * std::cos(p.y() / 3) + random() % 3));
  return upper_tree_of(field, std::move(values), 12);
}

bool holds(const ComponentTree& tree, std::int32_t outer, std::int32_t inner) {
  while (inner >= 0 && inner != outer) inner = tree.parent_of_node[static_cast<std::size_t>(inner)];
  return inner == outer;
}

struct Explained {
  RegionSelection selection;
  std::vector<NodeFates> fates;
};

Explained explain(const HeightField& field, const LevelSetTrees& trees, const SegmentParameters& parameters) {
  Explained result;
  result.selection = select_regions({field.view(), trees, {}, {}, {}}, parameters, &result.fates);
  return result;
}

// For every way to select and to filter: nodes told to be regions are the regions; each filter has as many nodes as it
// is counted with; rivals are kin, and as stable as is said.
TEST(Fates, AgreeWithTheRegionsAndTheCounts) {
  const HeightField field = make_height_field(40, 30);
  for (unsigned seed = 1; seed <= 6; ++seed)
    for (const Select select :
         {Select::kMser, Select::kPersistence, Select::kStableBranch, Select::kLength, Select::kLevel})
      for (const Nested nested : {Nested::kKeep, Nested::kOutermost, Nested::kInnermost, Nested::kMostStable}) {
        SCOPED_TRACE(testing::Message() << "seed " << seed << ", select " << static_cast<int>(select) << ", nested "
                                        << static_cast<int>(nested));
        const LevelSetTrees trees = rough(field, seed);
        SegmentParameters parameters;
        parameters.select = select;
        parameters.delta = 1;
        parameters.against = seed % 2 == 0 ? Against::kMainChild : Against::kChildren;
        parameters.min_length = 6;
        parameters.level = 6;
        parameters.min_area = 2;
        parameters.max_area = 400;
        parameters.max_variation = 2;
        parameters.min_persistence = 1;
        parameters.min_diversity = 0.4;
        parameters.min_contrast = 0.2;
        parameters.band = 1;
        parameters.nested = nested;
        parameters.keep_largest = 12;
        const Explained result = explain(field, trees, parameters);
        const ComponentTree& tree = trees.trees[0];
        const auto& changes = result.selection.selections[0].changes;
        std::set<std::int32_t> regions, told;
        for (const SelectedNode& region : result.selection.regions) regions.insert(region.node);
        std::vector<std::int64_t> removed(result.selection.filters.size(), 0);
        const auto q = [&](std::int32_t node) { return stability_of_node(tree, changes, node); };
        for (std::size_t n = 0; n < tree.num_nodes(); ++n) {
          const auto node = static_cast<std::int32_t>(n);
          const NodeFate& fate = result.fates[0][n];
          if (fate.kind == Kind::kRegion) told.insert(node);
          if (fate.kind == Kind::kRoot) {
            EXPECT_LT(tree.parent_of_node[n], 0);
          }
          if (fate.kind == Kind::kLessStable) {
            EXPECT_LT(q(fate.rival), q(node));
          }
          if (fate.kind == Kind::kSmallerOfPlateau) {
            EXPECT_EQ(q(fate.rival), q(node));
          }
          if (fate.kind == Kind::kSmallerOfPlateau || fate.kind == Kind::kSmallerOfMaximum) {
            EXPECT_TRUE(holds(tree, fate.rival, node));
          }
          if (fate.kind == Kind::kFiltered) {
            ++removed.at(static_cast<std::size_t>(fate.filter));
            if (fate.rival >= 0) {
              EXPECT_TRUE(holds(tree, fate.rival, node) || holds(tree, node, fate.rival));
            }
          }
        }
        EXPECT_EQ(told, regions);
        for (std::size_t f = 0; f < removed.size(); ++f)
          if (result.selection.filters[f].filter != "significance") {
            EXPECT_EQ(removed[f], result.selection.filters[f].removed) << result.selection.filters[f].filter;
          }
      }
}

TEST(ExplainTriangle, WalksFromItsOwnNodeToTheRoot) {
  const HeightField field = make_height_field(40, 40);
  // A small peak on a terrace on the ground.
  const LevelSetTrees trees = upper_tree_of(field, field.values([](const Eigen::Vector3d& p) {
    const double from_centre = std::max(std::abs(p.x() - 20), std::abs(p.y() - 20));
    return from_centre <= 1 ? 9.0 : from_centre <= 10 ? 5.0 : 0.0;
  }),
                                            10);
  SegmentParameters parameters;
  parameters.delta = 1;
  parameters.min_area = 10;
  const Explained result = explain(field, trees, parameters);
  const std::int32_t top = closest_triangle(field.view(), {20.4, 20.2, 3}).triangle;
  const auto path = explain_triangle(trees, result.selection, result.fates, 0, top);
  ASSERT_EQ(path.size(), 3U);
  EXPECT_EQ(path[0].fate.kind, Kind::kFiltered);
  EXPECT_EQ(result.selection.filters.at(static_cast<std::size_t>(path[0].fate.filter)).filter, "min_area");
  EXPECT_DOUBLE_EQ(path[0].area, 4);
  EXPECT_EQ(path[0].lo, 7);
  EXPECT_EQ(path[0].hi, 10);
  EXPECT_DOUBLE_EQ(path[0].value, 5.5);
  EXPECT_EQ(path[0].region, 0);
  EXPECT_EQ(path[1].fate.kind, Kind::kRegion);
  EXPECT_EQ(path[1].region, 1);
  EXPECT_DOUBLE_EQ(path[1].area, 400);
  EXPECT_EQ(path[1].stability, 0);
  EXPECT_EQ(path[2].fate.kind, Kind::kRoot);
  EXPECT_TRUE(std::isinf(path[2].value));
}

// Whatever a story names, it tells of: each rival of each node told is on the path or among the rivals, once.
TEST(ExplainRivals, EveryStoryIsTold) {
  const HeightField field = make_height_field(40, 30);
  std::size_t beside_the_path = 0;
  for (unsigned seed = 1; seed <= 4; ++seed)
    for (const Select select : {Select::kMser, Select::kStableBranch, Select::kMeaningful}) {
      const LevelSetTrees trees = rough(field, seed);
      SegmentParameters parameters;
      parameters.select = select;
      parameters.delta = 1;
      parameters.min_persistence = 1;
      parameters.independent = 2;
      parameters.nested = Nested::kMostStable;
      parameters.keep_largest = 3;
      const Explained result = explain(field, trees, parameters);
      for (std::int32_t t = 0; t < static_cast<std::int32_t>(field.triangles.size()); t += 37) {
        const auto path = explain_triangle(trees, result.selection, result.fates, 0, t);
        const auto rivals = explain_rivals(trees, result.selection, result.fates, 0, path);
        std::set<std::int32_t> on_path, told;
        for (const ExplainedNode& of : path) on_path.insert(of.node);
        told = on_path;
        for (const ExplainedNode& of : rivals) {
          EXPECT_TRUE(told.insert(of.node).second) << "told twice";
          EXPECT_FALSE(holds(trees.trees[0], of.node, path[0].node)) << "it holds the triangle";
          EXPECT_EQ(of.region > 0, of.fate.kind == Kind::kRegion);
        }
        for (const auto* list : {&path, &rivals})
          for (const ExplainedNode& of : *list)
            if (of.fate.rival >= 0) {
              EXPECT_EQ(told.count(of.fate.rival), 1U);
            }
        beside_the_path += rivals.size();
      }
    }
  EXPECT_GT(beside_the_path, 10U);
}

TEST(ClosestTriangle, AgreesWithDenseSampling) {
  const HeightField field = make_height_field(3, 3, [](double x, double y) { return std::sin(2 * x + y); });
  std::mt19937 random(7);
  std::uniform_real_distribution<double> within(-2, 5);
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Vector3d point(within(random), within(random), within(random));
    double least = std::numeric_limits<double>::infinity();
    for (const auto& triangle : field.triangles)
      for (int i = 0; i <= 100; ++i)
        for (int j = 0; i + j <= 100; ++j) {
          Eigen::Vector3d sample = Eigen::Vector3d::Zero();
          const double weights[3] = {i / 100.0, j / 100.0, (100 - i - j) / 100.0};
          for (std::size_t k = 0; k < 3; ++k)
            sample += weights[k] * field.positions[static_cast<std::size_t>(triangle[k])];
          least = std::min(least, (sample - point).norm());
        }
    const ClosestTriangle closest = closest_triangle(field.view(), point);
    EXPECT_LE(closest.distance, least + 1e-12);
    EXPECT_NEAR(closest.distance, least, 0.02);
    ASSERT_GE(closest.triangle, 0);
  }
  EXPECT_EQ(closest_triangle({}, {0, 0, 0}).triangle, -1);
}

}  // namespace
}  // namespace meshmser
