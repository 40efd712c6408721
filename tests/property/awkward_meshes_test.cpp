/// Meshes that break careless programs, through tree, selection, labels, attributes, borders and curves.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "pipeline/execution/error.hpp"
#include "stages/borders/borders.hpp"
#include "stages/borders/curves.hpp"
#include "stages/common/adjacency.hpp"
#include "stages/mser/node_attributes.hpp"
#include "stages/mser/segment.hpp"
#include "stages/tree/component_tree.hpp"
#include "stages/tree/levels.hpp"

namespace meshmser {
namespace {

struct Mesh {
  std::vector<Eigen::Vector3d> positions;
  std::vector<std::array<std::int32_t, 3>> triangles;
  std::vector<double> values;
};

struct Result {
  std::vector<std::int32_t> twins;
  LevelSetTrees trees;
  Segmentation segmentation;
  BorderLoops borders, label_borders;
  BorderCurves curves;
  std::vector<NodeAttributes> attributes;  ///< of every node of the upper tree
};

/// All that the library makes of a mesh, for either polarity, with a level for each value or a list; half-edges in
/// `cut` have no twin.
Result run_all(const Mesh& mesh, Select select = Select::kLength, const std::vector<double>& list = {},
               const std::vector<std::size_t>& cut = {}) {
  Result result;
  result.twins = twin_half_edges(mesh.triangles, mesh.positions.size());
  for (const std::size_t h : cut) result.twins[h] = -1;
  const SurfaceView surface{mesh.positions, mesh.triangles, result.twins};
  const std::vector<double> areas = triangle_areas(mesh.positions, mesh.triangles);
  result.trees.values = mesh.values;
  for (const Polarity polarity : {Polarity::kUpper, Polarity::kLower}) {
    const bool lower = polarity == Polarity::kLower;
    LevelParameters levels;
    levels.rule = list.empty() ? LevelRule::kEveryValue : LevelRule::kList;
    levels.list = list;
    const std::vector<double> heights = make_levels(mesh.values, {}, levels, lower);
    ComponentTree tree = build_component_tree(
        result.twins, areas,
        levels_of_triangles(mesh.triangles, levels_of_vertices(mesh.values, heights, lower ? -1 : 1), {}),
        static_cast<std::int32_t>(heights.size()));
    tree.polarity = polarity;
    tree.levels = heights;
    result.trees.trees.push_back(std::move(tree));
  }
  SegmentParameters parameters;
  parameters.select = select;
  parameters.delta = 1;
  parameters.band = 0.05;
  parameters.level = 200;
  parameters.independent = 1;
  parameters.min_length = 0.1;
  parameters.grow = Grow::kAbsorb;
  parameters.absorb_area = 0.01;
  result.segmentation = segment({surface, result.trees, {}, {}, {}}, parameters);
  result.borders.first_edge_of_loop.push_back(0);
  std::vector<BorderRegion> regions;
  for (const Region& region : result.segmentation.regions)
    regions.push_back({&result.trees.trees[region.polarity == Polarity::kUpper ? 0 : 1], region.node});
  for (const ComponentTree& tree : result.trees.trees) {
    std::vector<std::int32_t> number(tree.num_nodes(), 0);
    for (std::size_t r = 0; r < regions.size(); ++r)
      if (regions[r].tree == &tree)
        number[static_cast<std::size_t>(regions[r].node)] = static_cast<std::int32_t>(r) + 1;
    result.borders =
        merge_borders(result.borders, extract_borders(surface, tree, number, result.segmentation.region_of_triangle));
  }
  result.label_borders = extract_label_borders(surface, result.segmentation.label_of_triangle);
  result.curves = interpolate_borders(surface, mesh.values, result.borders, regions);
  result.attributes = attributes_of_nodes(surface, result.trees.trees[0], mesh.values, areas);

  // What holds of any mesh: loops close, and their lengths are the regions' own.
  std::vector<double> level(regions.size() + 1, 0);
  for (std::size_t l = 0; l < result.borders.num_loops(); ++l) {
    level[static_cast<std::size_t>(result.borders.owner_of_loop[l])] += result.borders.level_length_of_loop[l];
    const auto begin = static_cast<std::size_t>(result.borders.first_edge_of_loop[l]);
    const auto end = static_cast<std::size_t>(result.borders.first_edge_of_loop[l + 1]);
    EXPECT_LT(begin, end);
    const auto corner = [&](std::int32_t h) {
      return mesh.triangles[static_cast<std::size_t>(h / 3)][static_cast<std::size_t>(h % 3)];
    };
    for (std::size_t e = begin; e < end; ++e)
      EXPECT_EQ(corner(next_half_edge(result.borders.half_edges[e])),
                corner(result.borders.half_edges[e + 1 < end ? e + 1 : begin]));
  }
  for (std::size_t r = 0; r < regions.size(); ++r)
    EXPECT_NEAR(result.segmentation.regions[r].level_length, level[r + 1], 1e-9 * level[r + 1]);
  EXPECT_EQ(result.curves.first_point_of_curve.size(), result.borders.num_loops() + 1);
  return result;
}

constexpr Select kSelections[] = {Select::kMser,   Select::kPersistence, Select::kStableBranch,
                                  Select::kLength, Select::kLevel,       Select::kMeaningful};

TEST(AwkwardMeshes, NoTriangle) {
  for (const Select select : kSelections) {
    const Result result = run_all({}, select);
    EXPECT_TRUE(result.segmentation.regions.empty());
    EXPECT_EQ(result.borders.num_loops(), 0U);
    EXPECT_TRUE(result.attributes.empty());
    // Vertices alone.
    EXPECT_TRUE(run_all({{{0, 0, 0}, {1, 0, 0}}, {}, {1, 2}}, select).segmentation.regions.empty());
  }
}

TEST(AwkwardMeshes, OneTriangle) {
  for (const Select select : kSelections) {
    const Result result = run_all({{{0, 0, 0}, {4, 0, 0}, {0, 3, 0}}, {{0, 1, 2}}, {1, 2, 3}}, select);
    EXPECT_TRUE(result.segmentation.regions.empty()) << "a root has no level border";
    ASSERT_EQ(result.attributes.size(), 1U);
    EXPECT_EQ(result.attributes[0].area, 6);
    EXPECT_DOUBLE_EQ(result.attributes[0].hole_length, 12);
    EXPECT_EQ(result.attributes[0].level_length, 0);
    EXPECT_EQ(result.attributes[0].euler, 1);
    EXPECT_DOUBLE_EQ(result.attributes[0].flatness(), 1);
    EXPECT_DOUBLE_EQ(result.attributes[0].scalar_mean, 2);
  }
}

Mesh sheet(std::int32_t n, double value) {
  Mesh mesh;
  for (std::int32_t y = 0; y <= n; ++y)
    for (std::int32_t x = 0; x <= n; ++x) mesh.positions.emplace_back(x, y, 0);
  for (std::int32_t y = 0; y < n; ++y)
    for (std::int32_t x = 0; x < n; ++x) {
      const std::int32_t a = y * (n + 1) + x;
      mesh.triangles.push_back({a, a + 1, a + n + 2});
      mesh.triangles.push_back({a, a + n + 2, a + n + 1});
    }
  mesh.values.assign(mesh.positions.size(), value);
  return mesh;
}

TEST(AwkwardMeshes, ConstantScalar) {
  for (const double value : {0.0, -7.5, 1e300, -1e300, 5e-324})
    for (const Select select : kSelections) {
      const Result result = run_all(sheet(6, value), select);
      EXPECT_TRUE(result.segmentation.regions.empty()) << value << ", select " << static_cast<int>(select);
      EXPECT_EQ(result.trees.trees[0].num_nodes(), 1U);
      EXPECT_EQ(result.attributes[0].scalar_deviation, 0);
    }
}

// Hourglass: two hills that meet in one vertex are two nodes, and their borders touch there but do not cross.
TEST(AwkwardMeshes, BowTie) {
  Mesh mesh = sheet(8, 0);
  // Two of the four squares about the middle vertex, those that no cut of a square joins.
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const double x = mesh.positions[v].x() - 4, y = mesh.positions[v].y() - 4;
    mesh.values[v] = (x >= 0 && x <= 2 && y >= -2 && y <= 0) || (x >= -2 && x <= 0 && y >= 0 && y <= 2) ? 1 : 0;
  }
  const Result result = run_all(mesh);
  std::int64_t high = 0;
  for (const Region& region : result.segmentation.regions)
    if (region.polarity == Polarity::kUpper) {
      ++high;
      EXPECT_DOUBLE_EQ(region.area, 4);
      EXPECT_DOUBLE_EQ(region.level_length, 8);
      EXPECT_EQ(region.euler, 1);
    }
  EXPECT_EQ(high, 2);
  // The same two triangles glued at a vertex of the mesh itself.
  const Result glued =
      run_all({{{0, 0, 0}, {-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}, {{0, 1, 2}, {0, 3, 4}}, {1, 1, 1, 2, 2}});
  EXPECT_EQ(glued.trees.trees[0].num_nodes(), 2U) << "two components";
  for (const NodeAttributes& of : glued.attributes) EXPECT_EQ(of.euler, 1);
}

// Two triangles on the same three vertices share all three edges, or two where the third is cut; they are joined twice,
// and neither edge may be taken for the other.
TEST(AwkwardMeshes, TwoTrianglesThatShareTwoEdges) {
  for (const auto& values : std::vector<std::vector<double>>{{0, 0, 0}, {1, 2, 3}, {2, 1, 2}}) {
    const Mesh mesh{{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}}, {{0, 1, 2}, {1, 0, 2}}, values};
    for (const Select select : kSelections) {
      const NodeAttributes pillow = run_all(mesh, select).attributes.at(0);
      EXPECT_EQ(pillow.num_triangles, 2);
      EXPECT_EQ(pillow.euler, 2) << "closed";
      EXPECT_EQ(pillow.hole_length, 0);
      EXPECT_EQ(pillow.level_length, 0);
      EXPECT_NEAR(pillow.flatness(), 0, 1e-15);
      const NodeAttributes cup = run_all(mesh, select, {}, {0, 3}).attributes.at(0);
      EXPECT_EQ(cup.num_triangles, 2);
      EXPECT_EQ(cup.euler, 1) << "a disc folded over";
      EXPECT_EQ(cup.hole_length, 4);
      EXPECT_EQ(cup.level_length, 0);
    }
    // A third triangle on the edge of both is no surface, and that is said.
    Mesh three = mesh;
    three.positions.emplace_back(3, 3, 1);
    three.values.push_back(0);
    three.triangles.push_back({3, 1, 0});
    const std::vector<EdgeDefect> defects = find_edge_defects(three.triangles, three.positions.size());
    EXPECT_EQ(defects, (std::vector<EdgeDefect>{{0, 1, 1, 2}}));
  }
}

/// A disc of n triangles about one vertex, with a value at each rim vertex; ids in the order of `order`.
Mesh fan(std::int32_t n, bool closed, const std::vector<std::int32_t>& order) {
  Mesh mesh;
  mesh.positions.emplace_back(0, 0, 0);
  mesh.values.push_back(1e6);
  for (std::int32_t i = 0; i < n + (closed ? 0 : 1); ++i) {
    const double angle = 2 * std::numbers::pi * i / (closed ? n : n + 1);
    mesh.positions.emplace_back(std::cos(angle), std::sin(angle), 0);
    mesh.values.push_back(i % 20000 < 500 ? 1 + i % 20000 : 0);
  }
  for (const std::int32_t i : order) mesh.triangles.push_back({0, 1 + i, 1 + (closed ? (i + 1) % n : i + 1)});
  return mesh;
}

TEST(AwkwardMeshes, FansOfAHundredThousandTriangles) {
  constexpr std::int32_t kTriangles = 100000;
  std::vector<std::int32_t> order(kTriangles);
  for (std::int32_t i = 0; i < kTriangles; ++i) order[static_cast<std::size_t>(i)] = i;
  for (const bool closed : {true, false})
    for (int arrangement = 0; arrangement < 3; ++arrangement) {
      if (arrangement == 1) std::reverse(order.begin(), order.end());
      if (arrangement == 2) std::shuffle(order.begin(), order.end(), std::mt19937(5));
      const Result result = run_all(fan(kTriangles, closed, order), Select::kLevel, {-1, 0.5, 100.5, 400.5});
      const NodeAttributes& root = result.attributes.back();
      EXPECT_EQ(root.num_triangles, kTriangles);
      EXPECT_EQ(root.euler, 1);
      EXPECT_EQ(root.level_length, 0);
      EXPECT_EQ(result.trees.trees[0].num_nodes(), 16U) << "5 hills of three levels, and all";
    }
}

TEST(AwkwardMeshes, IsolatedAndZeroAreaTriangles) {
  Mesh mesh = sheet(8, 0);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const double x = mesh.positions[v].x(), y = mesh.positions[v].y();
    mesh.values[v] = x >= 3 && x <= 5 && y >= 3 && y <= 5 ? 1 : 0;
  }
  const Result alone = run_all(mesh);
  ASSERT_GE(alone.segmentation.regions.size(), 1U);
  // A triangle for itself, one of three vertices in a row, one of three vertices in one place, a vertex of no triangle.
  const auto v = static_cast<std::int32_t>(mesh.positions.size());
  for (const auto& p : std::vector<Eigen::Vector3d>{{20, 0, 0},
                                                    {21, 0, 0},
                                                    {20, 1, 0},
                                                    {30, 0, 0},
                                                    {31, 0, 0},
                                                    {33, 0, 0},
                                                    {40, 0, 0},
                                                    {40, 0, 0},
                                                    {40, 0, 0},
                                                    {50, 0, 0}}) {
    mesh.positions.push_back(p);
    mesh.values.push_back(0);
  }
  for (const std::int32_t first : {v, v + 3, v + 6}) mesh.triangles.push_back({first, first + 1, first + 2});
  for (const Select select : kSelections) run_all(mesh, select);
  const Result with = run_all(mesh);
  ASSERT_EQ(with.segmentation.regions.size(), alone.segmentation.regions.size());
  for (std::size_t r = 0; r < with.segmentation.regions.size(); ++r) {
    EXPECT_EQ(with.segmentation.regions[r].area, alone.segmentation.regions[r].area);
    EXPECT_EQ(with.segmentation.regions[r].stability, alone.segmentation.regions[r].stability);
    EXPECT_EQ(with.segmentation.regions[r].centroid, alone.segmentation.regions[r].centroid);
    EXPECT_EQ(with.segmentation.regions[r].level_length, alone.segmentation.regions[r].level_length);
  }
  for (std::size_t t = 0; t < alone.segmentation.region_of_triangle.size(); ++t)
    EXPECT_EQ(with.segmentation.region_of_triangle[t], alone.segmentation.region_of_triangle[t]);
  // A sheet whose rows of vertices coincide: every other row of triangles has no area.
  Mesh folded = sheet(8, 0);
  for (Eigen::Vector3d& p : folded.positions) p.y() = std::floor(p.y() / 2);
  for (std::size_t i = 0; i < folded.values.size(); ++i) folded.values[i] = static_cast<double>(i * 7 % 5);
  for (const Select select : kSelections) run_all(folded, select);
}

