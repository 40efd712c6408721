#include "stages/tree/level_set_trees.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "pipeline/execution/error.hpp"
#include "stages/tree/component_tree.hpp"

namespace meshmser {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// An n x n sheet of unit squares with a scalar on it.
TriangleMesh sheet(std::int32_t n) {
  TriangleMesh mesh;
  for (std::int32_t y = 0; y <= n; ++y)
    for (std::int32_t x = 0; x <= n; ++x) {
      mesh.point_of_vertex.push_back(static_cast<std::int32_t>(mesh.positions.size()));
      mesh.positions.emplace_back(x, y, 0);
    }
  for (std::int32_t y = 0; y < n; ++y)
    for (std::int32_t x = 0; x < n; ++x) {
      const std::int32_t a = y * (n + 1) + x;
      mesh.triangles.push_back({a, a + 1, a + n + 2});
      mesh.triangles.push_back({a, a + n + 2, a + n + 1});
    }
  mesh.turned_of_vertex.assign(mesh.positions.size(), 0);
  return mesh;
}

VertexScalar scalar_on(const TriangleMesh& mesh, const std::function<double(double, double)>& f) {
  VertexScalar scalar;
  scalar.name = "quality";
  for (const auto& p : mesh.positions) scalar.values.push_back(f(p[0], p[1]));
  return scalar;
}

std::string message_of(const std::function<void()>& body) {
  try {
    body();
  } catch (const StageError& error) {
    return error.what();
  }
  return "";
}

TEST(BuildLevelSetTrees, LowerIsUpperOfTheNegative) {
  const TriangleMesh mesh = sheet(9);
  const VertexScalar scalar =
      scalar_on(mesh, [](double x, double y) { return std::sin(x) * std::cos(2 * y) + 0.1 * x; });
  LevelSetTreesParameters both, negated;
  negated.transform = ScalarTransform::kNegate;
  for (const LevelRule rule : {LevelRule::kLinear, LevelRule::kEveryValue, LevelRule::kEqualArea}) {
    both.levels.rule = negated.levels.rule = rule;
    const LevelSetTrees a = build_level_set_trees(mesh, scalar, both).trees;
    const LevelSetTrees b = build_level_set_trees(mesh, scalar, negated).trees;
    ASSERT_EQ(a.trees.size(), 2u);
    EXPECT_EQ(a.trees[1].levels, b.trees[0].levels);
    EXPECT_EQ(a.trees[1].parent_of_node, b.trees[0].parent_of_node);
    EXPECT_EQ(a.trees[1].node_of_triangle, b.trees[0].node_of_triangle);
    EXPECT_EQ(a.trees[1].area_of_node, b.trees[0].area_of_node);
    EXPECT_EQ(a.trees[1].polarity, Polarity::kLower);
  }
}

TEST(BuildLevelSetTrees, AMonotoneChangeOfTheScalarKeepsTheTreeOfEveryValue) {
  const TriangleMesh mesh = sheet(9);
  LevelSetTreesParameters parameters;
  parameters.levels.rule = LevelRule::kEveryValue;
  auto f = [](double x, double y) { return std::sin(x) * std::cos(2 * y) + 0.1 * x; };
  const LevelSetTrees a = build_level_set_trees(mesh, scalar_on(mesh, f), parameters).trees;
  const LevelSetTrees b =
      build_level_set_trees(mesh, scalar_on(mesh, [&](double x, double y) { return std::exp(3 * f(x, y)); }),
                            parameters)
          .trees;
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(a.trees[i].parent_of_node, b.trees[i].parent_of_node);
    EXPECT_EQ(a.trees[i].hi_of_node, b.trees[i].hi_of_node);
    EXPECT_EQ(a.trees[i].node_of_triangle, b.trees[i].node_of_triangle);
  }
}

