#include "stages/tree/exclusion.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "stages/common/adjacency.hpp"

namespace meshmser {
namespace {

struct Sheet {
  std::vector<Eigen::Vector3d> positions;
  std::vector<std::array<std::int32_t, 3>> triangles;
  std::vector<std::int32_t> twins;
  std::vector<double> values;
};

/// 20 x 20 unit squares with one square missing at (10, 10): an outer rim of length 80 and a hole of length 4.
Sheet sheet_with_hole() {
  Sheet sheet;
  for (std::int32_t y = 0; y <= 20; ++y)
    for (std::int32_t x = 0; x <= 20; ++x) sheet.positions.emplace_back(x, y, 0);
  for (std::int32_t y = 0; y < 20; ++y)
    for (std::int32_t x = 0; x < 20; ++x) {
      if (x == 10 && y == 10) continue;
      const std::int32_t a = 21 * y + x;
      sheet.triangles.push_back({a, a + 1, a + 22});
      sheet.triangles.push_back({a, a + 22, a + 21});
    }
  sheet.twins = twin_half_edges(sheet.triangles, sheet.positions.size());
  sheet.values.assign(sheet.positions.size(), 1);
  return sheet;
}

/// From the definition: a corner within the distance of the outer rim, or of the hole's.
bool expected(const Sheet& sheet, std::size_t t, double distance, bool with_hole) {
  for (const std::int32_t corner : sheet.triangles[t]) {
    const double x = sheet.positions[static_cast<std::size_t>(corner)][0];
    const double y = sheet.positions[static_cast<std::size_t>(corner)][1];
    if (std::min({x, y, 20 - x, 20 - y}) < distance) return true;
    if (with_hole && std::hypot(std::max({10 - x, 0.0, x - 11}), std::max({10 - y, 0.0, y - 11})) < distance)
      return true;
  }
  return false;
}

TEST(ExcludeTriangles, NearTheLongRimAloneOrNearBoth) {
  const Sheet sheet = sheet_with_hole();
  for (const double distance : {0.5, 1.5, 3.2})
    for (const bool with_hole : {false, true}) {
      const Exclusion exclusion =
          exclude_triangles(sheet.positions, sheet.triangles, sheet.twins, sheet.values, distance, with_hole ? 3 : 5);
      EXPECT_EQ(exclusion.num_rims, with_hole ? 2 : 1);
      std::int64_t count = 0;
      for (std::size_t t = 0; t < sheet.triangles.size(); ++t) {
        EXPECT_EQ(exclusion.excluded_of_triangle[t] != 0, expected(sheet, t, distance, with_hole))
            << "triangle " << t << " at distance " << distance;
        count += exclusion.excluded_of_triangle[t];
      }
      EXPECT_EQ(exclusion.num_near_rim, count);
    }
}

TEST(ExcludeTriangles, TouchingAValueThatIsNotFinite) {
  Sheet sheet = sheet_with_hole();
  sheet.values[0] = std::nan("");
  sheet.values[20] = std::numeric_limits<double>::infinity();
  const Exclusion exclusion = exclude_triangles(sheet.positions, sheet.triangles, sheet.twins, sheet.values, 0, 0);
  EXPECT_EQ(exclusion.num_nan, 3);
  EXPECT_EQ(exclusion.num_near_rim, 0);
  EXPECT_EQ(exclusion.excluded_of_triangle[0], 1);
  EXPECT_EQ(exclusion.excluded_of_triangle[1], 1);
  EXPECT_EQ(exclusion.excluded_of_triangle[38], 1);
}

}  // namespace
}  // namespace meshmser
