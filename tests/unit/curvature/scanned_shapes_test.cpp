#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "data/scanner/shapes.hpp"
#include "data/scanner/virtual_scanner.hpp"
#include "stages/curvature/curvature.hpp"
#include "stages/load/load_scan.hpp"
#include "stages/orient/orient.hpp"

namespace meshmser {
namespace {

using Eigen::Vector3d;

struct Scanned {
  PointCloud cloud;
  ScalarFields scalars;
};

Scanned scanned(const std::string& name, double noise) {
  const auto& info = scanner::shape_info(name);
  const scanner::Shape shape = scanner::make_shape(name);
  const scanner::Extent extent = scanner::extent_of(shape.mesh);
  const auto poses = scanner::poses_around(extent.centre, 6 * extent.radius, info.views, info.cone, Vector3d(0, 0, 1));
  scanner::ScanOptions scan_options;
  scan_options.noise = noise;
  scan_options.spacing = scanner::spacing_for_points(shape, poses, scan_options, 50000);
  PosedScan raw;
  raw.geometry.positions = scanner::scan_shape(shape, poses, scan_options).points;
  Scanned result;
  result.cloud = load_scan({raw}).points;
  CurvatureOptions options;
  options.radius = 4 * result.cloud.spacing;
  OrientOptions upward;
  upward.viewpoint = Vector3d(0, 0, 1e4);
  const bool plate = name == "plane";
  result.scalars =
      measure_curvature(result.cloud, orient(result.cloud, plate ? upward : OrientOptions{}).normals, options).scalars;
  return result;
}

struct Statistics {
  double mean, deviation;
};

// Without the hundredth part at either end: rims and the few thin places.
Statistics inner(std::vector<double> values) {
  std::erase_if(values, [](double v) { return std::isnan(v); });
  std::sort(values.begin(), values.end());
  const std::size_t cut = values.size() / 100;
  double sum = 0, squares = 0;
  const auto count = static_cast<double>(values.size() - 2 * cut);
  for (std::size_t i = cut; i < values.size() - cut; ++i) sum += values[i], squares += values[i] * values[i];
  return {sum / count, std::sqrt(squares / count - sum * sum / (count * count))};
}

// Overlapping passes, line of sight, noise along the ray: the law of the noise holds on scans too.
TEST(ScannedShapes, HaveTheCurvatureAndTheNoiseThatIsStated) {
  for (const double noise : {0.1, 0.3, 0.5}) {
    const Scanned plate = scanned("plane", noise);
    const ScalarField& flat = *plate.scalars.find("mean_curvature");
    const Statistics s = inner(flat.values);
    SCOPED_TRACE(testing::Message() << "noise " << noise << ", plate: sigma " << flat.noise << ", measured "
                                    << s.deviation);
    EXPECT_NEAR(s.mean, 0, 0.1 * flat.noise);
    EXPECT_NEAR(s.deviation / flat.noise, 1, 0.3);

    const Scanned ball = scanned("sphere", noise);
    const ScalarField& round = *ball.scalars.find("mean_curvature");
    const Statistics b = inner(round.values);
    constexpr double kRadius = 10;  // the shape's default
    EXPECT_NEAR(b.mean * kRadius, 1, 0.02);
    EXPECT_NEAR(b.deviation / round.noise, 1, 0.3);
  }
}

}  // namespace
}  // namespace meshmser
