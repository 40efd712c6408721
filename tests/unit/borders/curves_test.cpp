#include "stages/borders/curves.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <string>

#include "stages/common/adjacency.hpp"
#include "stages/tree/component_tree.hpp"
#include "stages/tree/levels.hpp"
#include "tests/support/random_mesh.hpp"

namespace meshmser {
namespace {

using Triangles = std::vector<std::array<std::int32_t, 3>>;
using testing::RandomMesh;

struct Case {
  std::vector<std::int32_t> twins;
  ComponentTree tree;
  BorderLoops loops;
  std::vector<BorderRegion> regions;
  BorderCurves curves;
};

/// Borders and curves of every node.
void build(const std::vector<Eigen::Vector3d>& positions, const Triangles& triangles, const std::vector<double>& values,
           const std::vector<double>& levels, Polarity polarity, Case& c) {
  c.twins = twin_half_edges(triangles, positions.size());
  const std::vector<std::int32_t> level =
      levels_of_triangles(triangles, levels_of_vertices(values, levels, polarity == Polarity::kLower ? -1 : 1), {});
  c.tree = build_component_tree(c.twins, triangle_areas(positions, triangles), level,
                                static_cast<std::int32_t>(levels.size()));
  c.tree.polarity = polarity;
  c.tree.levels = levels;
  std::vector<std::int32_t> numbers(c.tree.num_nodes());
  std::iota(numbers.begin(), numbers.end(), 1);
  for (std::int32_t node = 0; node < static_cast<std::int32_t>(numbers.size()); ++node)
    c.regions.push_back({&c.tree, node});
  const SurfaceView surface{positions, triangles, c.twins};
  c.loops = extract_borders(surface, c.tree, numbers, std::vector<std::int32_t>(triangles.size(), 0));
  c.curves = interpolate_borders(surface, values, c.loops, c.regions);
}

/// An n x n sheet of unit squares.
void sheet(std::int32_t n, std::vector<Eigen::Vector3d>& positions, Triangles& triangles) {
  for (std::int32_t y = 0; y <= n; ++y)
    for (std::int32_t x = 0; x <= n; ++x) positions.emplace_back(x, y, 0);
  for (std::int32_t y = 0; y < n; ++y)
    for (std::int32_t x = 0; x < n; ++x) {
      const std::int32_t a = y * (n + 1) + x;
      triangles.push_back({a, a + 1, a + n + 2});
      triangles.push_back({a, a + n + 2, a + n + 1});
    }
}

TEST(InterpolateBorders, ALinearScalarIsCutWhereItEqualsTheLevel) {
  std::vector<Eigen::Vector3d> positions;
  Triangles triangles;
  sheet(4, positions, triangles);
  std::vector<double> values;
  for (const auto& p : positions) values.push_back(p[0] + 0.25 * p[1]);
  for (const Polarity polarity : {Polarity::kUpper, Polarity::kLower}) {
    Case c;
    const double level = polarity == Polarity::kUpper ? 2.3 : -2.3;
    build(positions, triangles, values, {-std::numeric_limits<double>::infinity(), level}, polarity, c);
    ASSERT_EQ(c.loops.num_loops(), 1u) << "the root has its rim alone";
    double area = 0;
    std::int64_t on_level = 0;
    const std::size_t n = c.curves.points.size();
    for (std::size_t i = 0; i < n; ++i) {
      const Eigen::Vector3d &p = c.curves.points[i], &q = c.curves.points[(i + 1) % n];
      area += 0.5 * (p[0] * q[1] - p[1] * q[0]);
      if (c.curves.kinds[i] != EdgeKind::kLevel) continue;
      EXPECT_NEAR(p[0] + 0.25 * p[1], 2.3, 1e-12);
      EXPECT_NEAR(q[0] + 0.25 * q[1], 2.3, 1e-12);
      ++on_level;
    }
    EXPECT_GT(on_level, 6);
    // The area of {x + y / 4 >= 2.3} in the square of side 4, walked with the region on the left.
    const double right = 4 * 4 - 4 * 2.3 + 4 * 4 * 0.25 / 2;
    EXPECT_NEAR(area, polarity == Polarity::kUpper ? right : 16 - right, 1e-9);
  }
}

TEST(InterpolateBorders, RandomMeshesGiveClosedCurvesOfCrossingsAndBorderVertices) {
  for (std::uint32_t seed = 0; seed < 600; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const RandomMesh mesh = testing::random_mesh(seed);
    std::vector<Eigen::Vector3d> positions = mesh.positions;
    // Each vertex in a place of its own, so that a point tells its edge.
    for (std::size_t v = 0; v < positions.size(); ++v)
      positions[v] += Eigen::Vector3d(0, 0.001, 0.017) * static_cast<double>(v);
    Case c;
    const Polarity polarity = seed % 2 == 0 ? Polarity::kUpper : Polarity::kLower;
    build(positions, mesh.triangles, mesh.values, {-2.5, -1, 0.5, 1, 2.25}, polarity, c);
    ASSERT_EQ(c.curves.first_point_of_curve.size(), c.loops.num_loops() + 1);
    ASSERT_EQ(c.curves.kinds.size(), c.curves.points.size());
    for (std::size_t l = 0; l < c.loops.num_loops(); ++l) {
      const std::int32_t node = c.loops.owner_of_loop[l] - 1;
      const double level = c.tree.levels[static_cast<std::size_t>(c.tree.lo(node) - 1)];
      const double sign = polarity == Polarity::kUpper ? 1 : -1;
      // What may stand on the curve, from the definition: vertices of the loop, and on each edge between a vertex of
      // the loop and one below the level the place where S equals the level.
      std::set<std::int32_t> border;
      for (std::int64_t i = c.loops.first_edge_of_loop[l]; i < c.loops.first_edge_of_loop[l + 1]; ++i) {
        const std::int32_t h = c.loops.half_edges[static_cast<std::size_t>(i)];
        border.insert(mesh.triangles[static_cast<std::size_t>(h / 3)][static_cast<std::size_t>(h % 3)]);
      }
      std::vector<Eigen::Vector3d> allowed;
      for (const std::int32_t v : border) allowed.push_back(positions[static_cast<std::size_t>(v)]);
      for (const auto& t : mesh.triangles)
        for (const std::int32_t a : t)
          for (const std::int32_t b : t) {
            const double high = sign * mesh.values[static_cast<std::size_t>(a)];
            const double low = sign * mesh.values[static_cast<std::size_t>(b)];
            if (border.count(a) && low < level)
              allowed.push_back(positions[static_cast<std::size_t>(a)] +
                                (high - level) / (high - low) *
                                    (positions[static_cast<std::size_t>(b)] - positions[static_cast<std::size_t>(a)]));
          }
      const std::int64_t begin = c.curves.first_point_of_curve[l], end = c.curves.first_point_of_curve[l + 1];
      ASSERT_GE(end - begin, 2);
      for (std::int64_t i = begin; i < end; ++i) {
        const Eigen::Vector3d& p = c.curves.points[static_cast<std::size_t>(i)];
        double nearest = 1e9;
        for (const auto& q : allowed) nearest = std::min(nearest, (p - q).norm());
        ASSERT_LT(nearest, 1e-12);
        const Eigen::Vector3d& next = c.curves.points[static_cast<std::size_t>(i + 1 == end ? begin : i + 1)];
        ASSERT_NE(p, next) << "equal points in a row";
      }
    }
  }
}

TEST(SmoothCurves, StaysWithinItsToleranceAndGetsShorter) {
  std::vector<Eigen::Vector3d> positions;
  Triangles triangles;
  sheet(30, positions, triangles);
  std::vector<double> values;
  for (const auto& p : positions)
    values.push_back(10 - std::hypot(p[0] - 15, p[1] - 15) + 0.3 * std::sin(7 * p[0] + 3 * p[1]));
  Case c;
  build(positions, triangles, values, {-std::numeric_limits<double>::infinity(), 0}, Polarity::kUpper, c);
  ASSERT_GE(c.loops.num_loops(), 1u);
  auto length = [](const BorderCurves& curves) {
    double sum = 0;
    const auto n = static_cast<std::size_t>(curves.first_point_of_curve[1]);
    for (std::size_t i = 0; i < n; ++i) sum += (curves.points[(i + 1) % n] - curves.points[i]).norm();
    return sum;
  };
  for (const double tolerance : {0.0, 0.05, 0.3}) {
    const BorderCurves smooth = smooth_curves(c.curves, tolerance);
    for (std::size_t i = 0; i < smooth.points.size(); ++i)
      EXPECT_LE((smooth.points[i] - c.curves.points[i]).norm(), tolerance * (1 + 1e-12));
    if (tolerance > 0) {
      EXPECT_LT(length(smooth), length(c.curves) - 0.1);
    } else {
      EXPECT_EQ(smooth.points, c.curves.points);
    }
  }
}

double distance_to_curve(const Eigen::Vector3d& p, const BorderCurves& curves, std::size_t curve) {
  const auto begin = static_cast<std::size_t>(curves.first_point_of_curve[curve]);
  const auto end = static_cast<std::size_t>(curves.first_point_of_curve[curve + 1]);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = begin; i < end; ++i) {
    const Eigen::Vector3d a = curves.points[i], along = curves.points[i + 1 < end ? i + 1 : begin] - a;
    const double length2 = along.squaredNorm();
    const double at = length2 > 0 ? std::clamp((p - a).dot(along) / length2, 0.0, 1.0) : 0;
    least = std::min(least, (p - a - at * along).norm());
  }
  return least;
}

// Not points alone: wherever one stands on the smooth curve, the exact level line is within the tolerance, and the
// other way round. And where the exact line lies inside triangles, the scalar has the level's value on it.
TEST(SmoothCurves, EveryPlaceIsWithinTheToleranceOfTheExactLine) {
  for (std::uint32_t seed = 0; seed < 150; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const RandomMesh mesh = testing::random_mesh(seed);
    Case c;
    build(mesh.positions, mesh.triangles, mesh.values, {-2.5, 0.5, 2.25},
          seed % 2 == 0 ? Polarity::kUpper : Polarity::kLower, c);
    for (const double tolerance : {0.02, 0.3}) {
      const BorderCurves smooth = smooth_curves(c.curves, tolerance);
      ASSERT_EQ(smooth.first_point_of_curve, c.curves.first_point_of_curve) << "as many closed curves";
      ASSERT_EQ(smooth.kinds, c.curves.kinds);
      for (std::size_t l = 0; l + 1 < smooth.first_point_of_curve.size(); ++l) {
        const auto begin = static_cast<std::size_t>(smooth.first_point_of_curve[l]);
        const auto end = static_cast<std::size_t>(smooth.first_point_of_curve[l + 1]);
        for (std::size_t i = begin; i < end; ++i)
          for (const double part : {0.0, 0.2, 0.5, 0.9}) {
            const auto place = [&](const BorderCurves& on) -> Eigen::Vector3d {
              return (1 - part) * on.points[i] + part * on.points[i + 1 < end ? i + 1 : begin];
            };
            ASSERT_LE(distance_to_curve(place(smooth), c.curves, l), tolerance * (1 + 1e-9));
            ASSERT_LE(distance_to_curve(place(c.curves), smooth, l), tolerance * (1 + 1e-9));
          }
      }
    }
  }
}

TEST(SmoothCurves, HolesStay) {
  BorderCurves curve;
  curve.first_point_of_curve = {0, 5};
  curve.points = {{0, 0, 0}, {1, 1, 0}, {2, 0, 0}, {3, 1, 0}, {1, -3, 0}};
  curve.kinds = {EdgeKind::kLevel, EdgeKind::kLevel, EdgeKind::kLevel, EdgeKind::kHole, EdgeKind::kHole};
  const BorderCurves smooth = smooth_curves(curve, 0.1);
  for (const std::size_t fixed : {0u, 3u, 4u}) EXPECT_EQ(smooth.points[fixed], curve.points[fixed]);
  for (const std::size_t moved : {1u, 2u}) EXPECT_NE(smooth.points[moved], curve.points[moved]);
}

TEST(InterpolateBorders, RefusesAHubOfTooManyTriangles) {
  // A fan whose rim values alternate: each of n / 4 regions has a curve through all triangles around the hub.
  constexpr std::int32_t kAround = 8000;
  std::vector<Eigen::Vector3d> positions{{0, 0, 0}};
  std::vector<double> values{2};
  Triangles triangles;
  for (std::int32_t i = 0; i < kAround; ++i) {
    positions.emplace_back(std::cos(2 * M_PI * i / kAround), std::sin(2 * M_PI * i / kAround), 0);
    values.push_back(i % 4 < 2 ? 1 : 0);
    triangles.push_back({0, i + 1, i + 1 == kAround ? 1 : i + 2});
  }
  Case c;
  try {
    build(positions, triangles, values, {-std::numeric_limits<double>::infinity(), 0.5}, Polarity::kUpper, c);
    FAIL() << c.curves.points.size() << " points";
  } catch (const StageError& e) {
    EXPECT_NE(std::string(e.what()).find("8000 triangles meet at one vertex"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("borders.interpolate"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace meshmser
