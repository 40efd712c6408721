#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <map>
#include <mutex>
#include <random>
#include <set>

#include "stages/common/cell_grid.hpp"
#include "stages/common/least_eigen.hpp"
#include "stages/common/nearest_neighbors.hpp"

namespace meshmser {
namespace {

using Eigen::Vector3d;

std::vector<Vector3d> random_points(std::uint32_t seed, int n, double extent = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-extent, extent);
  std::vector<Vector3d> points;
  for (int i = 0; i < n; ++i) {
    const double x = uniform(random), y = uniform(random), z = uniform(random);
    points.emplace_back(x, y, 0.2 * z);
  }
  return points;
}

TEST(LeastEigen, AgreesWithEigenOnCovariances) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (int round = 0; round < 3000; ++round) {
    SCOPED_TRACE(round);
    Eigen::Matrix3d axes;
    for (int i = 0; i < 9; ++i) axes(i / 3, i % 3) = normal(random);
    // From round clouds to sheets a millionth as thick as wide, at all scales.
    const double thin = std::pow(10.0, -(round % 7)), scale = std::pow(10.0, round % 13 - 6);
    const Eigen::Matrix3d a = scale * axes * Vector3d(thin * thin, 1, 1).asDiagonal() * axes.transpose();
    const LeastEigen ours = least_eigen({a(0, 0), a(0, 1), a(0, 2), a(1, 1), a(1, 2), a(2, 2)});
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> theirs(a);
    EXPECT_NEAR(ours.value, theirs.eigenvalues()[0], 1e-13 * a.trace());
    ASSERT_TRUE(ours.is_plane());
    EXPECT_NEAR(ours.vector.norm(), 1, 1e-12);
    const double gap = (theirs.eigenvalues()[1] - theirs.eigenvalues()[0]) / a.trace();
    EXPECT_LT((ours.vector.cross(theirs.eigenvectors().col(0))).norm(), 1e-13 / gap);
  }
}

TEST(LeastEigen, SaysWhenThereIsNoPlane) {
  EXPECT_FALSE(least_eigen({}).is_plane());
  EXPECT_FALSE(least_eigen({1, 0, 0, 0, 0, 0}).is_plane()) << "points on a line";
  EXPECT_FALSE(least_eigen({4, 4, 4, 4, 4, 4}).is_plane()) << "points on a slanted line";
  EXPECT_FALSE(least_eigen({1, 0, 0, 1, 0, 1}).is_plane()) << "no direction is least";
  const LeastEigen plane = least_eigen({1, 0, 0, 2, 0, 0});
  EXPECT_EQ(plane.value, 0);
  EXPECT_EQ(plane.vector.cwiseAbs(), Vector3d(0, 0, 1));
}

TEST(NearestNeighbors, AreThoseOfAnExhaustiveSearch) {
  const auto points = random_points(3, 700);
  const NearestNeighbors found = nearest_neighbors(points, 9);
  ASSERT_EQ(found.num_neighbors, 9);
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::vector<std::pair<double, std::int32_t>> all;
    for (std::size_t j = 0; j < points.size(); ++j)
      if (j != i) all.emplace_back((points[j] - points[i]).norm(), static_cast<std::int32_t>(j));
    std::sort(all.begin(), all.end());
    for (std::size_t k = 0; k < 9; ++k) EXPECT_EQ(found.of(static_cast<std::int64_t>(i))[k], all[k].second);
  }
}

TEST(NearestNeighbors, DoNotDependOnThreadsAndCopeWithFewOrEqualPoints) {
  const auto points = random_points(4, 5000);
  EXPECT_EQ(nearest_neighbors(points, 12, {.threads = 1}).ids, nearest_neighbors(points, 12, {.threads = 7}).ids);
  EXPECT_EQ(nearest_neighbors(random_points(5, 3), 12).num_neighbors, 2);
  EXPECT_TRUE(nearest_neighbors({}, 12).ids.empty());
  const std::vector<Vector3d> equal(20, Vector3d(1, 2, 3));
  const NearestNeighbors found = nearest_neighbors(equal, 5);
  for (std::int64_t i = 0; i < 20; ++i) {
    const std::set<std::int32_t> distinct(found.of(i).begin(), found.of(i).end());
    EXPECT_EQ(distinct.size(), 5u);
    EXPECT_FALSE(distinct.contains(static_cast<std::int32_t>(i)));
  }
}

// Every point is visited once, and its block holds exactly the points of the cells around it.
TEST(CellGrid, BlocksHoldEveryPointWithinReach) {
  for (const int reach : {1, 2, 3}) {
    SCOPED_TRACE(reach);
    auto points = random_points(11, 900);
    points.emplace_back(500, -300, 40);  // a stray far away
    const double cell = 0.07;
    const CellGrid grid(points, cell);
    std::map<std::int32_t, std::set<std::int32_t>> near;
    std::mutex mutex;
    for_each_cell(grid, reach, "", {}, [&](const CellBlock& block) {
      const std::scoped_lock lock(mutex);
      ASSERT_EQ(block.padded % kLanes, 0);
      ASSERT_LT(block.padded - block.num_candidates, kLanes);
      for (std::int64_t own = block.own_begin; own < block.own_end; ++own) {
        const std::int32_t id = block.ids[static_cast<std::size_t>(own)];
        ASSERT_FALSE(near.contains(id));
        auto& list = near[id];
        for (std::size_t i = 0; i < static_cast<std::size_t>(block.padded); ++i) {
          const auto s = static_cast<std::size_t>(own);
          const Vector3d d(block.x[i] - block.x[s], block.y[i] - block.y[s], block.z[i] - block.z[s]);
          if (d.norm() <= cell * reach) list.insert(block.ids[i]);
        }
      }
    });
    ASSERT_EQ(near.size(), points.size());
    for (const auto& [id, list] : near) {
      std::set<std::int32_t> expected;
      for (std::size_t j = 0; j < points.size(); ++j)
        if ((points[j] - points[static_cast<std::size_t>(id)]).norm() <= cell * reach)
          expected.insert(static_cast<std::int32_t>(j));
      EXPECT_EQ(list, expected) << "point " << id;
    }
  }
}

TEST(CellGrid, RefusesACloudOfTooManyCells) {
  const std::vector<Vector3d> points{{0, 0, 0}, {1e9, 0, 0}};
  EXPECT_THROW(CellGrid(points, 1e-3), StageError);
  EXPECT_THROW(CellGrid(points, 0), StageError);
  EXPECT_EQ(CellGrid({}, 1).rows().size(), 0u);
}

}  // namespace
}  // namespace meshmser
