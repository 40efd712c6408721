#include "stages/load/load_scan.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "stages/load/canonical_order.hpp"

namespace meshmser {
namespace {

using ::testing::HasSubstr;

PosedScan cloud_of(std::vector<Eigen::Vector3d> positions, const std::string& name = "scan.xyz") {
  PosedScan scan;
  scan.geometry.name = name;
  scan.geometry.positions = std::move(positions);
  return scan;
}

std::vector<Eigen::Vector3d> random_points(int n, unsigned seed, double scale = 1,
                                           const Eigen::Vector3d& shift = Eigen::Vector3d::Zero()) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, scale);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < n; ++i)
    points.push_back(shift + Eigen::Vector3d(uniform(random), uniform(random), uniform(random)));
  return points;
}

std::vector<Eigen::Vector3d> grid_points(int side, double step) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) points.emplace_back(i * step, j * step, 0);
  return points;
}

TEST(LoadScan, KeepsEveryPointOnceWithItsRawIndex) {
  const std::vector<Eigen::Vector3d> raw = random_points(5000, 1);
  const PointCloud points = load_scan({cloud_of(raw)}).points;
  ASSERT_EQ(points.num_points(), raw.size());
  std::vector<int> seen(raw.size(), 0);
  for (std::size_t p = 0; p < points.num_points(); ++p) {
    const auto i = static_cast<std::size_t>(points.raw_index_of_point[p]);
    ++seen[i];
    EXPECT_EQ(points.positions[p] + points.origin, raw[i]);
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), static_cast<std::ptrdiff_t>(raw.size()));
}

TEST(LoadScan, ShuffledInputGivesTheSameIds) {
  std::vector<Eigen::Vector3d> raw = random_points(4000, 2, 10, {-3, 1e6, 0.2});
  for (int i = 0; i < 500; ++i) raw.push_back(raw[static_cast<std::size_t>(7 * i)]);  // duplicates
  PosedScan first = cloud_of(raw);
  Property intensity{"intensity", ValueType::kFloat32, {}};
  std::mt19937 random(3);
  for (std::size_t i = 0; i < raw.size(); ++i) intensity.values.push_back(static_cast<double>(random() % 1000));
  first.geometry.properties = {intensity};
  std::vector<std::size_t> order(raw.size());
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), random);
  PosedScan second = first;
  for (std::size_t i = 0; i < order.size(); ++i) {
    second.geometry.positions[i] = raw[order[i]];
    second.geometry.properties[0].values[i] = intensity.values[order[i]];
  }
  const PointCloud a = load_scan({first}).points, b = load_scan({second}, {}, Execution{3, nullptr, {}}).points;
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.origin, b.origin);
  EXPECT_EQ(a.spacing, b.spacing);
  EXPECT_EQ(a.properties[0].values, b.properties[0].values);
  for (std::size_t p = 0; p < b.num_points(); ++p)
    EXPECT_EQ(second.geometry.positions[static_cast<std::size_t>(b.raw_index_of_point[p])],
              raw[static_cast<std::size_t>(a.raw_index_of_point[p])]);
}

TEST(LoadScan, OrderIsByMortonCode) {
  const PointCloud points = load_scan({cloud_of(random_points(3000, 4, 5))}).points;
  std::vector<Eigen::Vector3d> world;
  for (const Eigen::Vector3d& p : points.positions) world.push_back(p + points.origin);
  const MortonGrid grid = morton_grid(world);
  for (std::size_t p = 1; p < world.size(); ++p) EXPECT_LE(grid.code(world[p - 1]), grid.code(world[p]));
}

TEST(LoadScan, SpacingOfASquareGridIsItsStep) {
  // 16 neighbours and half the cell of the 16th fill a disc of 16.5 cells: h is the step but for the disc's raggedness.
  const double h = load_scan({cloud_of(grid_points(200, 0.25))}).points.spacing;
  EXPECT_NEAR(h, 0.25, 0.04 * 0.25);
}

TEST(LoadScan, SpacingEqualsItsDefinitionByBruteForce) {
  const std::vector<Eigen::Vector3d> raw = random_points(900, 5, 3);
  std::vector<double> d16;
  for (const Eigen::Vector3d& p : raw) {
    std::vector<double> distances;
    for (const Eigen::Vector3d& q : raw) distances.push_back((p - q).norm());
    std::sort(distances.begin(), distances.end());
    d16.push_back(distances[16]);  // [0] is the point itself
  }
  std::sort(d16.begin(), d16.end());
  EXPECT_NEAR(load_scan({cloud_of(raw)}).points.spacing, d16[d16.size() / 2] * std::sqrt(M_PI / 16.5), 1e-12);
}

TEST(LoadScan, SpacingOfFewPointsIsZero) {
  EXPECT_EQ(load_scan({cloud_of(random_points(16, 6))}).points.spacing, 0);
  EXPECT_GT(load_scan({cloud_of(random_points(17, 6))}).points.spacing, 0);
}

TEST(LoadScan, OriginLosesNothingFarFromZero) {
  const std::vector<Eigen::Vector3d> raw = random_points(2000, 7, 30, {4.5e6, -5.1e5, 412.0});
  const PointCloud points = load_scan({cloud_of(raw)}).points;
  EXPECT_NE(points.origin.x(), 0);
  EXPECT_NE(points.origin.y(), 0);
  for (std::size_t p = 0; p < points.num_points(); ++p) {
    const Eigen::Vector3d& exact = raw[static_cast<std::size_t>(points.raw_index_of_point[p])];
    EXPECT_EQ(points.positions[p] + points.origin, exact);
    for (int axis = 0; axis < 2; ++axis)
      EXPECT_EQ(static_cast<long double>(exact[axis]) - static_cast<long double>(points.origin[axis]),
                static_cast<long double>(points.positions[p][axis]));
    EXPECT_LT(points.positions[p].norm(), 1000);
  }
}

