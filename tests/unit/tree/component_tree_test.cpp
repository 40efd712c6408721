#include "stages/tree/component_tree.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <string>

#include "stages/common/adjacency.hpp"
#include "stages/common/exact_area.hpp"
#include "stages/tree/levels.hpp"
#include "tests/support/random_mesh.hpp"

namespace meshmser {
namespace {

using testing::RandomMesh;
using Triangles = std::vector<std::array<std::int32_t, 3>>;
using ::testing::ElementsAre;

/// A strip of n triangles, each touching the next.
Triangles strip(std::int32_t n) {
  Triangles triangles;
  for (std::int32_t i = 0; i < n; ++i)
    triangles.push_back(i % 2 == 0 ? std::array<std::int32_t, 3>{i, i + 1, i + 2}
                                   : std::array<std::int32_t, 3>{i + 1, i, i + 2});
  return triangles;
}

ComponentTree tree_of(const Triangles& triangles, const std::vector<std::int32_t>& levels,
                      std::vector<double> areas = {}) {
  std::int32_t num_vertices = 0;
  for (const auto& t : triangles) num_vertices = std::max(num_vertices, *std::max_element(t.begin(), t.end()) + 1);
  if (areas.empty()) areas.assign(triangles.size(), 1);
  const std::int32_t top = levels.empty() ? 1 : *std::max_element(levels.begin(), levels.end());
  return build_component_tree(twin_half_edges(triangles, static_cast<std::size_t>(num_vertices)), areas, levels, top);
}

std::set<std::int32_t> triangles_of(const ComponentTree& tree, std::int32_t node) {
  std::set<std::int32_t> result;
  for (std::size_t t = 0; t < tree.node_of_triangle.size(); ++t)
    if (tree.node_of_triangle[t] >= tree.first_node_of_subtree[static_cast<std::size_t>(node)] &&
        tree.node_of_triangle[t] <= node)
      result.insert(static_cast<std::int32_t>(t));
  return result;
}

double area_of(const ComponentTree& tree, std::size_t node) {
  return std::ldexp(static_cast<double>(tree.area_of_node[node]), -tree.area_exponent_of_node[node]);
}

/// Every component of {t : level >= k}, grown triangle by triangle from the definition.
std::set<std::set<std::int32_t>> components(const std::vector<std::int32_t>& twins,
                                            const std::vector<std::int32_t>& levels, std::int32_t k) {
  std::set<std::set<std::int32_t>> result;
  for (std::size_t start = 0; start < levels.size(); ++start) {
    if (levels[start] < k) continue;
    std::set<std::int32_t> component{static_cast<std::int32_t>(start)};
    std::vector<std::int32_t> stack(component.begin(), component.end());
    while (!stack.empty()) {
      const std::int32_t t = stack.back();
      stack.pop_back();
      for (std::int32_t h = 3 * t; h < 3 * t + 3; ++h) {
        const std::int32_t twin = twins[static_cast<std::size_t>(h)];
        if (twin >= 0 && levels[static_cast<std::size_t>(twin / 3)] >= k && component.insert(twin / 3).second)
          stack.push_back(twin / 3);
      }
    }
    result.insert(component);
  }
  return result;
}

TEST(ComponentTree, RandomMeshesHoldTheDefinition) {
  for (std::uint32_t seed = 0; seed < 600; ++seed) {
    const RandomMesh mesh = testing::random_mesh(seed);
    const std::vector<double> levels = make_levels(
        mesh.values, {}, {.rule = seed % 2 == 0 ? LevelRule::kEveryValue : LevelRule::kList, .list = {-2, 0, 1, 3}},
        seed % 4 >= 2);
    const std::vector<std::int32_t> level =
        levels_of_triangles(mesh.triangles, levels_of_vertices(mesh.values, levels, seed % 4 >= 2 ? -1 : 1), {});
    const auto num_levels = static_cast<std::int32_t>(levels.size());
    const std::vector<std::int32_t> twins = twin_half_edges(mesh.triangles, mesh.positions.size());
    const std::vector<double> areas = triangle_areas(mesh.positions, mesh.triangles);
    const ComponentTree tree = build_component_tree(twins, areas, level, num_levels);
    SCOPED_TRACE("seed " + std::to_string(seed));
    // Theorem 2.
    ASSERT_EQ(rebuild_levels(tree), level);
    // The nodes at k are the components at k, and each node is another set than its parent's.
    std::vector<std::set<std::int32_t>> members;
    for (std::int32_t node = 0; node < static_cast<std::int32_t>(tree.num_nodes()); ++node)
      members.push_back(triangles_of(tree, node));
    for (std::int32_t k = 1; k <= num_levels; ++k) {
      std::set<std::set<std::int32_t>> nodes;
      for (std::int32_t node = 0; node < static_cast<std::int32_t>(tree.num_nodes()); ++node)
        if (tree.lo(node) <= k && k <= tree.hi_of_node[static_cast<std::size_t>(node)])
          nodes.insert(members[static_cast<std::size_t>(node)]);
      ASSERT_EQ(nodes, components(twins, level, k)) << "level " << k;
    }
    std::int32_t smallest_of_last_root = -1;
    for (std::size_t node = 0; node < tree.num_nodes(); ++node) {
      const std::int32_t parent = tree.parent_of_node[node];
      double area = 0;
      for (const std::int32_t t : members[node]) area += areas[static_cast<std::size_t>(t)];
      ASSERT_NEAR(area_of(tree, node), area, 1e-12);
      if (parent >= 0) {
        ASSERT_GT(parent, static_cast<std::int32_t>(node));
        ASSERT_GT(members[static_cast<std::size_t>(parent)].size(), members[node].size());
      } else {
        ASSERT_GT(*members[node].begin(), smallest_of_last_root) << "roots by smallest triangle";
        smallest_of_last_root = *members[node].begin();
      }
    }
  }
}

TEST(ComponentTree, NoTriangleMakesNoNode) {
  const ComponentTree tree = tree_of({}, {});
  EXPECT_EQ(tree.num_nodes(), 0u);
  EXPECT_TRUE(tree.node_of_triangle.empty());
}

TEST(ComponentTree, OneTriangleMakesOneRoot) {
  const ComponentTree tree = tree_of({{0, 1, 2}}, {3});
  EXPECT_THAT(tree.parent_of_node, ElementsAre(-1));
  EXPECT_THAT(tree.hi_of_node, ElementsAre(3));
  EXPECT_EQ(tree.lo(0), 1);
}

TEST(ComponentTree, ConstantScalarMakesOneNode) {
  EXPECT_THAT(tree_of(strip(50), std::vector<std::int32_t>(50, 2)).hi_of_node, ElementsAre(2));
}

TEST(ComponentTree, TwoPeaksMeetInTheirSaddle) {
  //                                       peak 5      saddle 2    peak 4
  const ComponentTree tree = tree_of(strip(5), {5, 2, 4, 1, 1});
  EXPECT_THAT(tree.hi_of_node, ElementsAre(5, 4, 2, 1));
  EXPECT_THAT(tree.parent_of_node, ElementsAre(2, 2, 3, -1));
  EXPECT_THAT(tree.first_node_of_subtree, ElementsAre(0, 1, 0, 0));
  EXPECT_THAT(tree.node_of_triangle, ElementsAre(0, 2, 1, 3, 3));
  EXPECT_DOUBLE_EQ(area_of(tree, 2), 3);
}

TEST(ComponentTree, TrianglesThatMeetInAVertexAloneAreApart) {
  const ComponentTree tree = tree_of({{0, 1, 2}, {2, 3, 4}}, {1, 1});
  EXPECT_EQ(tree.num_nodes(), 2u);
}

TEST(ComponentTree, PillowIsOneNode) {
  EXPECT_EQ(tree_of({{0, 1, 2}, {2, 1, 0}}, {2, 2}).num_nodes(), 1u);
}

TEST(ComponentTree, TrianglesBelowTheLeastLevelAreInNoNodeAndPart) {
  const ComponentTree tree = tree_of(strip(3), {1, 0, 1});
  EXPECT_THAT(tree.node_of_triangle, ElementsAre(0, -1, 1));
}

TEST(ComponentTree, FanOfAHundredThousandWithEveryLevelItsOwn) {
  const std::int32_t n = 100000;
  Triangles triangles;
  std::vector<std::int32_t> levels;
  for (std::int32_t i = 0; i < n; ++i) {
    triangles.push_back({0, i + 1, (i + 1) % n + 1});
    levels.push_back(i % 2 == 0 ? 1 + i / 2 : n - i / 2);
  }
  const ComponentTree tree = tree_of(triangles, levels);
  EXPECT_EQ(rebuild_levels(tree), levels);
  EXPECT_EQ(tree.parent_of_node.back(), -1);
}

TEST(ComponentTree, AnIslandElsewhereChangesNothing) {
  const Triangles mesh = strip(6);
  Triangles with_island = mesh;
  with_island.push_back({100, 101, 102});
  const std::vector<double> areas{0.1, 0.2, 0.3, 0.1, 0.7, 1e-9};
  const ComponentTree alone = tree_of(mesh, {3, 1, 2, 2, 1, 3}, areas);
  std::vector<double> more = areas;
  more.push_back(1e12);  // would take all the bits, were the unit common
  const ComponentTree together = tree_of(with_island, {3, 1, 2, 2, 1, 3, 2}, more);
  ASSERT_EQ(together.num_nodes(), alone.num_nodes() + 1);
  for (std::size_t node = 0; node < alone.num_nodes(); ++node) {
    EXPECT_EQ(together.area_of_node[node], alone.area_of_node[node]);
    EXPECT_EQ(together.area_exponent_of_node[node], alone.area_exponent_of_node[node]);
  }
}

TEST(ComponentTree, AreasDoNotDependOnTheOrderOfTriangles) {
  const Triangles mesh = strip(5);
  const Triangles reversed(mesh.rbegin(), mesh.rend());
  const ComponentTree a = tree_of(mesh, {1, 1, 1, 1, 1}, {1e9, 0.1, 1e-7, 0.3, 1e-12});
  const ComponentTree b = tree_of(reversed, {1, 1, 1, 1, 1}, {1e-12, 0.3, 1e-7, 0.1, 1e9});
  EXPECT_EQ(a.area_of_node, b.area_of_node);
}

TEST(ComponentTree, ZeroAreasAreZero) {
  const ComponentTree tree = tree_of(strip(2), {2, 1}, {0, 0});
  EXPECT_THAT(tree.area_of_node, ElementsAre(0, 0));
}

TEST(ComponentTree, AreaUnitsNeverOverflow) {
  for (const double greatest : {5e-324, 1e-300, 1e-7, 1.0, 1.0 - 1e-16, 3e7, 1e300})
    for (const std::int64_t count : {std::int64_t{1}, std::int64_t{1000}, std::int64_t{715827882}}) {
      const std::int64_t units = area_in_units(greatest, area_exponent(count, greatest));
      EXPECT_GT(units, 0);
      EXPECT_LE(units, (std::int64_t{1} << 62) / count) << greatest << " x " << count;
    }
}

TEST(ComponentTree, ThreadsChangeNothingOfALargeMesh) {
  // Two strips, long enough for several chunks of work; levels hold over runs of triangles, so that nodes are few.
  Triangles triangles = strip(200000);
  const std::int32_t offset = 200002;
  for (std::size_t t = 0; t < 150000; ++t)
    triangles.push_back({triangles[t][0] + offset, triangles[t][1] + offset, triangles[t][2] + offset});
  const std::vector<std::int32_t> twins = twin_half_edges(triangles, 350004);
  std::vector<double> areas;
  for (std::size_t t = 0; t < triangles.size(); ++t) areas.push_back(0.1 + 0.001 * static_cast<double>(t % 997));
  for (const std::int32_t least : {0, 1}) {
    std::mt19937 random(7);
    std::vector<std::int32_t> levels;
    while (levels.size() < triangles.size())
      levels.insert(levels.end(), 50, least + static_cast<std::int32_t>(random() % 9));
    levels.resize(triangles.size());
    std::vector<ComponentTree> trees;
    for (const int threads : {1, 2, 5}) {
      Execution execution;
      execution.threads = threads;
      trees.push_back(build_component_tree(twins, areas, levels, 9, execution));
    }
    EXPECT_EQ(rebuild_levels(trees[0]), levels);
    double own = 0, of_roots = 0;
    for (std::size_t t = 0; t < areas.size(); ++t) own += levels[t] > 0 ? areas[t] : 0;
    for (std::size_t n = 0; n < trees[0].num_nodes(); ++n)
      if (trees[0].parent_of_node[n] < 0)
        of_roots += std::ldexp(static_cast<double>(trees[0].area_of_node[n]), -trees[0].area_exponent_of_node[n]);
    EXPECT_NEAR(of_roots, own, 1e-9 * own);
    for (const ComponentTree& other : trees) {
      EXPECT_EQ(other.parent_of_node, trees[0].parent_of_node);
      EXPECT_EQ(other.hi_of_node, trees[0].hi_of_node);
      EXPECT_EQ(other.area_of_node, trees[0].area_of_node);
      EXPECT_EQ(other.area_exponent_of_node, trees[0].area_exponent_of_node);
      EXPECT_EQ(other.first_node_of_subtree, trees[0].first_node_of_subtree);
      EXPECT_EQ(other.node_of_triangle, trees[0].node_of_triangle);
    }
  }
}

TEST(ComponentTree, WrongInputIsRefused) {
  const std::vector<std::int32_t> twins(3, -1);
  const std::vector<double> area{1}, bad_area{std::nan("")}, negative{-1};
  const std::vector<std::int32_t> level{1}, high{2}, below{-1};
  EXPECT_THROW(build_component_tree(twins, area, high, 1), StageError);
  EXPECT_THROW(build_component_tree(twins, area, below, 1), StageError);
  EXPECT_THROW(build_component_tree(twins, bad_area, level, 1), StageError);
  EXPECT_THROW(build_component_tree(twins, negative, level, 1), StageError);
  EXPECT_THROW(build_component_tree(twins, {}, level, 1), StageError);
}

}  // namespace
}  // namespace meshmser
