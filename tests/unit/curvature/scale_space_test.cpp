#include "stages/curvature/scale_space.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "tests/support/shapes.hpp"

namespace meshmser {
namespace {

using Eigen::Vector3d;

// One step, straight from the definition in definitions 3: every pair of points is looked at, Eigen finds the plane.
ScaleSpace literal_scale_space(const std::vector<Vector3d>& points, const std::vector<Vector3d>& normals, double radius,
                               int steps) {
  ScaleSpace result;
  result.positions = points;
  result.normals = normals;
  result.mean_curvature.resize(points.size());
  for (int step = 0; step < steps; ++step) {
    const std::vector<Vector3d> from = result.positions;
    for (std::size_t i = 0; i < from.size(); ++i) {
      std::vector<Vector3d> near;
      for (std::size_t j = 0; j < from.size(); ++j)
        if ((from[j] - from[i]).norm() <= radius && normals[i].dot(normals[j]) >= -0.5) near.push_back(from[j]);
      Vector3d centroid = Vector3d::Zero();
      for (const Vector3d& q : near) centroid += q / static_cast<double>(near.size());
      Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
      for (const Vector3d& q : near) covariance += (q - centroid) * (q - centroid).transpose();
      Vector3d n = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvectors().col(0);
      if (n.dot(result.normals[i]) < 0) n = -n;
      const double d = (centroid - from[i]).dot(n);
      result.positions[i] = from[i] + d * n;
      result.normals[i] = n;
      result.mean_curvature[i] = -4 * d / (radius * radius);
    }
  }
  return result;
}

TEST(ScaleSpaceSteps, EqualTheDefinition) {
  auto s = shapes::torus(1.0, 0.4, 0.09);
  shapes::add_noise(s, 0.02, 5);
  const ScaleSpace ours = scale_space(s.points, s.normals, {0.27, 3});
  const ScaleSpace literal = literal_scale_space(s.points, s.normals, 0.27, 3);
  for (std::size_t i = 0; i < s.points.size(); ++i) {
    EXPECT_LT((ours.positions[i] - literal.positions[i]).norm(), 1e-12);
    EXPECT_LT((ours.normals[i] - literal.normals[i]).norm(), 1e-9);
    EXPECT_NEAR(ours.mean_curvature[i], literal.mean_curvature[i], 1e-9);
  }
}

TEST(ScaleSpaceSteps, KeepTheSheetsOfAThinWallApart) {
  const double h = 0.1;
  auto s = shapes::plane(4, h);
  const std::size_t n = s.points.size();
  for (std::size_t i = 0; i < n; ++i) {
    s.points.push_back(s.points[i] - Vector3d(0, 0, 3 * h));
    s.normals.emplace_back(0, 0, -1);
  }
  const ScaleSpace space = scale_space(s.points, s.normals, {4 * h, 4});
  for (std::size_t i = 0; i < 2 * n; ++i) {
    EXPECT_NEAR(space.positions[i].z(), i < n ? 0 : -3 * h, 1e-12);
    EXPECT_NEAR(space.mean_curvature[i], 0, 1e-9);
  }
}

struct RelativeError {
  double mean = 0, rms = 0;
};

// Over the points at most `within` from the plane z = 0.
RelativeError relative_error(const shapes::Sample& s, double radius, double within) {
  const ScaleSpace space = scale_space(s.points, s.normals, {radius, 4});
  RelativeError error;
  double count = 0;
  for (std::size_t i = 0; i < s.points.size(); ++i) {
    if (std::abs(s.points[i].z()) > within) continue;
    const double e = space.mean_curvature[i] / s.mean_curvature[i] - 1;
    error.mean += e, error.rms += e * e, count += 1;
  }
  return {error.mean / count, std::sqrt(error.rms / count)};
}

TEST(MeanCurvature, OfAPlaneIsZeroUpToItsRim) {
  auto s = shapes::plane(6, 0.1);
  const ScaleSpace space = scale_space(s.points, s.normals, {0.4, 4});
  for (const double h : space.mean_curvature) EXPECT_NEAR(h, 0, 1e-10);
  for (const Vector3d& p : space.positions) EXPECT_NEAR(p.z(), 0, 1e-12);
}

TEST(MeanCurvature, HasItsSignAndIsRightWithinTwoPercent) {
  const double h = 0.02;
  for (const auto& [s, within] : {std::pair{shapes::sphere(1, h), 1.0}, std::pair{shapes::cylinder(0.5, 1.5, h), 0.4},
                                  std::pair{shapes::torus(1.2, 0.4, h), 1.0}}) {
    const RelativeError error = relative_error(s, 4 * h, within);
    EXPECT_NEAR(error.mean, 0, 0.02);
    EXPECT_LT(error.rms, 0.04);
    // The same from within: everything turns.
    auto inside = s;
    for (std::size_t i = 0; i < s.points.size(); ++i)
      inside.normals[i] = -s.normals[i], inside.mean_curvature[i] = -s.mean_curvature[i];
    EXPECT_EQ(relative_error(inside, 4 * h, within).mean, error.mean);
  }
}

// The error of a step is of second order in the radius: halving it quarters the error, as long as the sampling is fine.
TEST(MeanCurvature, ConvergesWithSecondOrder) {
  for (const auto& [s, within] :
       {std::pair{shapes::sphere(1, 0.02), 1.0}, std::pair{shapes::cylinder(1, 2.4, 0.02), 0.1},
        std::pair{shapes::torus(3, 1, 0.035), 2.0}}) {
    const double coarse = relative_error(s, 0.37, within).mean, fine = relative_error(s, 0.185, within).mean;
    EXPECT_NEAR(std::log2(coarse / fine), 2, 0.4) << coarse << " " << fine;
  }
}

TEST(MeanCurvature, ScalesAndTurnsWithTheCloud) {
  auto s = shapes::torus(1, 0.4, 0.05);
  shapes::add_noise(s, 0.01, 2);
  const auto before = scale_space(s.points, s.normals, {0.2, 4});
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  auto moved = s;
  for (std::size_t i = 0; i < s.points.size(); ++i) {
    moved.points[i] = 3 * (turn * s.points[i]) + Vector3d(1000, -2000, 500);
    moved.normals[i] = turn * s.normals[i];
  }
  const auto after = scale_space(moved.points, moved.normals, {0.6, 4});
  for (std::size_t i = 0; i < s.points.size(); ++i)
    EXPECT_NEAR(3 * after.mean_curvature[i], before.mean_curvature[i], 1e-6);
  EXPECT_NEAR(after.noise, 3 * before.noise, 1e-9);
}

TEST(MeanCurvature, DoesNotDependOnThreads) {
  auto s = shapes::torus(1, 0.4, 0.02);
  shapes::add_noise(s, 0.005, 3);
  const auto once = scale_space(s.points, s.normals, {0.08, 4}, {.threads = 1});
  for (const int threads : {2, 7}) {
    const auto again = scale_space(s.points, s.normals, {0.08, 4}, {.threads = threads});
    EXPECT_EQ(once.mean_curvature, again.mean_curvature);
    EXPECT_EQ(once.positions, again.positions);
    EXPECT_EQ(once.noise, again.noise);
  }
}

TEST(MeanCurvature, IsUndefinedWithoutNeighboursOrNormal) {
  auto s = shapes::plane(2, 0.1);
  s.points.emplace_back(50, 0, 0);
  s.normals.emplace_back(0, 0, 1);
  s.normals[7].setZero();
  const ScaleSpace space = scale_space(s.points, s.normals, {0.4, 4});
  EXPECT_EQ(space.num_isolated, 1);
  EXPECT_TRUE(std::isnan(space.mean_curvature.back()));
  EXPECT_EQ(space.positions.back(), s.points.back());
  EXPECT_TRUE(std::isnan(space.mean_curvature[7]));
  EXPECT_EQ(
      std::count_if(space.mean_curvature.begin(), space.mean_curvature.end(), [](double v) { return std::isnan(v); }),
      2);
  EXPECT_THROW(scale_space(s.points, s.normals, {0, 4}), StageError);
}

double deviation_inside(const std::vector<double>& values, const shapes::Sample& s, double within) {
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::max(std::abs(s.points[i].x()), std::abs(s.points[i].y())) > within) continue;
    sum += values[i] * values[i];
    count += 1;
  }
  return std::sqrt(sum / count);
}

TEST(MeanCurvatureNoise, FollowsItsLawOnNoisyPlanes) {
  const double h = 0.1;
  for (const double noise : {0.1, 0.3, 0.5})
    for (const auto& [radius, steps] :
         {std::pair{3 * h, 4}, std::pair{4 * h, 2}, std::pair{4 * h, 3}, std::pair{4 * h, 4}, std::pair{4 * h, 6},
          std::pair{6 * h, 4}, std::pair{4 * h, 1}}) {
      auto s = shapes::plane(14, h, 17);
      shapes::add_noise(s, noise * h, 23);
      const ScaleSpaceParameters parameters{radius, steps};
      const ScaleSpace space = scale_space(s.points, s.normals, parameters);
      EXPECT_NEAR(space.noise / (noise * h), 1, 0.12);
      const double measured = deviation_inside(space.mean_curvature, s, 5);
      const double law = mean_curvature_noise(space.noise, h, parameters);
      SCOPED_TRACE(testing::Message() << "noise " << noise << " h, radius " << radius / h << " h, steps " << steps);
      EXPECT_NEAR(std::max(measured, 0.0003 / h) / law, 1, 0.25);
    }
}

}  // namespace
}  // namespace meshmser