TEST(BuildLevelSetTrees, TransformsAndChoiceOfPolarity) {
  const TriangleMesh mesh = sheet(2);
  const VertexScalar scalar = scalar_on(mesh, [](double x, double) { return x - 1; });
  LevelSetTreesParameters parameters;
  parameters.polarity = PolarityChoice::kLower;
  parameters.transform = ScalarTransform::kNegateAbs;
  const LevelSetTrees trees = build_level_set_trees(mesh, scalar, parameters).trees;
  EXPECT_THAT(trees.values, ElementsAre(-1, 0, -1, -1, 0, -1, -1, 0, -1));
  ASSERT_EQ(trees.trees.size(), 1u);
  EXPECT_EQ(trees.trees[0].polarity, Polarity::kLower);
  EXPECT_EQ(trees.scalar, "quality");
}

TEST(BuildLevelSetTrees, ExcludedTrianglesAreInNoNodeAndLeaveTheLevels) {
  const TriangleMesh mesh = sheet(12);
  // Huge values at the rim alone.
  const VertexScalar scalar = scalar_on(mesh, [](double x, double y) {
    return std::min({x, y, 12 - x, 12 - y}) < 1 ? 1e6 : std::sin(x) + y / 12;
  });
  LevelSetTreesParameters parameters;
  parameters.exclude_rim = 0.5;
  parameters.levels.low_quantile = 0;
  parameters.levels.high_quantile = 1;
  const LevelSetTreesResult result = build_level_set_trees(mesh, scalar, parameters);
  EXPECT_EQ(result.exclusion.num_near_rim, 2 * (144 - 100));
  for (const ComponentTree& tree : result.trees.trees) {
    EXPECT_LT(std::abs(tree.levels.back()), 3);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      EXPECT_EQ(tree.node_of_triangle[t] < 0, result.trees.excluded_of_triangle[t] != 0);
  }
}

TEST(BuildLevelSetTrees, DetrendingTakesASlopeAway) {
  const TriangleMesh mesh = sheet(40);
  const VertexScalar scalar = scalar_on(mesh, [](double x, double y) { return 5 * x - 3 * y; });
  LevelSetTreesParameters parameters;
  parameters.detrend = 8;
  const LevelSetTrees trees = build_level_set_trees(mesh, scalar, parameters).trees;
  for (std::size_t v = 0; v < mesh.num_vertices(); ++v) {
    const auto& p = mesh.positions[v];
    if (std::min({p[0], p[1], 40 - p[0], 40 - p[1]}) > 9) {
      EXPECT_NEAR(trees.values[v], 0, 0.5) << v;
    }
  }
}

TEST(BuildLevelSetTrees, AClippedMeanIsNotTiltedByASharpEdge) {
  const TriangleMesh mesh = sheet(40);
  const VertexScalar scalar =
      scalar_on(mesh, [](double x, double y) { return x == 20 ? 1000.0 : std::sin(1.7 * x) * std::cos(2.3 * y); });
  LevelSetTreesParameters parameters;
  parameters.detrend = 8;
  const auto lowest = [&] {
    const LevelSetTrees trees = build_level_set_trees(mesh, scalar, parameters).trees;
    return *std::min_element(trees.values.begin(), trees.values.end());
  };
  EXPECT_LT(lowest(), -20);
  parameters.detrend_clip = 2;
  EXPECT_GT(lowest(), -1.5);
}

TEST(BuildLevelSetTrees, NanIsAnErrorInAGivenScalarAndLeftOutOfAMeasuredOne) {
  const TriangleMesh mesh = sheet(4);
  VertexScalar scalar = scalar_on(mesh, [](double x, double) { return x; });
  scalar.values[7] = std::nan("");
  scalar.values[9] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(build_level_set_trees(mesh, scalar, {}).exclusion.num_nan, 9);
  scalar.is_given = true;
  EXPECT_THAT(message_of([&] { build_level_set_trees(mesh, scalar, {}); }),
              HasSubstr("the scalar 'quality' is not finite at the vertex 2,1,0 and 1 more; mend it"));
  LevelSetTreesParameters exclude;
  exclude.nan = NanPolicy::kExclude;
  EXPECT_EQ(build_level_set_trees(mesh, scalar, exclude).exclusion.num_nan, 9);
}

