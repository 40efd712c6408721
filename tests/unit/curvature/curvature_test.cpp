#include "stages/curvature/curvature.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "stages/curvature/quadric.hpp"
#include "tests/support/shapes.hpp"

namespace meshmser {
namespace {

using Eigen::Vector3d;

PointNormals normals_of(const shapes::Sample& s) {
  PointNormals result;
  result.normals = s.normals;
  result.component_of_point.assign(s.normals.size(), 0);
  result.components.push_back({static_cast<std::int64_t>(s.normals.size()), SignSource::kGiven, 1, false});
  return result;
}

double mean_of(const std::vector<double>& values, const shapes::Sample& s, double within) {
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (std::abs(s.points[i].z()) <= within) sum += values[i], count += 1;
  return sum / count;
}

double deviation_inside(const std::vector<double>& values, const shapes::Sample& s, double within) {
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (std::max(std::abs(s.points[i].x()), std::abs(s.points[i].y())) <= within)
      sum += values[i] * values[i], count += 1;
  return std::sqrt(sum / count);
}

// A quadric is fitted exactly, whatever its position: the paraboloid z = -(a x^2 + b y^2) / 2 seen from above has the
// curvatures a and b at its top.
TEST(Quadric, IsExactOnAParaboloid) {
  std::vector<Vector3d> points{{0, 0, 0}}, normals;
  auto s = shapes::plane(1, 0.1);
  for (const Vector3d& p : s.points) points.emplace_back(p.x(), p.y(), -(3 * p.x() * p.x() - 2 * p.y() * p.y()) / 2);
  normals.assign(points.size(), Vector3d(0, 0, 1));
  const auto k = fit_quadrics(points, normals, 0.5);
  EXPECT_NEAR(k.k1[0], 3, 1e-9);
  EXPECT_NEAR(k.k2[0], -2, 1e-9);
  for (Vector3d& n : normals) n = -n;
  EXPECT_NEAR(fit_quadrics(points, normals, 0.5).k1[0], 2, 1e-9);
}

TEST(Quadric, GivesPrincipalCurvatures) {
  const double h = 0.02;
  auto s = shapes::cylinder(0.5, 1.5, h);
  auto k = fit_quadrics(s.points, s.normals, 4 * h);
  EXPECT_NEAR(mean_of(k.k1, s, 0.5), 2, 0.02);
  EXPECT_NEAR(mean_of(k.k2, s, 0.5), 0, 0.02);
  s = shapes::sphere(1, h);
  k = fit_quadrics(s.points, s.normals, 4 * h);
  EXPECT_NEAR(mean_of(k.k1, s, 1), 1, 0.02);
  EXPECT_NEAR(mean_of(k.k2, s, 1), 1, 0.02);
  EXPECT_EQ(k.num_undefined, 0);
}

TEST(Quadric, IsUndefinedOnTooFewPoints) {
  const std::vector<Vector3d> points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0.1}, {2, 1, 0}};
  const std::vector<Vector3d> normals(5, Vector3d(0, 0, 1));
  const auto k = fit_quadrics(points, normals, 10);
  EXPECT_EQ(k.num_undefined, 5);
  EXPECT_TRUE(std::isnan(k.k1[0]) && std::isnan(k.k2[0]));
  EXPECT_THROW(fit_quadrics(points, normals, -1), StageError);
}

TEST(Quadric, NoiseFollowsItsLaw) {
  const double h = 0.1;
  for (const double radius : {4 * h, 6 * h}) {
    auto s = shapes::plane(14, h);
    shapes::add_noise(s, 0.2 * h, 3);
    PointCloud cloud = shapes::cloud_of(s, h);
    CurvatureOptions options;
    options.radius = radius;
    options.method = CurvatureMethod::kQuadric;
    const Curvature c = measure_curvature(cloud, normals_of(s), options);
    const ScalarField& mean = *c.scalars.find("mean_curvature");
    EXPECT_NEAR(deviation_inside(mean.values, s, 5) / mean.noise, 1, 0.15) << radius;
  }
}

