#include "stages/borders/borders.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "stages/common/adjacency.hpp"
#include "stages/tree/component_tree.hpp"
#include "stages/tree/levels.hpp"
#include "tests/support/border_checker.hpp"
#include "tests/support/random_mesh.hpp"

namespace meshmser {
namespace {

using testing::check_border_loops;
using ::testing::ElementsAre;
using testing::RandomMesh;
using Triangles = std::vector<std::array<std::int32_t, 3>>;

struct Built {
  std::vector<std::int32_t> twins;
  ComponentTree tree;
};

Built build(const Triangles& triangles, std::size_t num_vertices, const std::vector<std::int32_t>& levels,
            const std::vector<std::uint8_t>& excluded = {}) {
  Built built{twin_half_edges(triangles, num_vertices), {}};
  cut_out_triangles(built.twins, excluded);
  const std::int32_t top = levels.empty() ? 1 : *std::max_element(levels.begin(), levels.end());
  built.tree = build_component_tree(built.twins, std::vector<double>(triangles.size(), 1), levels, top);
  return built;
}

std::vector<std::uint8_t> members(const ComponentTree& tree, std::int32_t node) {
  std::vector<std::uint8_t> inside;
  for (const std::int32_t n : tree.node_of_triangle)
    inside.push_back(n >= tree.first_node_of_subtree[static_cast<std::size_t>(node)] && n <= node);
  return inside;
}

TEST(ExtractBorders, RandomMeshesPassTheChecker) {
  for (std::uint32_t seed = 0; seed < 1500; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const RandomMesh mesh = testing::random_mesh(seed);
    std::mt19937 random(seed);
    std::vector<std::uint8_t> excluded(mesh.triangles.size(), 0);
    if (seed % 3 == 0)
      for (auto& e : excluded) e = random() % 8 == 0;
    const std::vector<double> levels =
        seed % 2 == 0 ? rank_values(mesh.values, 1).levels : std::vector<double>{-1, 0, 2};
    const Built built =
        build(mesh.triangles, mesh.positions.size(),
              levels_of_triangles(mesh.triangles, levels_of_vertices(mesh.values, levels, 1), excluded), excluded);
    // Some nodes, under numbers in no order of theirs.
    std::vector<std::int32_t> numbers(built.tree.num_nodes());
    std::iota(numbers.begin(), numbers.end(), 1);
    std::shuffle(numbers.begin(), numbers.end(), random);
    for (std::int32_t& number : numbers)
      if (random() % 4 == 0) number = 0;
    std::vector<std::int32_t> behind(mesh.triangles.size());
    std::iota(behind.begin(), behind.end(), 0);
    const SurfaceView surface{mesh.positions, mesh.triangles, built.twins};
    const BorderLoops loops = extract_borders(surface, built.tree, numbers, behind);
    std::int64_t rims = 0;
    for (std::size_t node = 0; node < numbers.size(); ++node) {
      if (numbers[node] == 0) continue;
      EXPECT_EQ(check_border_loops(mesh.positions, mesh.triangles, excluded,
                                   members(built.tree, static_cast<std::int32_t>(node)), loops, numbers[node], &rims),
                "")
          << "node " << node;
    }
    EXPECT_EQ(loops.num_hole_loops_dropped, rims);
    for (std::size_t i = 0; i < loops.half_edges.size(); ++i) {
      const std::int32_t twin = built.twins[static_cast<std::size_t>(loops.half_edges[i])];
      ASSERT_EQ(loops.neighbours[i], twin < 0 ? -1 : twin / 3);
    }
  }
}

TEST(ExtractLabelBorders, RandomLabelsPassTheChecker) {
  for (std::uint32_t seed = 0; seed < 500; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const RandomMesh mesh = testing::random_mesh(seed);
    std::mt19937 random(seed);
    std::vector<std::int32_t> labels(mesh.triangles.size());
    for (std::size_t t = 0; t < labels.size(); ++t)
      labels[t] = static_cast<std::int32_t>(mesh.values[static_cast<std::size_t>(mesh.triangles[t][0])]) % 3 + 2 -
                  static_cast<std::int32_t>(random() % 8 == 0);
    for (std::int32_t& label : labels) label = std::max(label, 0);
    const std::vector<std::int32_t> twins = twin_half_edges(mesh.triangles, mesh.positions.size());
    const BorderLoops loops = extract_label_borders({mesh.positions, mesh.triangles, twins}, labels);
    std::int64_t rims = 0;
    for (std::int32_t label = 1; label <= 4; ++label) {
      std::vector<std::uint8_t> inside;
      for (const std::int32_t l : labels) inside.push_back(l == label);
      // A label of several patches: each patch has its own loops, so that what is fenced off is checked only where
      // every patch has one.
      const std::string problem = check_border_loops(mesh.positions, mesh.triangles, {}, inside, loops, label, &rims);
      EXPECT_TRUE(problem.empty() || problem.ends_with("is not enclosed")) << problem;
    }
    EXPECT_EQ(loops.num_hole_loops_dropped, rims);
    for (std::size_t i = 0; i < loops.half_edges.size(); ++i) {
      const std::int32_t twin = twins[static_cast<std::size_t>(loops.half_edges[i])];
      ASSERT_EQ(loops.neighbours[i], twin < 0 ? -1 : labels[static_cast<std::size_t>(twin / 3)]);
    }
  }
}

TEST(ExtractBorders, SameBytesOnAnyThreads) {
  // Large enough for many groups of regions: a sheet of random heights.
  const std::int32_t n = 150;
  Triangles triangles;
  std::vector<Eigen::Vector3d> positions;
  std::vector<double> values;
  std::mt19937 random(1);
  for (std::int32_t i = 0; i < (n + 1) * (n + 1); ++i) {
    positions.emplace_back(i % (n + 1), i / (n + 1), 0);
    values.push_back(static_cast<double>(random() % 1000));
  }
  for (std::int32_t y = 0; y < n; ++y)
    for (std::int32_t x = 0; x < n; ++x) {
      const std::int32_t a = y * (n + 1) + x;
      triangles.push_back({a, a + 1, a + n + 2});
      triangles.push_back({a, a + n + 2, a + n + 1});
    }
  const Built built =
      build(triangles, positions.size(), levels_of_triangles(triangles, rank_values(values, 1).level_of_vertex, {}));
  std::vector<std::int32_t> numbers(built.tree.num_nodes());
  std::iota(numbers.begin(), numbers.end(), 1);
  const std::vector<std::int32_t> behind(triangles.size(), 0);
  std::vector<BorderLoops> results;
  for (const int threads : {1, 2, 7}) {
    Execution execution;
    execution.threads = threads;
    results.push_back(extract_borders({positions, triangles, built.twins}, built.tree, numbers, behind, execution));
  }
  ASSERT_GT(results[0].half_edges.size(), 500000u);
  for (const BorderLoops& other : results) {
    EXPECT_EQ(other.owner_of_loop, results[0].owner_of_loop);
    EXPECT_EQ(other.half_edges, results[0].half_edges);
    EXPECT_EQ(other.neighbours, results[0].neighbours);
    EXPECT_EQ(other.kinds, results[0].kinds);
    EXPECT_EQ(other.first_edge_of_loop, results[0].first_edge_of_loop);
    EXPECT_EQ(other.level_length_of_loop, results[0].level_length_of_loop);
    EXPECT_EQ(other.hole_length_of_loop, results[0].hole_length_of_loop);
  }
}

TEST(ExtractBorders, PinchedVertexPartsTheLoopsInsideTheRegion) {
  // A closed fan of six around vertex 0.
  Triangles triangles;
  std::vector<Eigen::Vector3d> positions{{0, 0, 0}};
  for (std::int32_t i = 0; i < 6; ++i) {
    triangles.push_back({0, i + 1, (i + 1) % 6 + 1});
    positions.emplace_back(std::cos(i * M_PI / 3), std::sin(i * M_PI / 3), 0);
  }
  // High everywhere but at triangles 0 and 3: two regions that meet in the hub alone.
  const Built built = build(triangles, 7, {1, 2, 2, 1, 2, 2});
  ASSERT_THAT(built.tree.hi_of_node, ElementsAre(2, 2, 1));
  const BorderLoops loops = extract_borders({positions, triangles, built.twins}, built.tree,
                                            std::vector<std::int32_t>{2, 1, 3}, std::vector<std::int32_t>(6, 3));
  EXPECT_THAT(loops.owner_of_loop, ElementsAre(1, 2));
  EXPECT_THAT(loops.half_edges, ElementsAre(3, 4, 7, 8, 12, 13, 16, 17));
  EXPECT_EQ(loops.num_hole_loops_dropped, 1);
  EXPECT_NEAR(loops.level_length_of_loop[0], 2, 1e-12);
  EXPECT_NEAR(loops.hole_length_of_loop[0], 2, 1e-12);
  EXPECT_THAT(loops.neighbours, ElementsAre(3, -1, -1, 3, 3, -1, -1, 3));
}

TEST(ExtractBorders, ARegionPinchedAtOneVertexHasOneLoopThatDoesNotCross) {
  // A closed double cone whose high part is all but two opposite triangles of the upper cone.
  Triangles triangles;
  std::vector<Eigen::Vector3d> positions{{0, 0, 1}, {0, 0, -1}};
  std::vector<std::int32_t> levels;
  for (std::int32_t i = 0; i < 6; ++i) {
    positions.emplace_back(std::cos(i * M_PI / 3), std::sin(i * M_PI / 3), 0);
    triangles.push_back({i + 2, (i + 1) % 6 + 2, 0});
    triangles.push_back({(i + 1) % 6 + 2, i + 2, 1});
    levels.insert(levels.end(), {i % 3 == 0 ? 1 : 2, 2});
  }
  const Built built = build(triangles, positions.size(), levels);
  ASSERT_THAT(built.tree.hi_of_node, ElementsAre(2, 1));
  const BorderLoops loops = extract_borders({positions, triangles, built.twins}, built.tree,
                                            std::vector<std::int32_t>{1, 0}, std::vector<std::int32_t>(12, 0));
  // Two inner loops would be the complement's choice; rotating inside the region links them at the apex.
  EXPECT_EQ(loops.num_loops(), 1u);
  EXPECT_EQ(loops.half_edges.size(), 6u);
  EXPECT_EQ(check_border_loops(positions, triangles, {}, members(built.tree, 0), loops, 1), "");
}

TEST(ExtractBorders, NothingSelectedNothingFound) {
  const Triangles triangles{{0, 1, 2}};
  const Built built = build(triangles, 3, {1});
  const std::vector<Eigen::Vector3d> positions{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const BorderLoops none = extract_borders({positions, triangles, built.twins}, built.tree,
                                           std::vector<std::int32_t>{0}, std::vector<std::int32_t>{0});
  EXPECT_EQ(none.num_loops(), 0u);
  EXPECT_EQ(none.num_hole_loops_dropped, 0);
  const BorderLoops root = extract_borders({positions, triangles, built.twins}, built.tree,
                                           std::vector<std::int32_t>{1}, std::vector<std::int32_t>{1});
  EXPECT_EQ(root.num_loops(), 0u);
  EXPECT_EQ(root.num_hole_loops_dropped, 1);
}

TEST(MergeBorders, LoopsStandByOwner) {
  BorderLoops a, b;
  a.owner_of_loop = {1, 1, 4};
  a.first_edge_of_loop = {0, 1, 2, 3};
  a.half_edges = {10, 11, 12};
  b.owner_of_loop = {2};
  b.first_edge_of_loop = {0, 2};
  b.half_edges = {20, 21};
  for (BorderLoops* loops : {&a, &b}) {
    loops->kinds.assign(loops->half_edges.size(), EdgeKind::kLevel);
    loops->neighbours.assign(loops->half_edges.size(), 0);
    loops->level_length_of_loop.assign(loops->num_loops(), 1);
    loops->hole_length_of_loop.assign(loops->num_loops(), 0);
    loops->num_hole_loops_dropped = 3;
  }
  const BorderLoops merged = merge_borders(a, b);
  EXPECT_THAT(merged.owner_of_loop, ElementsAre(1, 1, 2, 4));
  EXPECT_THAT(merged.half_edges, ElementsAre(10, 11, 20, 21, 12));
  EXPECT_THAT(merged.first_edge_of_loop, ElementsAre(0, 1, 2, 4, 5));
  EXPECT_EQ(merged.num_hole_loops_dropped, 6);
}

}  // namespace
}  // namespace meshmser