TEST(BuildLevelSetTrees, NoiseLevelsTakeTheScalarsOwnNoise) {
  const TriangleMesh mesh = sheet(4);
  VertexScalar scalar = scalar_on(mesh, [](double x, double) { return x; });
  LevelSetTreesParameters parameters;
  parameters.levels.rule = LevelRule::kNoise;
  EXPECT_THAT(message_of([&] { build_level_set_trees(mesh, scalar, parameters); }), HasSubstr("noise"));
  scalar.noise = 0.1;
  EXPECT_DOUBLE_EQ(build_level_set_trees(mesh, scalar, parameters).trees.noise, 0.1);
  parameters.levels.noise = 0.2;
  EXPECT_DOUBLE_EQ(build_level_set_trees(mesh, scalar, parameters).trees.noise, 0.2);
}

double bump_and_dent(double x, double y) {
  const auto within = [&](double cx, double cy, double r) { return std::max(std::abs(x - cx), std::abs(y - cy)) <= r; };
  if (within(4, 6, 2)) return 3;
  if (within(13, 6, 1)) return -1;
  if (within(13, 6, 4)) return -2;
  return 0;
}

TEST(BuildLevelSetTrees, ShapesAreBrightAndDarkWithinEachOther) {
  TriangleMesh mesh = sheet(18);
  LevelSetTreesParameters parameters;
  parameters.polarity = PolarityChoice::kShapes;
  for (const LevelRule rule : {LevelRule::kEveryValue, LevelRule::kLinear, LevelRule::kList, LevelRule::kEqualArea}) {
    parameters.levels.rule = rule;
    parameters.levels.list = {-1.5, -0.5, 0.5};
    parameters.levels.low_quantile = 0;
    parameters.levels.high_quantile = 1;
    const LevelSetTrees of = build_level_set_trees(mesh, scalar_on(mesh, bump_and_dent), parameters).trees;
    ASSERT_EQ(of.trees.size(), 1u);
    const ComponentTree& tree = of.trees[0];
    EXPECT_EQ(tree.polarity, Polarity::kShapes);
    ASSERT_EQ(tree.num_nodes(), 4u);
    // By area: the bump in the dent, the bump, the dent, the sheet.
    std::vector<std::int32_t> nodes = {0, 1, 2, 3};
    std::sort(nodes.begin(), nodes.end(), [&](std::int32_t a, std::int32_t b) {
      return tree.area_of_node[static_cast<std::size_t>(a)] < tree.area_of_node[static_cast<std::size_t>(b)];
    });
    EXPECT_EQ(tree.parent_of_node[static_cast<std::size_t>(nodes[0])], nodes[2]);
    EXPECT_EQ(tree.parent_of_node[static_cast<std::size_t>(nodes[1])], 3);
    EXPECT_EQ(tree.parent_of_node[static_cast<std::size_t>(nodes[2])], 3);
    EXPECT_EQ(tree.side(nodes[0]), Polarity::kUpper);
    EXPECT_EQ(tree.side(nodes[1]), Polarity::kUpper);
    EXPECT_EQ(tree.side(nodes[2]), Polarity::kLower);
    for (int i = 0; i < 3; ++i) {
      // The line lies between what is within and what is around.
      const double within[] = {-1, 3, -2}, around[] = {-2, 0, 0};
      const double line = tree.value(nodes[static_cast<std::size_t>(i)]);
      EXPECT_EQ(within[i] >= line, i < 2) << i;
      EXPECT_EQ(around[i] >= line, i == 2) << i;
    }
    // Turned over, what was bright is dark.
    parameters.transform = ScalarTransform::kNegate;
    const ComponentTree negative =
        build_level_set_trees(mesh, scalar_on(mesh, bump_and_dent), parameters).trees.trees[0];
    parameters.transform = ScalarTransform::kIdentity;
    if (rule == LevelRule::kList) continue;  // outright levels stay where they are
    ASSERT_EQ(negative.num_nodes(), 4u);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const std::int32_t a = tree.node_of_triangle[t], b = negative.node_of_triangle[t];
      EXPECT_EQ(tree.area_of_node[static_cast<std::size_t>(a)], negative.area_of_node[static_cast<std::size_t>(b)]);
      if (tree.parent_of_node[static_cast<std::size_t>(a)] >= 0) {
        EXPECT_NE(negative.side(b), tree.side(a));
      }
    }
  }
}

