#include <gtest/gtest.h>

#include <algorithm>

#include "data/scanner/shapes.hpp"
#include "data/scanner/virtual_scanner.hpp"
#include "stages/load/load_scan.hpp"
#include "stages/orient/orient.hpp"

namespace meshmser {
namespace {

using Eigen::Vector3d;

struct Case {
  const char* shape;
  double noise, outliers, registration;  // noise and registration in spacings of one pass
  double least_share;
};

class ScannedParts : public testing::TestWithParam<Case> {};

// Of the points that lie on the surface, up to one flip of each component whose side was a guess.
TEST_P(ScannedParts, AreOrientedRight) {
  const Case& c = GetParam();
  const auto& info = scanner::shape_info(c.shape);
  const scanner::Shape shape = scanner::make_shape(c.shape);
  const scanner::Extent extent = scanner::extent_of(shape.mesh);
  const auto poses = scanner::poses_around(extent.centre, 6 * extent.radius, info.views, info.cone, Vector3d(0, 0, 1));
  scanner::ScanOptions options;
  options.noise = c.noise;
  options.outliers = c.outliers;
  options.registration = c.registration;
  options.holes = 4;
  options.spacing = scanner::spacing_for_points(shape, poses, options, 60000);
  const scanner::SimulatedScan scan = scanner::scan_shape(shape, poses, options);
  PosedScan raw;
  raw.geometry.positions = scan.points;
  const PointCloud cloud = load_scan({raw}).points;

  const Orientation o = orient(cloud, {});
  std::vector<std::array<double, 2>> wrong_and_right(o.normals.components.size(), {0, 0});
  double total = 0;
  for (std::size_t i = 0; i < cloud.num_points(); ++i) {
    const Vector3d truth = scan.true_normals[static_cast<std::size_t>(cloud.raw_index_of_point[i])].cast<double>();
    if (truth == Vector3d::Zero()) continue;
    total += 1;
    const std::int32_t component = o.normals.component_of_point[i];
    if (component >= 0)
      wrong_and_right[static_cast<std::size_t>(component)][o.normals.normals[i].dot(truth) > 0 ? 1 : 0] += 1;
  }
  double right = 0;
  for (std::size_t k = 0; k < wrong_and_right.size(); ++k) {
    const bool guessed = o.normals.components[k].source == SignSource::kGuess;
    right += guessed ? std::max(wrong_and_right[k][0], wrong_and_right[k][1]) : wrong_and_right[k][1];
  }
  EXPECT_GT(right / total, c.least_share) << o.normals.components.size() << " components";
  const bool closed = std::string(c.shape) == "pump" || std::string(c.shape) == "bracket";
  EXPECT_EQ(o.normals.components[0].source, closed ? SignSource::kEnclosedVolume : SignSource::kGuess);
}

INSTANTIATE_TEST_SUITE_P(Orient, ScannedParts,
                         testing::Values(Case{"pump", 0.1, 0, 0, 0.998}, Case{"pump", 0.3, 0.005, 0, 0.993},
                                         Case{"pump", 0.3, 0.005, 0.5, 0.985}, Case{"bracket", 0.1, 0, 0, 0.998},
                                         Case{"bracket", 0.3, 0.005, 0, 0.995}, Case{"diamond", 0.3, 0, 0, 0.998},
                                         Case{"tablet", 0.3, 0.005, 0, 0.998}),
                         [](const auto& test) {
                           return std::string(test.param.shape) + "_" + std::to_string(test.index);
                         });

}  // namespace
}  // namespace meshmser
