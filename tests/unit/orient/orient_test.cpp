#include "stages/orient/orient.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "stages/orient/signed_union_find.hpp"
#include "tests/support/shapes.hpp"

namespace meshmser {
namespace {

using Eigen::Vector3d;
using shapes::cloud_of;

constexpr double kSpacing = 0.05;

double share_right(const std::vector<Vector3d>& normals, const shapes::Sample& s, std::size_t begin = 0,
                   std::size_t end = SIZE_MAX) {
  end = std::min(end, normals.size());
  std::size_t right = 0;
  for (std::size_t i = begin; i < end; ++i) right += normals[i].dot(s.normals[i]) > 0;
  return static_cast<double>(right) / static_cast<double>(end - begin);
}

void append(shapes::Sample& s, const shapes::Sample& other, const Vector3d& shift) {
  for (const Vector3d& p : other.points) s.points.push_back(p + shift);
  s.normals.insert(s.normals.end(), other.normals.begin(), other.normals.end());
}

TEST(SignedUnionFind, AgreesWithSignsThatWereGivenOut) {
  std::mt19937 random(3);
  for (int round = 0; round < 200; ++round) {
    const std::uint32_t n = 2 + random() % 60;
    std::vector<bool> sign(n);
    for (std::uint32_t i = 0; i < n; ++i) sign[i] = random() % 2;
    std::vector<std::uint32_t> set(n);
    for (std::uint32_t i = 0; i < n; ++i) set[i] = i;
    SignedUnionFind sets(n);
    for (std::uint32_t e = 0; e < 2 * n; ++e) {
      const std::uint32_t a = random() % n, b = random() % n;
      const bool joined = sets.join(a, b, sign[a] != sign[b]);
      EXPECT_EQ(joined, set[a] != set[b]);
      const std::uint32_t from = set[a], to = set[b];
      for (auto& s : set)
        if (s == from) s = to;
    }
    for (std::uint32_t i = 0; i < n; ++i)
      for (std::uint32_t j = 0; j < n; ++j) {
        ASSERT_EQ(sets.find(i).root == sets.find(j).root, set[i] == set[j]) << "round " << round;
        if (set[i] == set[j]) {
          ASSERT_EQ(sets.find(i).opposed != sets.find(j).opposed, sign[i] != sign[j]) << "round " << round;
        }
      }
  }
}

TEST(Orient, TurnsClosedShapesOutward) {
  for (const auto& s : {shapes::sphere(1, kSpacing), shapes::torus(1, 0.4, kSpacing),
                        shapes::box({2, 1.5, 1}, kSpacing), shapes::cylinder(0.5, 2, kSpacing)}) {
    const Orientation o = orient(cloud_of(s, kSpacing), {});
    ASSERT_EQ(o.normals.components.size(), 1u);
    EXPECT_EQ(o.normals.components[0].source, SignSource::kEnclosedVolume);
    EXPECT_GT(o.normals.components[0].confidence, 0.8);
    EXPECT_EQ(o.report.num_unoriented, 0);
    EXPECT_EQ(share_right(o.normals.normals, s), 1);
    for (const Vector3d& n : o.normals.normals) EXPECT_NEAR(n.norm(), 1, 1e-12);
  }
}

TEST(Orient, IsRightOnNoisyShapesWithSharpEdges) {
  for (const double noise : {0.1, 0.3, 0.5}) {
    auto s = shapes::box({3, 2, 1}, kSpacing);
    shapes::add_noise(s, noise * kSpacing, 9);
    const Orientation o = orient(cloud_of(s, kSpacing), {});
    EXPECT_GT(share_right(o.normals.normals, s), 0.99) << "noise " << noise;
    EXPECT_LT(static_cast<double>(o.report.num_disagreeing), 0.02 * static_cast<double>(o.report.num_edges));
  }
}

TEST(Orient, DoesNotMixTheSheetsOfAThinWall) {
  for (const double noise : {0.0, 0.1, 0.3}) {
    auto s = shapes::box({4, 3, 3 * kSpacing}, kSpacing);
    shapes::add_noise(s, noise * kSpacing, 4);
    const Orientation o = orient(cloud_of(s, kSpacing), {});
    EXPECT_GT(share_right(o.normals.normals, s), 0.99) << "noise " << noise;
    for (const NormalComponent& c : o.normals.components) EXPECT_EQ(c.source, SignSource::kEnclosedVolume);
  }
}

TEST(Orient, NamesOpenSheetsAsGuessesAndIslandsAsComponents) {
  auto s = shapes::plane(3, kSpacing);
  const std::size_t first = s.points.size();
  append(s, shapes::sphere(0.5, kSpacing), {0, 0, 5});
  const std::size_t second = s.points.size();
  append(s, shapes::plane(1, kSpacing), {5, 0, 0});
  const PointCloud cloud = cloud_of(s, kSpacing);
  const Orientation o = orient(cloud, {});
  ASSERT_EQ(o.normals.components.size(), 3u);
  EXPECT_EQ(o.normals.components[0].num_points, static_cast<std::int64_t>(first));
  EXPECT_EQ(o.normals.components[0].source, SignSource::kGuess);
  EXPECT_EQ(o.normals.components[1].source, SignSource::kEnclosedVolume);
  EXPECT_EQ(o.normals.components[2].source, SignSource::kGuess);
  EXPECT_LT((o.report.centers[1] - Vector3d(0, 0, 5)).norm(), 0.05);
  EXPECT_EQ(share_right(o.normals.normals, s, first, second), 1);
  // The plate lies below the cloud's centroid, because of the sphere: away from it is downward.
  EXPECT_EQ(share_right(o.normals.normals, s, 0, first), 0);

  OrientOptions options;
  options.viewpoint = Vector3d(0, 0, 100);
  const Orientation seen = orient(cloud, options);
  EXPECT_EQ(share_right(seen.normals.normals, s, 0, first), 1);
  EXPECT_EQ(share_right(seen.normals.normals, s, second), 1);
  EXPECT_EQ(seen.normals.components[2].source, SignSource::kViewpoint);

  options = {};
  options.flip = {1};
  const Orientation flipped = orient(cloud, options);
  EXPECT_EQ(share_right(flipped.normals.normals, s, 0, first), 1);
  EXPECT_EQ(share_right(flipped.normals.normals, s, first, second), 1);
  EXPECT_TRUE(flipped.normals.components[0].flipped_by_user);
  EXPECT_FALSE(flipped.normals.components[1].flipped_by_user);
  options.flip = {};
  options.flip_all = true;
  EXPECT_EQ(share_right(orient(cloud, options).normals.normals, s, first, second), 0);
  options = {};
  options.flip = {4};
  EXPECT_THROW(orient(cloud, options), StageError);
}

TEST(Orient, TurnsTowardTheScannerOfEachPoint) {
  // Two passes over a plate that lies far from the origin, one from above and one from below a second plate.
  auto s = shapes::plane(2, kSpacing);
  const std::size_t first = s.points.size();
  append(s, shapes::plane(2, kSpacing), {0, 0, -3});
  for (std::size_t i = first; i < s.points.size(); ++i) s.normals[i] = -s.normals[i];
  PointCloud cloud = cloud_of(s, kSpacing);
  cloud.origin = {1000, 2000, 3000};
  cloud.scans = {{"above", Vector3d(3, 0, 9), 0}, {"below", Vector3d(0, -2, -9), 0}};
  for (std::size_t i = first; i < s.points.size(); ++i) cloud.scan_of_point[i] = 1;
  const Orientation o = orient(cloud, {});
  EXPECT_EQ(share_right(o.normals.normals, s), 1);
  for (const NormalComponent& c : o.normals.components) {
    EXPECT_EQ(c.source, SignSource::kScanner);
    EXPECT_EQ(c.confidence, 1);
  }
  OrientOptions options;
  options.viewpoint = Vector3d(1000, 2000, 2998.5);  // between the plates, in the frame of the raw scan
  EXPECT_EQ(share_right(orient(cloud, options).normals.normals, s), 0);
  options = {};
  options.sign = SignChoice::kScanner;
  cloud.scans[0].scanner_position = cloud.scans[1].scanner_position = std::nullopt;
  EXPECT_THROW(orient(cloud, options), StageError);
}

TEST(Orient, TakesNormalsFromTheFileWhenAsked) {
  const auto s = shapes::sphere(1, kSpacing);
  PointCloud cloud = cloud_of(s, kSpacing);
  OrientOptions options;
  options.normals = NormalChoice::kGiven;
  EXPECT_THROW(orient(cloud, options), StageError);
  for (int axis = 0; axis < 3; ++axis) {
    Property property{std::string("n") + "xyz" [axis], ValueType::kFloat32, {}};
    for (const Vector3d& n : s.normals) property.values.push_back(-2 * n[axis]);  // inward, not of unit length
    cloud.properties.push_back(property);
  }
  const Orientation given = orient(cloud, options);
  EXPECT_EQ(given.normals.components[0].source, SignSource::kGiven);
  for (std::size_t i = 0; i < s.points.size(); ++i) EXPECT_LT((given.normals.normals[i] + s.normals[i]).norm(), 1e-12);
  options.normals = NormalChoice::kEstimated;
  EXPECT_EQ(share_right(orient(cloud, options).normals.normals, s), 1) << "given normals are not used unless asked for";
  options.sign = SignChoice::kGiven;
  EXPECT_EQ(share_right(orient(cloud, options).normals.normals, s), 0);
}

TEST(Orient, OrientsEveryPointOrCountsIt) {
  auto s = shapes::sphere(1, kSpacing);
  s.points.emplace_back(40, 0, 0);
  s.normals.emplace_back(1, 0, 0);
  const Orientation o = orient(cloud_of(s, kSpacing), {});
  EXPECT_EQ(o.report.num_unoriented, 1);
  EXPECT_EQ(o.normals.normals.back(), Vector3d::Zero());
  EXPECT_EQ(o.normals.component_of_point.back(), -1);
  EXPECT_EQ(orient({}, {}).normals.normals.size(), 0u);
  PointCloud two;
  two.positions = {{0, 0, 0}, {1, 0, 0}};
  EXPECT_EQ(orient(two, {}).report.num_unoriented, 2);
  // A handful of points has no spacing, but it has a plane.
  PointCloud few;
  few.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  const Orientation square = orient(few, {});
  EXPECT_EQ(square.report.num_unoriented, 0);
  for (const Vector3d& n : square.normals.normals) EXPECT_NEAR(std::abs(n.z()), 1, 1e-12);
}

TEST(Orient, GivesStrayPointsTheSignOfTheirSheet) {
  auto s = shapes::sphere(1, kSpacing);
  for (int i = 0; i < 20; ++i) s.points[static_cast<std::size_t>(i * 71)] *= 1 + 3 * kSpacing;
  const Orientation o = orient(cloud_of(s, kSpacing), {});
  EXPECT_EQ(o.normals.components.size(), 1u);
  EXPECT_GT(share_right(o.normals.normals, s), 0.997);
}

TEST(Orient, DoesNotDependOnThreads) {
  auto s = shapes::torus(1, 0.4, 0.03);
  shapes::add_noise(s, 0.015, 8);
  const PointCloud cloud = cloud_of(s, 0.03);
  Execution execution;
  execution.threads = 1;
  const Orientation once = orient(cloud, {}, execution);
  for (const int threads : {2, 7}) {
    execution.threads = threads;
    const Orientation again = orient(cloud, {}, execution);
    EXPECT_EQ(once.normals.normals, again.normals.normals);
    EXPECT_EQ(once.normals.component_of_point, again.normals.component_of_point);
    EXPECT_EQ(once.report.num_disagreeing, again.report.num_disagreeing);
  }
}

}  // namespace
}  // namespace meshmser
