#include "stages/tree/fallen_rim.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "stages/common/adjacency.hpp"

namespace meshmser {
namespace {

constexpr std::int32_t kSide = 60;

/// Low relief, 6 units of it fallen away at the left rim as steeply as 45 degrees, and a deep pit in the middle.
double height(double x, double y) {
  const double pit = std::hypot(x - 30, y - 30) < 3 ? -5 : 0;
  return 0.2 * std::sin(x) * std::cos(0.7 * y) + 0.002 * x * x - std::max(0.0, 6 - x) + pit;
}

TEST(FallenRim, FindsWhatFallsAtTheRimAndNoPitInside) {
  std::vector<Eigen::Vector3d> positions;
  std::vector<std::array<std::int32_t, 3>> triangles;
  for (std::int32_t y = 0; y <= kSide; ++y)
    for (std::int32_t x = 0; x <= kSide; ++x) positions.emplace_back(x, y, height(x, y));
  for (std::int32_t y = 0; y < kSide; ++y)
    for (std::int32_t x = 0; x < kSide; ++x) {
      const std::int32_t a = y * (kSide + 1) + x, b = a + 1, c = b + kSide + 1;
      triangles.push_back({a, b, c});
      triangles.push_back({a, c, c - 1});
    }
  const std::vector<std::int32_t> twins = twin_half_edges(triangles, positions.size());
  const std::vector<Eigen::Vector3d> normals(positions.size(), Eigen::Vector3d::UnitZ());
  const std::vector<double> areas(positions.size(), 1);
  const auto find = [&](double depth, double min_rim, int threads) {
    Execution execution;
    execution.threads = threads;
    return fallen_rim(positions, normals, areas, triangles, twins, {2, depth, min_rim}, execution);
  };
  const FallenRim rim = find(0, 10, 1);
  EXPECT_NEAR(rim.depth, 2.0 / 3, 1e-12);  // the relief inside is lower than that
  std::size_t missed = 0, wrong = 0;
  for (std::size_t v = 0; v < positions.size(); ++v) {
    const bool fallen = rim.fallen_of_vertex[v] != 0;
    missed += positions[v].x() <= 4 && !fallen;
    wrong += positions[v].x() >= 7 && fallen;
  }
  EXPECT_EQ(missed, 0u);
  EXPECT_EQ(wrong, 0u);
  EXPECT_EQ(find(0, 10, 7).fallen_of_vertex, rim.fallen_of_vertex);
  EXPECT_EQ(find(2.5, 10, 1).depth, 2.5);
  const FallenRim no_long_rim = find(0, 1000, 1);
  EXPECT_EQ(no_long_rim.fallen_of_vertex, std::vector<std::uint8_t>(positions.size(), 0));
}

}  // namespace
}  // namespace meshmser
