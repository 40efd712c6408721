#include "stages/common/adjacency.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <string>
#include <utility>

#include "tests/support/random_mesh.hpp"

namespace meshmser {
namespace {

using testing::RandomMesh;
using Triangles = std::vector<std::array<std::int32_t, 3>>;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Straight from the definition: the half-edge with the same ends the other way round.
std::vector<std::int32_t> twins_by_map(const Triangles& triangles) {
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> id;
  for (std::size_t h = 0; h < 3 * triangles.size(); ++h)
    id[{triangles[h / 3][h % 3], triangles[h / 3][(h + 1) % 3]}] = static_cast<std::int32_t>(h);
  std::vector<std::int32_t> twins;
  for (std::size_t h = 0; h < 3 * triangles.size(); ++h) {
    const auto found = id.find({triangles[h / 3][(h + 1) % 3], triangles[h / 3][h % 3]});
    twins.push_back(found == id.end() ? -1 : found->second);
  }
  return twins;
}

Triangles grid(std::int32_t columns, std::int32_t rows) {
  Triangles triangles;
  for (std::int32_t y = 0; y < rows; ++y)
    for (std::int32_t x = 0; x < columns; ++x) {
      const std::int32_t a = y * (columns + 1) + x, b = a + 1, c = a + columns + 2, d = a + columns + 1;
      triangles.push_back({a, b, c});
      triangles.push_back({a, c, d});
    }
  return triangles;
}

void shuffle_ids(Triangles& triangles, std::size_t num_vertices) {
  std::mt19937 random(7);
  std::vector<std::int32_t> order(num_vertices);
  for (std::size_t v = 0; v < num_vertices; ++v) order[v] = static_cast<std::int32_t>(v);
  std::shuffle(order.begin(), order.end(), random);
  for (auto& t : triangles)
    for (std::int32_t& corner : t) corner = order[static_cast<std::size_t>(corner)];
  std::shuffle(triangles.begin(), triangles.end(), random);
}

std::string message_of(const Triangles& triangles, std::size_t num_vertices) {
  try {
    twin_half_edges(triangles, num_vertices);
  } catch (const StageError& error) {
    return error.what();
  }
  return "";
}

TEST(TwinHalfEdges, RandomMeshesAsByMap) {
  for (std::uint32_t seed = 0; seed < 500; ++seed) {
    const RandomMesh mesh = testing::random_mesh(seed);
    EXPECT_EQ(twin_half_edges(mesh.triangles, mesh.positions.size()), twins_by_map(mesh.triangles)) << "seed " << seed;
  }
}

TEST(TwinHalfEdges, OrderedAndShuffledLargeMeshesOnAnyThreads) {
  Triangles triangles = grid(300, 300);
  const std::size_t num_vertices = 301 * 301;
  for (const bool shuffled : {false, true}) {
    if (shuffled) shuffle_ids(triangles, num_vertices);
    const std::vector<std::int32_t> expected = twins_by_map(triangles);
    for (const int threads : {1, 2, 7}) {
      Execution execution;
      execution.threads = threads;
      EXPECT_EQ(twin_half_edges(triangles, num_vertices, execution), expected)
          << (shuffled ? "shuffled" : "ordered") << " on " << threads << " threads";
    }
  }
}

TEST(TwinHalfEdges, FanOfAHundredThousandInAnyOrder) {
  Triangles triangles;
  const std::int32_t n = 100000;
  for (std::int32_t i = 0; i < n; ++i) triangles.push_back({0, i + 1, (i + 1) % n + 1});
  for (const bool shuffled : {false, true}) {
    if (shuffled) {
      std::mt19937 random(3);
      std::shuffle(triangles.begin(), triangles.end(), random);
    }
    EXPECT_EQ(twin_half_edges(triangles, n + 1), twins_by_map(triangles));
  }
}

TEST(TwinHalfEdges, PillowSharesAllThreeEdges) {
  EXPECT_THAT(twin_half_edges(Triangles{{0, 1, 2}, {2, 1, 0}}, 3), ElementsAre(4, 3, 5, 1, 0, 2));
}

TEST(TwinHalfEdges, NoneAndOne) {
  EXPECT_TRUE(twin_half_edges(Triangles{}, 0).empty());
  EXPECT_THAT(twin_half_edges(Triangles{{0, 1, 2}}, 3), ElementsAre(-1, -1, -1));
}

TEST(TwinHalfEdges, BadCornersAreNamed) {
  EXPECT_THAT(message_of({{0, 1, 5}}, 3), HasSubstr("triangle 0 names vertex 5, but there are 3 vertices"));
  EXPECT_THAT(message_of({{0, -1, 2}}, 3), HasSubstr("triangle 0 names vertex -1"));
  EXPECT_THAT(message_of({{0, 1, 2}, {0, 2, 2}}, 3), HasSubstr("triangle 1 names one vertex twice (0, 2, 2)"));
}

TEST(TwinHalfEdges, InconsistentOrientationIsNamed) {
  EXPECT_THAT(message_of({{0, 1, 2}, {0, 1, 3}}, 4),
              HasSubstr("the edge from vertex 0 to 1 runs in the same direction in triangles 0 and 1"));
}

TEST(FindEdgeDefects, NamesEveryBadEdgeAndNoOther) {
  // Three triangles on edge 0-1, and two triangles turned against each other on edge 5-6.
  const Triangles triangles{{0, 1, 2}, {1, 0, 3}, {0, 1, 4}, {5, 6, 7}, {5, 6, 8}};
  EXPECT_THAT(find_edge_defects(triangles, 9), ElementsAre(EdgeDefect{0, 1, 2, 1}, EdgeDefect{5, 6, 2, 0}));
  for (std::uint32_t seed = 0; seed < 50; ++seed) {
    const RandomMesh mesh = testing::random_mesh(seed);
    EXPECT_TRUE(find_edge_defects(mesh.triangles, mesh.positions.size()).empty()) << "seed " << seed;
  }
}

TEST(CutOutTriangles, EdgesToAnExcludedTriangleAreHoleEdges) {
  std::vector<std::int32_t> twins = twin_half_edges(Triangles{{0, 1, 2}, {2, 1, 3}, {3, 1, 4}}, 5);
  cut_out_triangles(twins, std::vector<std::uint8_t>{0, 1, 0});
  EXPECT_THAT(twins, ElementsAre(-1, -1, -1, -1, -1, -1, -1, -1, -1));
}

}  // namespace
}  // namespace meshmser
