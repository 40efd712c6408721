#include "stages/mesh/local_delaunay.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

#include "stages/common/mesh_topology.hpp"
#include "stages/mesh/advancing_front.hpp"
#include "stages/mesh/close_loops.hpp"
#include "stages/mesh/manifold.hpp"
#include "stages/mesh/point_blocks.hpp"
#include "stages/mesh/refit_normals.hpp"
#include "stages/mesh/voronoi_stars.hpp"
#include "tests/unit/mesh/scattered_shapes.hpp"

namespace meshmser {
namespace {

using Eigen::Vector3d;

std::size_t at(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

std::vector<Triangle> mesh(const ScatteredShape& shape, double max_edge = 5, LocalDelaunayCounts* counts = nullptr) {
  return local_delaunay(shape.cloud.positions, shape.normals.normals, shape.cloud.spacing, max_edge, {}, counts);
}

/// Each half-edge at most once: what local_delaunay promises.
bool is_edge_manifold(const std::vector<Triangle>& triangles) {
  std::set<std::pair<std::int32_t, std::int32_t>> half_edges;
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k)
      if (!half_edges.emplace(t[k], t[(k + 1) % 3]).second) return false;
  return true;
}

TEST(LocalDelaunay, InAPlaneIsTheDelaunayTriangulation) {
  for (std::uint32_t seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE(seed);
    const ScatteredShape shape = scattered_plane(12, 0.45, {}, seed);
    const std::vector<Triangle> made = mesh(shape, 4);
    // By the definition: three points whose circumcircle holds no other, with edges and radius of at most 4.
    const auto& p = shape.cloud.positions;
    const auto n = static_cast<std::int32_t>(p.size());
    std::vector<Triangle> expected;
    for (std::int32_t a = 0; a < n; ++a) {
      for (std::int32_t b = a + 1; b < n; ++b) {
        if ((p[at(a)] - p[at(b)]).norm() > 4) continue;
        for (std::int32_t c = b + 1; c < n; ++c) {
          if ((p[at(a)] - p[at(c)]).norm() > 4 || (p[at(b)] - p[at(c)]).norm() > 4) continue;
          const Vector3d u = p[at(b)] - p[at(a)], v = p[at(c)] - p[at(a)];
          const double cross = u.cross(v).z();
          const Vector3d centre = p[at(a)] + Vector3d(v.y() * u.squaredNorm() - u.y() * v.squaredNorm(),
                                                      u.x() * v.squaredNorm() - v.x() * u.squaredNorm(), 0) /
                                                 (2 * cross);
          const double radius = (centre - p[at(a)]).norm();
          if (radius > 4) continue;
          bool empty = true;
          for (std::int32_t d = 0; d < n && empty; ++d)
            empty = d == a || d == b || d == c || (p[at(d)] - centre).norm() >= radius;
          if (empty) expected.push_back(cross > 0 ? Triangle{a, b, c} : Triangle{a, c, b});
        }
      }
    }
    sort_triangles(expected);
    EXPECT_EQ(made, expected);
  }
}

TEST(LocalDelaunay, OfNoiseIsManifoldAllTheSame) {
  // Normals and positions without any surface: nothing to agree on, and nothing may break.
  for (std::uint32_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> place(0, 8);
    std::normal_distribution<double> any;
    ScatteredShape shape;
    for (int i = 0; i < 600; ++i)
      shape.add({place(random), place(random), place(random) / (1 + seed % 5)},
                Vector3d(any(random), any(random), any(random) + seed % 3).normalized());
    shape.finish();
    const std::vector<Triangle> triangles = mesh(shape);
    ASSERT_TRUE(is_edge_manifold(triangles));
    const CompactMesh compact = split_pinched_vertices(triangles, shape.cloud.num_points());
    EXPECT_EQ(describe_topology(compact.triangles, compact.point_of_vertex.size()).defect, "");
  }
}

TEST(LocalDelaunay, GridsWithManyEquallyGoodTrianglesAgree) {
  // A cylinder covered by a grid: on each square the two diagonals are as long.
  ScatteredShape shape;
  const int around = 60, along = 30;
  const double radius = around / (2 * std::numbers::pi);
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < along; ++j) {
      const double u = 2 * std::numbers::pi * i / around;
      const Vector3d normal(std::cos(u), std::sin(u), 0);
      shape.add(radius * normal + Vector3d(0, 0, j), normal);
    }
  auto triangles = mesh(shape.finish());
  // Bending tells the diagonals apart by less than the weights do, nearly everywhere; close_loops mends the rest.
  EXPECT_GT(triangles.size(), 0.9 * 2 * around * (along - 1));
  close_loops(triangles, shape.cloud.positions, shape.normals.normals, nullptr, 5, 12);
  EXPECT_EQ(triangles.size(), 2u * around * (along - 1));
  EXPECT_EQ(describe_topology(triangles, shape.cloud.num_points()).border_loops,
            (std::vector<std::int64_t>{around, around}));
}

TEST(LocalDelaunay, SheetsOfAThinWallStayApart) {
  ScatteredShape shape = scattered_plane(30, 0.3, {}, 1);
  const ScatteredShape back = scattered_plane(30, 0.3, {}, 2);
  const auto front_points = static_cast<std::int32_t>(shape.cloud.num_points());
  for (const Vector3d& p : back.cloud.positions) shape.add(p - Vector3d(0, 0, 0.8), {0, 0, -1});
  const auto triangles = mesh(shape);
  EXPECT_GT(triangles.size(), 3200u);
  for (const Triangle& t : triangles) {
    EXPECT_EQ(t[0] < front_points, t[1] < front_points);
    EXPECT_EQ(t[0] < front_points, t[2] < front_points);
  }
}

TEST(LocalDelaunay, RoundsASharpEdge) {
  // Two faces at 90 degrees, normals of each face right up to the edge.
  ScatteredShape shape;
  const ScatteredShape face = scattered_plane(30, 0.3);
  for (const Vector3d& p : face.cloud.positions) {
    shape.add({p.x(), p.y(), 0}, {0, 0, 1});
    shape.add({-0.5, p.y() + 0.4, -p.x() - 0.5}, {-1, 0, 0});
  }
  shape.finish();
  const auto triangles = mesh(shape);
  const CompactMesh compact = split_pinched_vertices(triangles, shape.cloud.num_points());
  EXPECT_EQ(describe_topology(compact.triangles, compact.point_of_vertex.size()).num_components, 1);
}

TEST(LocalDelaunay, CountsItsVotes) {
  LocalDelaunayCounts counts;
  const auto triangles = mesh(scattered_torus(20, 7), 5, &counts);
  EXPECT_EQ(counts.by_three + counts.by_two + counts.by_one, static_cast<std::int64_t>(triangles.size()));
  EXPECT_GT(counts.by_three, 0.98 * static_cast<double>(triangles.size()));
  EXPECT_GT(counts.by_two, 0);
}

TEST(LocalDelaunay, DoesNotDependOnThreadsOrPace) {
  const ScatteredShape shape = scattered_torus(20, 7);
  const auto expected = mesh(shape);
  for (const int threads : {1, 2, 7}) {
    Execution execution;
    execution.threads = threads;
    EXPECT_EQ(local_delaunay(shape.cloud.positions, shape.normals.normals, 1, 5, execution), expected);
  }
  // The blocks only decide how neighbours are found.
  EXPECT_EQ(local_delaunay(shape.cloud.positions, shape.normals.normals, 0.7, 5), expected);
  EXPECT_EQ(local_delaunay(shape.cloud.positions, shape.normals.normals, 0, 5), expected);
}

TEST(LocalDelaunay, HasNearlyTheTrianglesOfAdvancingFront) {
  const ScatteredShape shape = scattered_torus(30, 12);
  const auto reference = advancing_front(shape.cloud.positions, 5);
  EXPECT_GE(static_cast<double>(mesh(shape).size()), 0.99 * static_cast<double>(reference.size()));
}

TEST(LocalDelaunay, FarFromTheOriginToo) {
  ScatteredShape shape = scattered_plane(20, 0.3);
  const auto expected = mesh(shape);
  for (Vector3d& p : shape.cloud.positions) p += Vector3d(1 << 20, -(1 << 20), 1 << 19);
  EXPECT_EQ(mesh(shape), expected);
}

TEST(PointBlocks, GatherFindsAllThatIsNear) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-20, 20);
  std::vector<Vector3d> positions(3000);
  for (Vector3d& p : positions) p = {place(random), place(random), 0.2 * place(random)};
  positions.push_back({1e9, 0, 0});  // an outlier that stretches the box
  const PointBlocks blocks(positions, 1.7);
  EXPECT_GE(blocks.size(), 1e9 / (1 << 20));
  positions.pop_back();
  const PointBlocks close(positions, 1.7);
  EXPECT_EQ(close.size(), 1.7);
  std::vector<std::int32_t> around;
  std::size_t seen = 0;
  for (std::int64_t block = 0; block < close.num_blocks(); ++block) {
    for (const int rings : {1, 2}) {
      around.clear();
      close.gather(block, rings, around);
      const std::set<std::int32_t> found(around.begin(), around.end());
      ASSERT_EQ(found.size(), around.size());
      for (const std::int32_t* p = close.begin(block); p != close.end(block); ++p)
        for (std::int32_t q = 0; q < 3000; ++q)
          ASSERT_TRUE(found.count(q) > 0 || (positions[at(q)] - positions[at(*p)]).norm() >= rings * 1.7);
    }
    seen += static_cast<std::size_t>(close.end(block) - close.begin(block));
  }
  EXPECT_EQ(seen, 3000u);
}

