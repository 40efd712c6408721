#include "data/scanner/virtual_scanner.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>

#include "data/scanner/shapes.hpp"
#include "pipeline/execution/error.hpp"

namespace meshmser::scanner {
namespace {

SimulatedScan scan(const Shape& shape, const ScanOptions& options, int views = 6, double cone = 180,
                   const Execution& execution = {}) {
  const Extent extent = extent_of(shape.mesh);
  return scan_shape(shape, poses_around(extent.centre, 5 * extent.radius, views, cone, {0, 0, 1}), options, execution);
}

ScanOptions exact(double spacing) {
  ScanOptions options;
  options.spacing = spacing;
  options.noise = 0;
  options.dropouts = 0;
  return options;
}

TEST(VirtualScanner, ExactPointsLieOnTheAnalyticSurface) {
  // The meshes' chords stay within 0.003 of the surfaces.
  for (const Eigen::Vector3d& p : scan(make_shape("sphere"), exact(0.5)).points) ASSERT_NEAR(p.norm(), 10, 0.003);
  for (const Eigen::Vector3d& p : scan(make_shape("torus"), exact(0.5)).points)
    ASSERT_NEAR(std::hypot(std::hypot(p.x(), p.y()) - 15, p.z()), 5, 0.005);
  const SimulatedScan cylinder = scan(make_shape("cylinder"), exact(0.5));
  std::set<std::int32_t> faces;
  for (std::size_t i = 0; i < cylinder.points.size(); ++i) {
    const Eigen::Vector3d& p = cylinder.points[i];
    faces.insert(cylinder.face_of_point[i]);
    if (cylinder.face_of_point[i] == 1) {
      ASSERT_NEAR(std::hypot(p.x(), p.y()), 8, 0.003);
    }
    if (cylinder.face_of_point[i] == 2) {
      ASSERT_NEAR(p.z(), -15, 1e-9);
    }
    if (cylinder.face_of_point[i] == 3) {
      ASSERT_NEAR(p.z(), 15, 1e-9);
    }
  }
  EXPECT_EQ(faces.size(), 3u);
}

TEST(VirtualScanner, NoiseIsGaussianAlongTheRayInSpacings) {
  ScanOptions options = exact(0.2);
  options.noise = 0.3;
  const SimulatedScan noisy = scan(make_shape("plane", {{"thickness", 0}}), options, 1, 0);
  double sum = 0, squares = 0;
  for (const Eigen::Vector3d& p : noisy.points) {
    sum += p.z();
    squares += p.z() * p.z();
  }
  const auto n = static_cast<double>(noisy.points.size());
  ASSERT_GT(n, 30000);
  EXPECT_NEAR(sum / n, 0, 0.0015);
  EXPECT_NEAR(std::sqrt(squares / n), 0.06, 0.0015);  // rays are nearly at right angles to the plate
}

TEST(VirtualScanner, OnlyWhatIsInSightIsMeasured) {
  // From above, nothing of a ball's lower half is seen, and grazing hits are lost.
  const SimulatedScan above = scan(make_shape("sphere"), exact(0.3), 1, 0);
  for (const Eigen::Vector3d& p : above.points) EXPECT_GT(p.z(), 10 * std::cos(78 * M_PI / 180) - 0.1);
  // By the law of sines the ray that meets the ball at 78 degrees leaves the scanner at this angle; rays are one
  // spacing apart in the plane through the centre.
  const double distance = 5 * extent_of(make_shape("sphere").mesh).radius;
  const double angle = std::asin(10 * std::sin(78 * M_PI / 180) / distance), disc = distance * std::tan(angle);
  EXPECT_NEAR(static_cast<double>(above.points.size()) / (M_PI * disc * disc / 0.09), 1, 0.01);
}

TEST(VirtualScanner, TruthIsThatOfThePoint) {
  const SimulatedScan pyramids = scan(make_shape("diamond"), exact(0.4), 3, 40);
  for (std::size_t i = 0; i < pyramids.points.size(); ++i) {
    const std::int32_t face = pyramids.face_of_point[i];
    if (face > 64) continue;  // walls
    const Eigen::Vector3d& p = pyramids.points[i];
    const int cell_x = (face - 1) / 4 % 4, cell_y = (face - 1) / 16, facet = (face - 1) % 4;
    const Eigen::Vector2d local(p.x() - (cell_x * 10 - 15), p.y() - (cell_y * 10 - 15));
    static const Eigen::Vector2d toward[] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
    // On the plane of that facet, and its normal.
    ASSERT_NEAR(p.z(), 2.5 - local.dot(toward[facet]) / 2, 1e-6);
    const Eigen::Vector3d normal = Eigen::Vector3d(toward[facet].x() / 2, toward[facet].y() / 2, 1).normalized();
    ASSERT_LT((pyramids.true_normals[i].cast<double>() - normal).norm(), 1e-6);
  }
}

TEST(VirtualScanner, SameScanForAnyNumberOfThreads) {
  ScanOptions options;
  options.spacing = 0.6;
  options.holes = 2;
  options.outliers = 0.01;
  options.registration = 0.5;
  const Shape shape = make_shape("torus");
  Execution one, seven;
  one.threads = 1;
  seven.threads = 7;
  const SimulatedScan a = scan(shape, options, 5, 180, one), b = scan(shape, options, 5, 180, seven);
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.face_of_point, b.face_of_point);
  options.seed = 2;
  EXPECT_NE(a.points, scan(shape, options).points);
}

TEST(VirtualScanner, HolesAreFreeOfPointsOnTheirSide) {
  ScanOptions options = exact(0.4);
  options.holes = 4;
  options.hole_radius = 2;
  const SimulatedScan holed = scan(make_shape("sphere"), options, 10);
  ASSERT_EQ(holed.holes.size(), 4u);
  for (const ScanHole& hole : holed.holes) {
    EXPECT_NEAR(hole.centre.norm(), 10, 0.01);
    for (const Eigen::Vector3d& p : holed.points) ASSERT_GE((p - hole.centre).norm(), 2);
    for (const ScanHole& other : holed.holes)
      if (&other != &hole) {
        EXPECT_GE((other.centre - hole.centre).norm(), 6);
      }
  }
}

TEST(VirtualScanner, OutliersDropoutsAndRegistrationHaveTheirSize) {
  const Shape shape = make_shape("sphere");
  const std::size_t all = scan(shape, exact(0.4)).points.size();
  ScanOptions options = exact(0.4);
  options.dropouts = 0.2;
  EXPECT_NEAR(static_cast<double>(scan(shape, options).points.size()) / static_cast<double>(all), 0.8, 0.02);

  options = exact(0.4);
  options.outliers = 0.05;
  const SimulatedScan spoilt = scan(shape, options);
  EXPECT_NEAR(static_cast<double>(std::count(spoilt.face_of_point.begin(), spoilt.face_of_point.end(), 0)) /
                  static_cast<double>(spoilt.points.size()),
              0.05, 1e-3);

  options = exact(0.4);
  options.shuffle = false;
  const SimulatedScan right = scan(shape, options, 12);
  options.registration = 1;
  const SimulatedScan moved = scan(shape, options, 12);
  ASSERT_EQ(right.points.size(), moved.points.size());
  double squares = 0;
  for (std::size_t i = 0; i < right.points.size(); ++i) squares += (right.points[i] - moved.points[i]).squaredNorm();
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(right.points.size())), 0.4, 0.06);
  EXPECT_FALSE(right.scanner_positions[0].isApprox(moved.scanner_positions[0], 1e-6));
}

TEST(VirtualScanner, SpacingForPointsMeetsTheNumber) {
  const Shape shape = make_shape("cylinder");
  const Extent extent = extent_of(shape.mesh);
  const auto poses = poses_around(extent.centre, 5 * extent.radius, 8, 180, {0, 0, 1});
  ScanOptions options;
  options.spacing = spacing_for_points(shape, poses, options, 60000);
  EXPECT_NEAR(static_cast<double>(scan_shape(shape, poses, options).points.size()), 60000, 1200);
}

TEST(VirtualScanner, ErrorsSayWhatToDo) {
  const Shape shape = make_shape("sphere", {{"level", 2}});
  ScanOptions options;
  options.spacing = 0;
  EXPECT_THROW(scan(shape, options), UsageError);
  options.spacing = 1;
  EXPECT_THROW(scan_shape(shape, {{{0, 0, 50}, {0, 0, 100}}}, options), StageError);
  options.holes = 500;
  EXPECT_THROW(scan(shape, options), StageError);
}

}  // namespace
}  // namespace meshmser::scanner
