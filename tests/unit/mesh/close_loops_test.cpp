#include "stages/mesh/close_loops.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "pipeline/execution/error.hpp"
#include "stages/common/mesh_topology.hpp"
#include "stages/mesh/local_delaunay.hpp"
#include "stages/mesh/manifold.hpp"
#include "tests/unit/mesh/scattered_shapes.hpp"

namespace meshmser {
namespace {

using Eigen::Vector3d;

struct Sheet {
  ScatteredShape shape;
  std::vector<Triangle> triangles;

  explicit Sheet(int side, std::uint32_t seed = 1) : shape(scattered_plane(side, 0.3, {}, seed)) {
    triangles = local_delaunay(shape.cloud.positions, shape.normals.normals, 1, 5);
  }
  /// Takes out the triangles at a point, so that it is no longer a corner.
  void pierce(std::int32_t point) {
    std::erase_if(triangles, [&](const Triangle& t) { return std::find(t.begin(), t.end(), point) != t.end(); });
  }
  LoopCounts close(int max_loop_edges = 12, double max_edge = 5) {
    return close_loops(triangles, shape.cloud.positions, shape.normals.normals, nullptr, max_edge, max_loop_edges);
  }
  MeshTopology topology() const {
    const CompactMesh compact = split_pinched_vertices(triangles, shape.cloud.num_points());
    return describe_topology(compact.triangles, compact.point_of_vertex.size());
  }
  double area() const {
    double sum = 0;
    for (const Triangle& t : triangles) {
      const auto p = [&](std::size_t k) { return shape.cloud.positions[static_cast<std::size_t>(t[k])]; };
      sum += (p(1) - p(0)).cross(p(2) - p(0)).z() / 2;
    }
    return sum;
  }
};

TEST(CloseLoops, FillsWhatWasTakenOut) {
  Sheet sheet(15);
  const double area = sheet.area();
  const MeshTopology before = sheet.topology();
  for (const std::int32_t point : {48, 52, 100, 160}) sheet.pierce(point);
  EXPECT_EQ(sheet.topology().border_loops.size(), 5u);
  const LoopCounts counts = sheet.close();
  EXPECT_EQ(counts.closed, 4);
  EXPECT_EQ(counts.left_open, 0);
  const MeshTopology after = sheet.topology();
  EXPECT_EQ(after.defect, "");
  EXPECT_EQ(after.border_loops, before.border_loops);
  EXPECT_EQ(after.num_triangles, before.num_triangles - 2 * 4);
  EXPECT_NEAR(sheet.area(), area, 1e-9);
  EXPECT_TRUE(std::is_sorted(sheet.triangles.begin(), sheet.triangles.end()));
}

TEST(CloseLoops, LeavesLongLoopsAndLongEdges) {
  Sheet sheet(15);
  sheet.pierce(112);
  sheet.pierce(113);
  const auto hole = sheet.topology().border_loops.back();
  const auto pierced = sheet.triangles;
  EXPECT_EQ(sheet.close(static_cast<int>(hole) - 1).closed, 0);
  EXPECT_EQ(sheet.triangles, pierced);
  EXPECT_EQ(sheet.close(static_cast<int>(hole), 0.5).left_open, 1);
  EXPECT_EQ(sheet.triangles, pierced);
  EXPECT_EQ(sheet.close(static_cast<int>(hole)).closed, 1);
}

TEST(CloseLoops, MeasuresTheOtherPositionsToo) {
  Sheet sheet(15);
  sheet.pierce(112);
  std::vector<Vector3d> raw = sheet.shape.cloud.positions;
  for (Vector3d& p : raw) p *= 10;
  const LoopCounts counts =
      close_loops(sheet.triangles, sheet.shape.cloud.positions, sheet.shape.normals.normals, &raw, 5, 12);
  EXPECT_EQ(counts.closed, 0);
  EXPECT_EQ(counts.left_open, 1);
}

TEST(CloseLoops, HolesThatTouchAreClosedOneByOne) {
  // Two gaps meet at one point: the rim runs through it twice, each gap by itself is short.
  Sheet sheet(15);
  sheet.pierce(111);
  sheet.pierce(113);
  const MeshTopology before = sheet.topology();
  sheet.close(12);
  EXPECT_EQ(sheet.topology().border_loops.size(), 1u);
  EXPECT_EQ(sheet.topology().defect, "");
  EXPECT_GT(sheet.topology().num_triangles, before.num_triangles);
}

TEST(CloseLoops, TheRimOfASmallPatchStays) {
  ScatteredShape shape;
  shape.add({0, 0, 0}, {0, 0, 1});
  shape.add({1, 0, 0}, {0, 0, 1});
  shape.add({0, 1, 0}, {0, 0, 1});
  shape.add({1, 1, 0}, {0, 0, 1});
  std::vector<Triangle> triangles{{0, 1, 2}, {1, 3, 2}};
  const LoopCounts counts = close_loops(triangles, shape.cloud.positions, shape.normals.normals, nullptr, 5, 12);
  EXPECT_EQ(counts.left_open, 1);
  EXPECT_EQ(triangles.size(), 2u);
}

TEST(CloseLoops, AnLShapedGapIsFilledWithinItself) {
  // The polygon is not convex: a fan from any corner would leave it.
  ScatteredShape shape;
  for (int i = 0; i < 5; ++i)
    for (int j = 0; j < 5; ++j) shape.add({1.0 * i, 1.0 * j, 0}, {0, 0, 1});
  std::vector<Triangle> triangles;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) {
      if ((i == 1 && (j == 1 || j == 2)) || (i == 2 && j == 1)) continue;
      const std::int32_t a = 5 * i + j, b = a + 5, c = a + 6, d = a + 1;
      triangles.push_back({a, b, c});
      triangles.push_back({a, c, d});
    }
  sort_triangles(triangles);
  const std::size_t before = triangles.size();
  const LoopCounts counts = close_loops(triangles, shape.cloud.positions, shape.normals.normals, nullptr, 5, 12);
  EXPECT_EQ(counts.closed, 1);
  EXPECT_EQ(triangles.size(), before + 6);
  double area = 0;
  for (const Triangle& t : triangles) {
    const auto p = [&](std::size_t k) { return shape.cloud.positions[static_cast<std::size_t>(t[k])]; };
    const double twice = (p(1) - p(0)).cross(p(2) - p(0)).z();
    EXPECT_GT(twice, 0);
    area += twice / 2;
  }
  EXPECT_NEAR(area, 16, 1e-12);
}

TEST(CloseLoops, OfRandomDamageIsManifold) {
  for (std::uint32_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    Sheet sheet(14, seed);
    std::mt19937 random(seed);
    std::erase_if(sheet.triangles, [&](const Triangle&) { return random() % 100 < 5 + seed % 45; });
    const MeshTopology before = sheet.topology();
    const LoopCounts counts = sheet.close();
    const MeshTopology after = sheet.topology();
    ASSERT_EQ(after.defect, "");
    EXPECT_EQ(after.num_triangles, before.num_triangles + counts.triangles);
    EXPECT_GE(sheet.area(), 0);
    EXPECT_LE(sheet.area(), 14 * 14);
  }
}

TEST(CloseLoops, AFoldIsClosedAgainstSomeNormals) {
  // Around the gap 0 1 2 3 two sides cross: either diagonal leaves a triangle that runs against the normals.
  const std::vector<Vector3d> positions{{0, 0, 0},   {3, 0, 0},  {0, 1, 0}, {2.5, 0.5, 0},
                                        {-1, -1, 0}, {4, -1, 0}, {4, 2, 0}, {-1, 2, 0}};
  const std::vector<Vector3d> up(positions.size(), Vector3d::UnitZ());
  std::vector<Triangle> triangles{{1, 0, 4}, {1, 4, 5}, {2, 1, 5}, {2, 5, 6},
                                  {3, 2, 6}, {3, 6, 7}, {0, 3, 7}, {0, 7, 4}};
  sort_triangles(triangles);
  const LoopCounts counts = close_loops(triangles, positions, up, nullptr, 6, 12);
  EXPECT_EQ(counts.closed, 1);
  EXPECT_EQ(counts.triangles, 2);
  EXPECT_EQ(counts.left_open, 1);  // the rim around it all
  const MeshTopology topology = describe_topology(triangles, positions.size());
  EXPECT_EQ(topology.defect, "");
  EXPECT_EQ(topology.border_loops, std::vector<std::int64_t>{4});
}

TEST(CloseLoops, RefusesWhatIsNoManifold) {
  ScatteredShape shape = scattered_plane(3, 0);
  std::vector<Triangle> triangles{{0, 1, 2}, {0, 1, 3}};
  EXPECT_THROW(close_loops(triangles, shape.cloud.positions, shape.normals.normals, nullptr, 5, 12), StageError);
}

}  // namespace
}  // namespace meshmser