TEST(TangentFrame, IsRightHandedForAnyNormal) {
  std::mt19937 random(7);
  std::normal_distribution<double> any;
  for (int i = 0; i < 200; ++i) {
    Vector3d n = Vector3d(any(random), any(random), any(random)).normalized();
    if (i < 6) n = Vector3d::Unit(i / 2) * (i % 2 ? -1 : 1);
    Vector3d u, v;
    tangent_frame(n, u, v);
    EXPECT_NEAR((u.cross(v) - n).norm(), 0, 1e-14);
    EXPECT_NEAR(u.norm(), 1, 1e-14);
    EXPECT_NEAR(u.dot(n), 0, 1e-14);
  }
}

TEST(RefitNormals, TakesTheTiltOut) {
  ScatteredShape shape = scattered_sphere(15);
  const std::vector<Vector3d> exact = shape.normals.normals;
  std::mt19937 random(3);
  std::normal_distribution<double> tilt(0, 0.15);
  for (Vector3d& n : shape.normals.normals) n = (n + Vector3d(tilt(random), tilt(random), tilt(random))).normalized();
  shape.normals.normals[5].setZero();
  const auto refitted = refit_normals(shape.cloud.positions, shape.normals.normals, 1, 5);
  for (std::size_t p = 0; p < refitted.size(); ++p) EXPECT_GT(refitted[p].dot(exact[p]), std::cos(0.06)) << p;
}