TEST(LoadScan, OriginStaysZeroNearZero) {
  EXPECT_EQ(load_scan({cloud_of(random_points(100, 8, 10, {20, -30, 5}))}).points.origin, Eigen::Vector3d::Zero());
}

TEST(LoadScan, ListsWhatItDroppedAndWhy) {
  const double nan = std::nan("");
  std::vector<Eigen::Vector3d> raw = random_points(50, 9);
  raw[3] = {nan, 0, 0};
  raw[8] = {0, std::numeric_limits<double>::infinity(), 0};
  raw[20] = raw[10];
  raw[40] = {5, 5, 5};
  LoadScanOptions options;
  options.crop = Eigen::AlignedBox3d(Eigen::Vector3d::Zero(), Eigen::Vector3d::Ones());
  const LoadedScan loaded = load_scan({cloud_of(raw)}, options);
  EXPECT_EQ(loaded.points.num_points(), 46u);
  EXPECT_EQ(loaded.report.num_non_finite, 2);
  EXPECT_EQ(loaded.report.num_duplicates, 1);
  EXPECT_EQ(loaded.report.num_cropped, 1);
  EXPECT_EQ(loaded.points.dropped_raw_index, (std::vector<std::int64_t>{3, 8, 20, 40}));
  EXPECT_EQ(loaded.points.drop_reasons, (std::vector<DropReason>{DropReason::kNonFinite, DropReason::kNonFinite,
                                                                 DropReason::kDuplicate, DropReason::kCropped}));
  const std::int32_t kept = loaded.points.kept_point_of_dropped[2];
  ASSERT_GE(kept, 0);
  EXPECT_EQ(loaded.points.raw_index_of_point[static_cast<std::size_t>(kept)], 10);
  EXPECT_EQ(loaded.points.kept_point_of_dropped[3], -1);
}

TEST(LoadScan, NegativeZeroIsZero) {
  EXPECT_EQ(load_scan({cloud_of({{0.0, 1, 1}, {-0.0, 1, 1}, {2, 2, 2}})}).report.num_duplicates, 1);
}

TEST(LoadScan, PosesAndScannersMoveTogether) {
  PosedScan a = cloud_of({{1, 0, 0}}, "a"), b = cloud_of({{1, 0, 0}}, "b");
  b.world_from_file = Eigen::Translation3d(0, 0, 5) * Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ());
  b.scanner_position = Eigen::Vector3d(2, 0, 0);
  b.geometry.properties = {
      {"nx", ValueType::kFloat64, {1}}, {"ny", ValueType::kFloat64, {0}}, {"nz", ValueType::kFloat64, {0}}};
  const PointCloud points = load_scan({a, b}).points;
  ASSERT_EQ(points.num_points(), 2u);
  const std::size_t of_b = points.scan_of_point[0] == 1 ? 0 : 1;
  EXPECT_LT((points.positions[of_b] - Eigen::Vector3d(0, 1, 5)).norm(), 1e-15);
  EXPECT_LT((*points.scans[1].scanner_position - Eigen::Vector3d(0, 2, 5)).norm(), 1e-15);
  EXPECT_FALSE(points.scans[0].scanner_position.has_value());
  EXPECT_EQ(points.raw_index_of_point[of_b], 1);
  EXPECT_NEAR(points.properties[1].values[of_b], 1, 1e-15);
  EXPECT_TRUE(std::isnan(points.properties[1].values[1 - of_b]));
}

TEST(LoadScan, OutliersGo) {
  std::vector<Eigen::Vector3d> raw = grid_points(60, 0.1);
  raw.emplace_back(3, 3, 2);
  raw.emplace_back(1, 3, -2);
  for (const OutlierMethod method : {OutlierMethod::kStatistical, OutlierMethod::kRadius}) {
    LoadScanOptions options;
    options.outliers = {method, 6, 3, 3};
    const LoadedScan loaded = load_scan({cloud_of(raw)}, options);
    EXPECT_EQ(loaded.report.num_outliers, 2);
    EXPECT_EQ(loaded.points.dropped_raw_index, (std::vector<std::int64_t>{3600, 3601}));
    EXPECT_EQ(loaded.points.drop_reasons[0], DropReason::kOutlier);
  }
}

void expect_error(const std::vector<PosedScan>& scans, const LoadScanOptions& options, const std::string& part) {
  try {
    load_scan(scans, options);
    ADD_FAILURE() << "no error; expected " << part;
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr(part));
  }
}

TEST(LoadScan, SaysWhatIsWrong) {
  LoadScanOptions crop;
  crop.crop = Eigen::AlignedBox3d(Eigen::Vector3d(5, 5, 5), Eigen::Vector3d(6, 6, 6));
  expect_error({}, {}, "no files to load");
  expect_error({cloud_of({{0, 0, 0}})}, crop, "scan.xyz: no points are left: 0 not finite, 1 outside 'crop'");
  expect_error({cloud_of({{0, 0, std::nan("")}})}, {}, "1 not finite");
  expect_error({cloud_of({{0, 0, 1e200}, {0, 0, 0}})}, {}, "a coordinate exceeds 1e+100");
}

}  // namespace
}  // namespace meshmser
