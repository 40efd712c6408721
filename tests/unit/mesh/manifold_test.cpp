#include "stages/mesh/manifold.hpp"

#include <gtest/gtest.h>

#include <random>

#include "pipeline/execution/error.hpp"
#include "stages/common/adjacency.hpp"
#include "stages/common/mesh_topology.hpp"

namespace meshmser {
namespace {

/// A strip of quads around a band, closed with a half turn if `moebius`.
std::vector<Triangle> band(int n, bool moebius) {
  std::vector<Triangle> triangles;
  for (int i = 0; i < n; ++i) {
    int a = 2 * i, b = 2 * i + 1, c = 2 * (i + 1), d = 2 * (i + 1) + 1;
    if (i + 1 == n) {
      c = moebius ? 1 : 0;
      d = moebius ? 0 : 1;
    }
    triangles.push_back({a, c, b});
    triangles.push_back({b, c, d});
  }
  return triangles;
}

TEST(Topology, OfOneTriangle) {
  const MeshTopology topology = describe_topology({{0, 1, 2}}, 5);
  EXPECT_EQ(topology.defect, "");
  EXPECT_EQ(topology.num_vertices, 3);
  EXPECT_EQ(topology.num_edges, 3);
  EXPECT_EQ(topology.euler, 1);
  EXPECT_EQ(topology.num_components, 1);
  EXPECT_EQ(topology.border_loops, std::vector<std::int64_t>{3});
}

TEST(Topology, OfATetrahedronIsClosed) {
  const MeshTopology topology = describe_topology({{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}}, 4);
  EXPECT_EQ(topology.defect, "");
  EXPECT_EQ(topology.euler, 2);
  EXPECT_EQ(topology.num_border_edges, 0);
  EXPECT_TRUE(topology.border_loops.empty());
}

TEST(Topology, OfABandHasTwoLoops) {
  const MeshTopology topology = describe_topology(band(7, false), 14);
  EXPECT_EQ(topology.defect, "");
  EXPECT_EQ(topology.euler, 0);
  EXPECT_EQ(topology.border_loops, (std::vector<std::int64_t>{7, 7}));
  EXPECT_EQ(topology.loops_longer_than(6), 2);
  EXPECT_EQ(topology.loops_longer_than(7), 0);
}

TEST(Topology, NamesEachDefect) {
  EXPECT_EQ(describe_topology({{0, 1, 9}}, 3).defect,
            "triangle 0 (vertices 0, 1, 9) has a corner that is no vertex of 3");
  EXPECT_EQ(describe_topology({{0, 1, 1}}, 3).defect, "triangle 0 (vertices 0, 1, 1) has one vertex twice");
  EXPECT_EQ(describe_topology({{0, 1, 2}, {0, 1, 3}}, 4).defect,
            "the edge between the vertices 0 and 1 is used by several triangles in one direction, among them "
            "triangle 0 (vertices 0, 1, 2)");
  EXPECT_EQ(describe_topology({{0, 1, 2}, {0, 3, 4}}, 5).defect, "the vertex 0 has several fans of triangles");
  // A closed fan and another closed fan: two tetrahedra tip to tip.
  EXPECT_EQ(
      describe_topology({{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}, {0, 4, 5}, {0, 5, 6}, {0, 6, 4}, {4, 6, 5}}, 7)
          .defect,
      "the vertex 0 has several fans of triangles");
  EXPECT_NE(describe_topology(band(5, true), 10).defect, "");
}

TEST(OrientedManifold, TurnsAndSorts) {
  std::vector<Triangle> triangles = band(9, false);
  std::mt19937 random(3);
  for (Triangle& t : triangles)
    if (random() % 2) std::swap(t[0], t[1]);
  std::shuffle(triangles.begin(), triangles.end(), random);
  ManifoldRepair repair;
  const auto result = oriented_manifold(triangles, &repair);
  EXPECT_EQ(result.size(), 18u);
  EXPECT_EQ(repair.degenerate + repair.third_on_edge + repair.inconsistent, 0);
  EXPECT_EQ(describe_topology(result, 18).defect, "");
  EXPECT_TRUE(std::is_sorted(result.begin(), result.end()));
}

TEST(OrientedManifold, CutsAMoebiusBand) {
  ManifoldRepair repair;
  const auto result = oriented_manifold(band(9, true), &repair);
  EXPECT_EQ(repair.inconsistent, 1);
  EXPECT_EQ(result.size(), 17u);
  // A rim triangle leaves; its third corner is a pinch until it is split, and the band is a strip.
  const CompactMesh mesh = split_pinched_vertices(result, 18);
  EXPECT_EQ(mesh.num_split, 1);
  EXPECT_EQ(describe_topology(mesh.triangles, mesh.point_of_vertex.size()).euler, 1);
}

TEST(OrientedManifold, DropsRepeatedAndThirdTriangles) {
  ManifoldRepair repair;
  const auto result = oriented_manifold({{0, 1, 2}, {2, 1, 0}, {1, 1, 3}, {1, 0, 3}, {0, 1, 4}}, &repair);
  EXPECT_EQ(repair.degenerate, 2);
  EXPECT_EQ(repair.third_on_edge, 1);
  EXPECT_EQ(result, (std::vector<Triangle>{{0, 1, 2}, {0, 3, 1}}));
}

TEST(OrientedManifold, OfRandomSoupIsManifoldOnceSplit) {
  for (std::uint32_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const int n = 5 + static_cast<int>(random() % 10);
    std::vector<Triangle> soup(3 + random() % 40);
    for (Triangle& t : soup)
      for (auto& corner : t) corner = static_cast<std::int32_t>(random() % static_cast<unsigned>(n));
    const auto triangles = oriented_manifold(soup);
    const CompactMesh mesh = split_pinched_vertices(triangles, static_cast<std::size_t>(n));
    const MeshTopology topology = describe_topology(mesh.triangles, mesh.point_of_vertex.size());
    ASSERT_EQ(topology.defect, "");
    EXPECT_EQ(topology.num_vertices, static_cast<std::int64_t>(mesh.point_of_vertex.size()));
    ASSERT_EQ(mesh.triangles.size(), triangles.size());
    for (std::size_t t = 0; t < triangles.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k)
        EXPECT_EQ(mesh.point_of_vertex[static_cast<std::size_t>(mesh.triangles[t][k])], triangles[t][k]);
    std::shuffle(soup.begin(), soup.end(), random);
    for (Triangle& t : soup)
      if (random() % 2) std::swap(t[1], t[2]);
    EXPECT_EQ(oriented_manifold(soup), triangles);
    std::int32_t components = 0;
    edge_components(twin_half_edges(triangles, static_cast<std::size_t>(n)), &components);
    EXPECT_EQ(components, topology.num_components);
  }
}

TEST(SplitPinchedVertices, GivesEachFanAVertex) {
  const CompactMesh mesh = split_pinched_vertices({{1, 2, 3}, {1, 4, 5}, {1, 3, 6}}, 8);
  EXPECT_EQ(mesh.point_of_vertex, (std::vector<std::int32_t>{1, 1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 2, 3}, {1, 4, 5}, {0, 3, 6}}));
  EXPECT_EQ(mesh.num_split, 1);
  EXPECT_EQ(mesh.num_unused, 2);
}

}  // namespace
}  // namespace meshmser
