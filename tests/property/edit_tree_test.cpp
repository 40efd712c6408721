/// Cutting, simplifying and reading back against the definitions, on random small meshes.

#include "stages/tree/edit_tree.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "stages/common/adjacency.hpp"
#include "stages/common/maxima.hpp"
#include "stages/common/surface.hpp"
#include "stages/common/tree_nodes.hpp"
#include "stages/tree/component_tree.hpp"
#include "stages/tree/levels.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/random_mesh.hpp"

namespace meshmser {
namespace {

using oracle::Triangles;

struct Scene {
  testing::RandomMesh mesh;
  std::vector<double> levels;
  std::vector<std::int32_t> twins;
  std::vector<double> areas;
  ComponentTree tree;
  oracle::Surface surface;
  std::vector<oracle::Node> nodes;
};

ComponentTree tree_of(const Scene& scene, const std::vector<std::int32_t>& level_of_triangle, Polarity polarity) {
  ComponentTree tree =
      build_component_tree(scene.twins, scene.areas, level_of_triangle, static_cast<std::int32_t>(scene.levels.size()));
  tree.polarity = polarity;
  tree.levels = scene.levels;
  return tree;
}

Scene make_scene(std::uint32_t seed, Polarity polarity) {
  std::mt19937_64 random(seed);
  Scene scene;
  scene.mesh = testing::random_mesh(seed);
  for (int k = -6; k <= 6; ++k)
    if (random() % 3 != 0) scene.levels.push_back(k);
  if (scene.levels.empty() || random() % 2 == 0)
    scene.levels.insert(scene.levels.begin(), -std::numeric_limits<double>::infinity());
  scene.twins = twin_half_edges(scene.mesh.triangles, scene.mesh.positions.size());
  scene.areas = triangle_areas(scene.mesh.positions, scene.mesh.triangles);
  for (double& area : scene.areas) area = 0.5 * std::round(2 * area);
  const int sign = polarity == Polarity::kLower ? -1 : 1;
  std::vector<double> signed_values = scene.mesh.values;
  for (double& value : signed_values) value *= sign;
  for (std::size_t t = 0; t < scene.areas.size(); ++t) {
    const auto& corners = scene.mesh.triangles[t];
    scene.surface.corners.push_back({corners[0], corners[1], corners[2]});
    scene.surface.cut_out.push_back(false);
    scene.surface.level.push_back(oracle::level_of(scene.surface.corners.back(), signed_values, scene.levels));
    scene.surface.area.push_back(static_cast<std::int64_t>(2 * scene.areas[t]));
  }
  scene.surface.num_levels = static_cast<int>(scene.levels.size());
  scene.tree = tree_of(scene, {scene.surface.level.begin(), scene.surface.level.end()}, polarity);
  scene.nodes = oracle::all_nodes(scene.surface);
  return scene;
}

std::int64_t area_of(const oracle::Surface& surface, const Triangles& triangles) {
  std::int64_t sum = 0;
  for (const int t : triangles) sum += surface.area[static_cast<std::size_t>(t)];
  return sum;
}

/// The level of each triangle when only components that `stays` have a level above their root's.
template <class Stays>
std::vector<std::int32_t> razed_levels(const Scene& scene, Stays stays) {
  std::vector<std::int32_t> levels(scene.surface.level.size(), 0);
  for (const oracle::Node& node : scene.nodes)
    if (node.parent < 0 || stays(node))
      for (const int t : node.triangles) {
        std::int32_t& level = levels[static_cast<std::size_t>(t)];
        level = std::max(level, node.hi);
      }
  return levels;
}

void expect_same_tree(const ComponentTree& a, const ComponentTree& b) {
  EXPECT_EQ(rebuild_levels(a), rebuild_levels(b));
  ASSERT_EQ(a.num_nodes(), b.num_nodes());
  // The order of siblings may differ: nodes are matched by the triangles of their own.
  std::vector<std::int32_t> match(a.num_nodes(), -1);
  for (std::size_t t = 0; t < a.node_of_triangle.size(); ++t)
    if (a.node_of_triangle[t] >= 0) {
      std::int32_t& other = match[static_cast<std::size_t>(a.node_of_triangle[t])];
      if (other < 0) other = b.node_of_triangle[t];
      EXPECT_EQ(other, b.node_of_triangle[t]);
    }
  for (std::size_t n = 0; n < a.num_nodes(); ++n) {
    const auto m = static_cast<std::size_t>(match[n]);
    ASSERT_LT(m, b.num_nodes());
    EXPECT_EQ(a.hi_of_node[n], b.hi_of_node[m]);
    EXPECT_EQ(area_of_node(a, static_cast<std::int32_t>(n)), area_of_node(b, match[n]));
    const std::int32_t p = a.parent_of_node[n], q = b.parent_of_node[m];
    ASSERT_EQ(p < 0, q < 0);
    if (p >= 0) {
      EXPECT_EQ(match[static_cast<std::size_t>(p)], q);
      EXPECT_GT(p, static_cast<std::int32_t>(n));
    }
    // A subtree is the interval first .. n.
    for (std::int32_t d = 0; d < static_cast<std::int32_t>(a.num_nodes()); ++d) {
      std::int32_t up = d;
      while (up >= 0 && up != static_cast<std::int32_t>(n)) up = a.parent_of_node[static_cast<std::size_t>(up)];
      EXPECT_EQ(up >= 0, a.first_node_of_subtree[n] <= d && d <= static_cast<std::int32_t>(n));
    }
  }
}

void check_cuts(const Scene& scene) {
  const auto neighbours = oracle::neighbours_of(scene.surface);
  for (int k = 1; k <= scene.surface.num_levels; ++k) {
    const TreeCut cut = cut_tree(scene.tree, k);
    Triangles above;
    for (std::size_t t = 0; t < scene.surface.level.size(); ++t) {
      EXPECT_EQ(cut.component_of_triangle[t] > 0, scene.surface.level[t] >= k);
      if (scene.surface.level[t] >= k) above.insert(static_cast<int>(t));
    }
    const std::vector<Triangles> parts = oracle::connected_parts(neighbours, above);
    ASSERT_EQ(parts.size(), cut.nodes.size());
    std::set<std::int32_t> numbers;
    for (const Triangles& part : parts) {
      const std::int32_t number = cut.component_of_triangle[static_cast<std::size_t>(*part.begin())];
      EXPECT_TRUE(numbers.insert(number).second) << "two components bear one number";
      for (const int t : part) EXPECT_EQ(cut.component_of_triangle[static_cast<std::size_t>(t)], number);
      EXPECT_EQ(2 * area_of_node(scene.tree, cut.nodes[static_cast<std::size_t>(number) - 1]),
                static_cast<double>(area_of(scene.surface, part)));
    }
    for (std::size_t i = 1; i < cut.nodes.size(); ++i)
      EXPECT_GE(area_of_node(scene.tree, cut.nodes[i - 1]), area_of_node(scene.tree, cut.nodes[i]));
    const double sign = scene.tree.polarity == Polarity::kLower ? -1 : 1;
    EXPECT_EQ(level_of_value(scene.tree, sign * scene.levels[static_cast<std::size_t>(k) - 1]), k);
  }
}

class EditTree : public ::testing::TestWithParam<Polarity> {};

TEST_P(EditTree, AgreesWithTheDefinitionsOnRandomMeshes) {
  for (std::uint32_t seed = 1; seed <= 1500; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Scene scene = make_scene(seed, GetParam());
    const ComponentTree& tree = scene.tree;
    check_cuts(scene);

    for (const double min_area : {0.0, 1.0, 2.5, 6.0}) {
      const ComponentTree opened = simplify_tree(tree, nodes_of_area(tree, min_area));
      const auto levels = razed_levels(scene, [&](const oracle::Node& node) {
        return static_cast<double>(area_of(scene.surface, node.triangles)) >= 2 * min_area;
      });
      expect_same_tree(opened, tree_of(scene, levels, tree.polarity));
    }

    const std::vector<double> heights = finite_levels(tree.levels);
    const auto lifetimes = oracle::lifetimes(scene.nodes, heights);
    for (const double min_persistence : {0.5, 2.0, 4.0}) {
      const ComponentTree flattened = simplify_tree(tree, nodes_of_persistence(tree, min_persistence));
      // A node stays where a maximum within it lasts long enough and is the highest of the node.
      const auto levels = razed_levels(scene, [&](const oracle::Node& node) {
        for (const auto& [leaf, life] : lifetimes)
          if (life.persistence >= min_persistence &&
              std::includes(node.triangles.begin(), node.triangles.end(), leaf.begin(), leaf.end()) &&
              std::includes(life.top.begin(), life.top.end(), node.triangles.begin(), node.triangles.end()))
            return true;
        return false;
      });
      expect_same_tree(flattened, tree_of(scene, levels, tree.polarity));
      const Maxima left = find_maxima(flattened);
      for (std::size_t n = 0; n < flattened.num_nodes(); ++n)
        if (const std::int32_t top = left.top_of_leaf[n];
            top >= 0 && flattened.parent_of_node[static_cast<std::size_t>(top)] >= 0) {
          EXPECT_GE(left.persistence_of_leaf[n], min_persistence);
        }
    }

    // Levels laid over the reconstructed values give the tree back.
    const std::vector<double> of_triangle = reconstruct_triangle_values(tree);
    for (std::size_t t = 0; t < of_triangle.size(); ++t) {
      ASSERT_EQ(std::isnan(of_triangle[t]), scene.surface.level[t] == 0);
      if (!std::isnan(of_triangle[t])) {
        EXPECT_EQ(level_of_value(tree, of_triangle[t]), scene.surface.level[t]);
      }
    }
    const std::vector<double> of_vertex =
        reconstruct_vertex_values(tree, of_triangle, scene.mesh.triangles, scene.mesh.positions.size());
    const std::vector<std::int32_t> again =
        levels_of_triangles(scene.mesh.triangles,
                            levels_of_vertices(of_vertex, tree.levels, tree.polarity == Polarity::kLower ? -1 : 1), {});
    EXPECT_EQ(again, rebuild_levels(tree));
    if (HasFailure()) return;
  }
}

INSTANTIATE_TEST_SUITE_P(BothPolarities, EditTree, ::testing::Values(Polarity::kUpper, Polarity::kLower));

TEST(ReconstructTriangleValues, OneFiniteLevelStandsApart) {
  ComponentTree tree;
  tree.levels = {-std::numeric_limits<double>::infinity(), 3};
  tree.parent_of_node = {1, -1};
  tree.hi_of_node = {2, 1};
  tree.node_of_triangle = {0, 1, -1};
  const std::vector<double> values = reconstruct_triangle_values(tree);
  EXPECT_EQ(level_of_value(tree, values[0]), 2);
  EXPECT_EQ(level_of_value(tree, values[1]), 1);
  EXPECT_TRUE(std::isfinite(values[1]) && std::isnan(values[2]));
}

TEST(SimplifyTree, RefusesWhatLeavesNoTree) {
  ComponentTree tree;
  tree.parent_of_node = {1, 2, -1};
  tree.hi_of_node = {3, 2, 1};
  tree.area_of_node = {1, 2, 3};
  tree.area_exponent_of_node = {0, 0, 0};
  tree.first_node_of_subtree = {0, 0, 0};
  EXPECT_THROW(simplify_tree(tree, std::vector<std::uint8_t>{1, 1}), StageError);
  EXPECT_THROW(simplify_tree(tree, std::vector<std::uint8_t>{0, 0, 0}), StageError);
  EXPECT_THROW(simplify_tree(tree, std::vector<std::uint8_t>{1, 0, 1}), StageError);
  EXPECT_EQ(simplify_tree(tree, std::vector<std::uint8_t>{0, 1, 1}).parent_of_node, (std::vector<std::int32_t>{1, -1}));
}

}  // namespace
}  // namespace meshmser