TEST(BuildLevelSetTrees, TheRootOfShapesIsWhereTheUserPutsIt) {
  TriangleMesh mesh = sheet(18);
  mesh.origin = {100, 0, 0};
  LevelSetTreesParameters parameters;
  parameters.polarity = PolarityChoice::kShapes;
  parameters.levels.rule = LevelRule::kEveryValue;
  EXPECT_EQ(build_level_set_trees(mesh, scalar_on(mesh, bump_and_dent), parameters).root_vertex, -1);
  // From within the dent all that lies around it is a shape, and the bump in it stays one.
  parameters.root = Eigen::Vector3d(10.2, 6.1, 5);
  const LevelSetTreesResult result = build_level_set_trees(mesh, scalar_on(mesh, bump_and_dent), parameters);
  EXPECT_EQ(result.root_vertex, 6 * 19 + 10);
  const ComponentTree& tree = result.trees.trees[0];
  ASSERT_EQ(tree.num_nodes(), 4u);
  const std::int32_t in_dent = tree.node_of_triangle[static_cast<std::size_t>(2 * (6 * 18 + 10))];
  const std::int32_t outside = tree.node_of_triangle[0];
  EXPECT_LT(tree.parent_of_node[static_cast<std::size_t>(in_dent)], 0);
  EXPECT_EQ(tree.parent_of_node[static_cast<std::size_t>(outside)], in_dent);
  EXPECT_EQ(tree.side(outside), Polarity::kUpper);
  EXPECT_EQ(tree.value(outside), -1);
  // A vertex that has left the mesh is no root.
  parameters.exclude_rim = 2.5;
  parameters.root = Eigen::Vector3d(0, 0, 0);
  EXPECT_EQ(build_level_set_trees(mesh, scalar_on(mesh, bump_and_dent), parameters).root_vertex, 3 * 19 + 3);
}