TEST(RefitNormals, ANormalAmongOpposedOnesTakesTheirSide) {
  for (const Vector3d& wrong : {Vector3d(0, 0, -1), Vector3d(1, 0, 0), Vector3d(0, 0, 0)}) {
    ScatteredShape shape = scattered_plane(9, 0.3);
    shape.normals.normals[40] = wrong;
    EXPECT_GT(refit_normals(shape.cloud.positions, shape.normals.normals, 1, 5)[40].z(), 0.99);
  }
}

TEST(RefitNormals, KeepsWhatItCannotBetter) {
  // Two sheets back to back, closer than the points of each: their sides stay. And a point alone.
  ScatteredShape shape = scattered_plane(9, 0.3);
  for (std::size_t p = 0; p < 81; ++p) shape.add(shape.cloud.positions[p] - Vector3d(0, 0, 0.1), {0, 0, -1});
  shape.add({100, 100, 0}, {0, 1, 0});
  const auto refitted = refit_normals(shape.cloud.positions, shape.normals.normals, 1, 5);
  for (std::size_t p = 0; p < 81; ++p) EXPECT_GT(refitted[p].z(), 0.9);
  for (std::size_t p = 81; p < 162; ++p) EXPECT_LT(refitted[p].z(), -0.9);
  EXPECT_EQ(refitted.back(), Vector3d(0, 1, 0));
}

}  // namespace
}  // namespace meshmser