TEST(Curvature, ListsItsScalarsWithUnitsAndNoise) {
  auto s = shapes::torus(1, 0.4, 0.05);
  CurvatureOptions options;
  options.radius = 0.2;
  const Curvature c = measure_curvature(shapes::cloud_of(s, 0.05), normals_of(s), options);
  std::vector<std::string> names;
  for (const ScalarField& f : c.scalars.fields) {
    names.push_back(f.name);
    const bool is_distance = f.name == "rim_distance";
    EXPECT_EQ(f.unit, is_distance ? "unit" : "1/unit");
    EXPECT_EQ(f.noise > 0, !is_distance);
    ASSERT_EQ(f.values.size(), s.points.size());
  }
  EXPECT_EQ(names,
            (std::vector<std::string>{"mean_curvature", "k1", "k2", "max_abs_curvature", "crease", "rim_distance"}));
  EXPECT_EQ(c.scalars.find("mean_curvature")->parity, Parity::kOdd);
  EXPECT_EQ(c.scalars.find("crease")->parity, Parity::kEven);
  EXPECT_EQ(c.smoothed.radius, 0.2);
  EXPECT_EQ(c.smoothed.steps, 4);
  for (std::size_t i = 0; i < s.points.size(); ++i) {
    const double h = c.scalars.find("mean_curvature")->values[i], k1 = c.scalars.find("k1")->values[i],
                 k2 = c.scalars.find("k2")->values[i], largest = c.scalars.find("max_abs_curvature")->values[i];
    EXPECT_GE(k1, k2);
    EXPECT_EQ(largest, std::max(std::abs(k1), std::abs(k2)));
    EXPECT_NEAR(c.scalars.find("crease")->values[i], std::hypot(largest, 2 * h), 1e-12);
  }
}

TEST(Curvature, LeavesPointsWithoutNormalUndefined) {
  auto s = shapes::sphere(1, 0.05);
  s.normals[10].setZero();
  CurvatureOptions options;
  options.radius = 0.2;
  options.height_radius = 0.4;
  for (const CurvatureMethod method : {CurvatureMethod::kScaleSpace, CurvatureMethod::kQuadric}) {
    options.method = method;
    const Curvature c = measure_curvature(shapes::cloud_of(s, 0.05), normals_of(s), options);
    EXPECT_EQ(c.report.num_unoriented, 1);
    for (const ScalarField& f : c.scalars.fields)
      for (std::size_t i = 0; i < f.values.size(); ++i)
        EXPECT_EQ(std::isnan(f.values[i]), i == 10) << f.name << " " << i;
  }
}

TEST(Height, IsPositiveOnReliefAndItsNoiseIsThePointsOwn) {
  const double h = 0.05;
  auto s = shapes::plane(8, h);
  shapes::add_noise(s, 0.2 * h, 6);
  CurvatureOptions options;
  options.radius = 4 * h;
  options.height_radius = 0.6;
  const Curvature flat = measure_curvature(shapes::cloud_of(s, h), normals_of(s), options);
  const ScalarField& noise = *flat.scalars.find("height");
  EXPECT_EQ(noise.unit, "unit");
  EXPECT_EQ(noise.parity, Parity::kOdd);
  EXPECT_NEAR(deviation_inside(noise.values, s, 3) / noise.noise, 1, 0.08);

  for (Vector3d& p : s.points) p.z() += std::hypot(p.x() - 1, p.y()) < 0.15 ? 0.3 : 0;
  for (Vector3d& p : s.points) p.z() -= std::hypot(p.x() + 1, p.y()) < 0.15 ? 0.3 : 0;
  const Curvature c = measure_curvature(shapes::cloud_of(s, h), normals_of(s), options);
  for (std::size_t i = 0; i < s.points.size(); ++i) {
    const double height = c.scalars.find("height")->values[i];
    if (std::hypot(s.points[i].x() - 1, s.points[i].y()) < 0.13) {
      EXPECT_GT(height, 0.2);
    }
    if (std::hypot(s.points[i].x() + 1, s.points[i].y()) < 0.13) {
      EXPECT_LT(height, -0.2);
    }
  }
}

}  // namespace
}  // namespace meshmser
