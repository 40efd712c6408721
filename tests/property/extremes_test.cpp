/// The smallest, flattest, most crowded and largest meshes through tree, selection and borders.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "stages/borders/borders.hpp"
#include "stages/common/adjacency.hpp"
#include "stages/common/surface.hpp"
#include "stages/mser/label_triangles.hpp"
#include "stages/mser/select_mser.hpp"
#include "stages/tree/component_tree.hpp"
#include "stages/tree/levels.hpp"
#include "stages/tree/tree_of_shapes.hpp"

namespace meshmser {
namespace {

struct Mesh {
  std::vector<Eigen::Vector3d> positions;
  std::vector<double> values;
  std::vector<std::array<std::int32_t, 3>> triangles;
};

struct Result {
  ComponentTree tree;
  std::vector<SelectedNode> regions;
  std::vector<std::int32_t> labels;
  BorderLoops borders;
};

Result run(const Mesh& mesh, const std::vector<double>& levels, bool shapes = false) {
  const std::vector<std::int32_t> twins = twin_half_edges(mesh.triangles, mesh.positions.size());
  const std::vector<double> areas = triangle_areas(mesh.positions, mesh.triangles);
  const SurfaceView surface{mesh.positions, mesh.triangles, twins};
  const std::vector<std::int32_t> of_vertex = levels_of_vertices(mesh.values, levels, 1);
  Result result;
  result.tree = shapes ? build_tree_of_shapes(surface, areas, of_vertex, levels, {})
                       : build_component_tree(twins, areas, levels_of_triangles(mesh.triangles, of_vertex, {}),
                                              static_cast<std::int32_t>(levels.size()));
  if (!shapes) result.tree.levels = levels;
  const std::vector trees{result.tree};
  result.regions = order_regions(trees, std::array{select_mser(result.tree, {.delta = 1})});
  result.labels = label_triangles(trees, result.regions);
  result.borders = extract_borders(surface, result.tree, number_of_nodes(result.tree, result.regions), result.labels);
  return result;
}

const std::vector<double> kLevels = {-std::numeric_limits<double>::infinity(), 0.25, 0.5, 0.75};

/// A disk of triangles about vertex 0.
Mesh fan(std::int32_t around, const std::function<double(std::int32_t)>& value_at_rim) {
  Mesh mesh;
  mesh.positions.emplace_back(0, 0, 0);
  mesh.values.push_back(1);
  for (std::int32_t i = 0; i < around; ++i) {
    const double angle = 2 * std::numbers::pi * i / around;
    mesh.positions.emplace_back(std::cos(angle), std::sin(angle), 0);
    mesh.values.push_back(value_at_rim(i));
    mesh.triangles.push_back({0, i + 1, i + 1 == around ? 1 : i + 2});
  }
  return mesh;
}

constexpr std::int32_t kAround = 100'000;

TEST(Extremes, HalfAFanOfManyTriangles) {
  const Mesh mesh = fan(kAround, [](std::int32_t i) { return i < kAround / 2 ? 1 : 0; });
  for (const bool shapes : {false, true}) {
    const Result result = run(mesh, kLevels, shapes);
    ASSERT_EQ(result.regions.size(), 1u);
    ASSERT_EQ(result.borders.num_loops(), 1u);
    EXPECT_EQ(result.borders.half_edges.size(), static_cast<std::size_t>(kAround / 2) + 1);
    EXPECT_NEAR(result.borders.level_length_of_loop[0], 2, 1e-9);
    EXPECT_NEAR(result.borders.hole_length_of_loop[0], std::numbers::pi, 1e-4);
  }
}

TEST(Extremes, ManyRegionsAboutOneVertex) {
  // Every third triangle stands out: all of them meet at the middle, where no loop may cross to another.
  const Mesh mesh = fan(kAround - 1, [](std::int32_t i) { return i % 3 == 2 ? 0 : 1; });
  const Result result = run(mesh, kLevels);
  EXPECT_EQ(result.regions.size(), static_cast<std::size_t>(kAround / 3));
  EXPECT_EQ(result.borders.num_loops(), result.regions.size());
  for (std::size_t l = 0; l < result.borders.num_loops(); ++l)
    ASSERT_EQ(result.borders.first_edge_of_loop[l + 1] - result.borders.first_edge_of_loop[l], 3);
}

TEST(Extremes, NothingOneTriangleAndNoArea) {
  for (const bool shapes : {false, true}) {
    const Result none = run({}, kLevels, shapes);
    EXPECT_EQ(none.tree.num_nodes(), 0u);
    EXPECT_EQ(none.borders.num_loops(), 0u);

    Mesh one{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {0, 1, 1}, {{0, 1, 2}}};
    EXPECT_EQ(run(one, kLevels, shapes).tree.num_nodes(), 1u);
    EXPECT_TRUE(run(one, kLevels, shapes).regions.empty());
    // Apart from it a second triangle without area, and a vertex of no triangle.
    for (int i = 0; i < 4; ++i) {
      one.positions.emplace_back(5 + i, 5, 0);
      one.values.push_back(1);
    }
    one.triangles.push_back({3, 4, 5});
    const Result two = run(one, kLevels, shapes);
    ASSERT_EQ(two.tree.num_nodes(), 2u);
    EXPECT_EQ(two.tree.area_of_node[1], 0);
    EXPECT_EQ(two.labels, (std::vector<std::int32_t>{0, 0}));
  }
}

TEST(Extremes, AConstantScalarIsOneNode) {
  const Mesh mesh = fan(20, [](std::int32_t) { return 1; });
  for (const bool shapes : {false, true}) {
    const Result result = run(mesh, kLevels, shapes);
    EXPECT_EQ(result.tree.num_nodes(), 1u);
    EXPECT_TRUE(result.regions.empty());
  }
}

TEST(Extremes, TwoTrianglesOnThreeCorners) {
  const Mesh pillow{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {0, 1, 1}, {{0, 1, 2}, {2, 1, 0}}};
  EXPECT_EQ(twin_half_edges(pillow.triangles, 3), (std::vector<std::int32_t>{4, 3, 5, 1, 0, 2}));
  for (const bool shapes : {false, true}) EXPECT_EQ(run(pillow, kLevels, shapes).tree.num_nodes(), 1u);
}

TEST(Extremes, MoreTrianglesThanIdsAreRefused) {
  // Only the sizes are looked at.
  constexpr std::size_t kTooMany = std::size_t{715'827'882} + 1;
  const std::vector<std::int32_t> twin(1, -1);
  const std::vector<double> area(1, 1);
  const auto build = [&](std::size_t n) {
    return build_component_tree({twin.data(), 3 * n}, {area.data(), n}, {twin.data(), n}, 1);
  };
  try {
    build(kTooMany);
    FAIL();
  } catch (const StageError& error) {
    EXPECT_NE(std::string(error.what()).find("half-edge ids end at 715827882 triangles"), std::string::npos);
  }
  const std::array<std::int32_t, 3> triangle = {0, 1, 2};
  EXPECT_THROW(twin_half_edges({&triangle, kTooMany}, 3), StageError);
}

}  // namespace
}  // namespace meshmser