// Sums of areas that no double holds: in any order of the triangles the same regions come out, ties stay ties.
TEST(AwkwardMeshes, RoundingCannotBreakATie) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::mt19937 random(seed);
    Mesh mesh = sheet(12, 0);
    // Thirds and tenths, so that sums round; several equal hills, which tie in everything but their place.
    for (Eigen::Vector3d& p : mesh.positions) p *= 0.1 + 1.0 / 3;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      const auto x = static_cast<int>(v % 13), y = static_cast<int>(v / 13);
      mesh.values[v] = x % 4 == 2 && y % 4 == 2 ? 3 : (x % 4 != 0 && y % 4 != 0 ? 2 : 0);
    }
    const Result ordered = run_all(mesh);
    std::vector<std::size_t> from(mesh.triangles.size());
    for (std::size_t t = 0; t < from.size(); ++t) from[t] = t;
    std::shuffle(from.begin(), from.end(), random);
    Mesh shuffled = mesh;
    for (std::size_t t = 0; t < from.size(); ++t) shuffled.triangles[t] = mesh.triangles[from[t]];
    const Result other = run_all(shuffled);
    ASSERT_GE(ordered.segmentation.regions.size(), 9U);
    ASSERT_EQ(other.segmentation.regions.size(), ordered.segmentation.regions.size()) << seed;
    const auto sorted = [](const Segmentation& segmentation) {
      std::vector<std::array<double, 4>> rows;
      for (const Region& region : segmentation.regions)
        rows.push_back({region.area, region.stability, region.level_length, region.hole_length});
      std::sort(rows.begin(), rows.end());
      return rows;
    };
    const auto rows = sorted(ordered.segmentation), other_rows = sorted(other.segmentation);
    EXPECT_EQ(rows, other_rows);
    for (std::size_t t = 0; t < from.size(); ++t) {
      const std::int32_t a = ordered.segmentation.region_of_triangle[from[t]];
      const std::int32_t b = other.segmentation.region_of_triangle[t];
      ASSERT_EQ(a == 0, b == 0);
      if (a > 0) {
        EXPECT_EQ(ordered.segmentation.regions[static_cast<std::size_t>(a) - 1].num_triangles,
                  other.segmentation.regions[static_cast<std::size_t>(b) - 1].num_triangles);
      }
    }
  }
}

// More triangles than half-edges can be numbered are refused before a single one is looked at.
TEST(AwkwardMeshes, TooManyTrianglesAreRefused) {
  constexpr std::size_t kTooMany = (std::size_t{1} << 31) / 3 + 1;
  const std::array<std::int32_t, 3> triangle{0, 1, 2};
  EXPECT_THROW(twin_half_edges({&triangle, kTooMany}, 3), StageError);
  const std::int32_t number = 0;
  const double area = 1;
  EXPECT_THROW(build_component_tree({&number, 3 * kTooMany}, {&area, kTooMany}, {&number, kTooMany}, 1), StageError);
}

}  // namespace
}  // namespace meshmser