TEST(BuildLevelSetTrees, ExclusionAndDetrendingPrecedeTheShapesToo) {
  const TriangleMesh mesh = sheet(40);
  const VertexScalar tilted = scalar_on(mesh, [](double x, double y) {
    return 0.5 * x - 0.3 * y + (std::hypot(x - 20, y - 20) < 3 ? 20.0 : 0.0) +
           (std::hypot(x - 28, y - 20) < 2 ? -20.0 : 0.0);
  });
  LevelSetTreesParameters parameters;
  parameters.polarity = PolarityChoice::kShapes;
  parameters.detrend = 8;
  parameters.exclude_rim = 9;
  parameters.levels.rule = LevelRule::kList;
  parameters.levels.list = {-8, 8};
  const LevelSetTreesResult result = build_level_set_trees(mesh, tilted, parameters);
  const ComponentTree& tree = result.trees.trees[0];
  EXPECT_GT(result.exclusion.num_near_rim, 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    EXPECT_EQ(tree.node_of_triangle[t] < 0, result.trees.excluded_of_triangle[t] != 0);
  ASSERT_EQ(tree.num_nodes(), 3u);
  EXPECT_NE(tree.side(0), tree.side(1));
  // The slope alone would make a shape.
  parameters.detrend = 0;
  EXPECT_GT(build_level_set_trees(mesh, tilted, parameters).trees.trees[0].num_nodes(), 3u);
}

TEST(BuildLevelSetTrees, ShapesNeedASurfaceWithoutHandles) {
  TriangleMesh torus;
  for (std::int32_t i = 0; i < 36; ++i) {
    torus.positions.emplace_back(i, i * i, 0);
    const std::int32_t right = i / 6 * 6 + (i + 1) % 6, above = (i + 6) % 36, both = (right + 6) % 36;
    torus.triangles.push_back({i, right, both});
    torus.triangles.push_back({i, both, above});
  }
  LevelSetTreesParameters parameters;
  parameters.polarity = PolarityChoice::kShapes;
  EXPECT_EQ(message_of([&] {
              build_level_set_trees(torus, scalar_on(torus, [](double x, double) { return x; }), parameters);
            }),
            "the tree of shapes needs a surface without handles, but the component of triangle 0 has 1: on it a closed "
            "line need not part the inside from the outside; cut the handles open, or build an upper and a lower tree "
            "(polarity: both)");
}

TEST(BuildLevelSetTrees, EmptyMesh) {
  const LevelSetTrees trees = build_level_set_trees({}, {}, {}).trees;
  ASSERT_EQ(trees.trees.size(), 2u);
  EXPECT_EQ(trees.trees[0].num_nodes(), 0u);
  LevelSetTreesParameters shapes;
  shapes.polarity = PolarityChoice::kShapes;
  shapes.root = Eigen::Vector3d(0, 0, 0);
  EXPECT_EQ(build_level_set_trees({}, {}, shapes).trees.trees.at(0).num_nodes(), 0u);
}

class FindVertexScalar : public ::testing::Test {
 protected:
  FindVertexScalar() : mesh_(sheet(1)) {
    coarse_.fields.push_back({"mean_curvature", "1/unit", Parity::kOdd, 0.5, {1, 2, 3, 4}});
    coarse_.fields.push_back({"crease", "1/unit", Parity::kEven, 0.5, {5, 6, 7, 8}});
    fine_.fields.push_back({"mean_curvature", "1/unit", Parity::kOdd, 0.7, {-1, -2, -3, -4}});
    mesh_.point_of_vertex = {3, 2, 1, 0};
    mesh_.turned_of_vertex = {1, 0, 0, 0};
    mesh_.properties.push_back({"quality", ValueType::kFloat32, {9, 8, 7, 6}});
    cloud_.properties.push_back({"intensity", ValueType::kUint8, {10, 20, 30, 40}});
  }
  VertexScalar find(const std::string& name) const {
    const std::vector<StageFields> fields{{"curvature", &coarse_}, {"fine", &fine_}};
    return find_vertex_scalar(name, fields, mesh_, &cloud_);
  }

  TriangleMesh mesh_;
  PointCloud cloud_;
  ScalarFields coarse_, fine_;
};

TEST_F(FindVertexScalar, ReadsPointsAndTurnsOddFieldsAlone) {
  EXPECT_THAT(find("curvature.mean_curvature").values, ElementsAre(-4, 3, 2, 1));
  EXPECT_THAT(find("fine.mean_curvature").values, ElementsAre(4, -3, -2, -1));
  EXPECT_DOUBLE_EQ(find("fine.mean_curvature").noise, 0.7);
  EXPECT_THAT(find("crease").values, ElementsAre(8, 7, 6, 5));
  EXPECT_FALSE(find("crease").is_given);
}

TEST_F(FindVertexScalar, PropertiesOfMeshAndCloud) {
  EXPECT_THAT(find("quality").values, ElementsAre(9, 8, 7, 6));
  EXPECT_THAT(find("intensity").values, ElementsAre(40, 30, 20, 10));
  EXPECT_TRUE(find("intensity").is_given);
}

TEST_F(FindVertexScalar, NamesWhatThereIs) {
  EXPECT_EQ(message_of([&] { find("mean_curvature"); }),
            "several stages make the scalar 'mean_curvature': write curvature.mean_curvature or fine.mean_curvature");
  EXPECT_EQ(message_of([&] { find("heigth"); }),
            "there is no scalar 'heigth'; there are curvature.crease, curvature.mean_curvature, fine.mean_curvature, "
            "intensity and quality");
  EXPECT_THAT(message_of([&] { find_vertex_scalar("x", {}, TriangleMesh{}, nullptr); }), HasSubstr("nor any other"));
}

}  // namespace
}  // namespace meshmser
