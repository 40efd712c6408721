#include "stages/mser/fit_shapes.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace meshmser {
namespace {

/// Points of a surface with its normals, moved along them by noise.
struct Sample {
  std::vector<Eigen::Vector3d> points, normals;
  std::vector<double> weights;

  void add(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) {
    points.push_back(point);
    normals.push_back(normal);
    weights.push_back(1);
  }
  void disturb(std::mt19937& random, double deviation) {
    std::normal_distribution<double> noise(0, deviation);
    for (std::size_t i = 0; i < points.size(); ++i) points[i] += noise(random) * normals[i];
  }
  /// Anywhere in space.
  Eigen::Isometry3d move(std::mt19937& random, double far) {
    std::uniform_real_distribution<double> any(-1, 1);
    Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
    motion.linear() =
        Eigen::Quaterniond(any(random), any(random), any(random), any(random)).normalized().toRotationMatrix();
    motion.translation() = far * Eigen::Vector3d(any(random), any(random), any(random));
    for (auto& p : points) p = motion * p;
    for (auto& n : normals) n = motion.linear() * n;
    return motion;
  }
  FittedShapes fit() const { return fit_shapes(points, weights, normals); }
};

Sample plane(std::mt19937& random, double length, double width, int n) {
  std::uniform_real_distribution<double> any(-0.5, 0.5);
  Sample sample;
  for (int i = 0; i < n; ++i) sample.add({length * any(random), width * any(random), 0}, Eigen::Vector3d::UnitZ());
  return sample;
}

/// The cap of a sphere about 0 up to an angle from the z axis; pi: the whole sphere. `sign` -1: seen from within.
Sample cap(std::mt19937& random, double radius, double angle, double sign, int n) {
  std::uniform_real_distribution<double> height(std::cos(angle), 1), around(0, 2 * std::numbers::pi);
  Sample sample;
  for (int i = 0; i < n; ++i) {
    const double z = height(random), a = around(random), r = std::sqrt(1 - z * z);
    const Eigen::Vector3d out(r * std::cos(a), r * std::sin(a), z);
    sample.add(radius * out, sign * out);
  }
  return sample;
}

/// A part of a cylinder about the z axis: `angle` around it, `length` along it.
Sample tube(std::mt19937& random, double radius, double angle, double length, double sign, int n) {
  std::uniform_real_distribution<double> around(-angle / 2, angle / 2), along(-length / 2, length / 2);
  Sample sample;
  for (int i = 0; i < n; ++i) {
    const double a = around(random);
    const Eigen::Vector3d out(std::cos(a), std::sin(a), 0);
    sample.add(radius * out + Eigen::Vector3d(0, 0, along(random)), sign * out);
  }
  return sample;
}

double distance_to_line(const Eigen::Vector3d& p, const Eigen::Vector3d& point, const Eigen::Vector3d& axis) {
  return (p - point).cross(axis).norm();
}

TEST(FitShapes, PlaneWithNoise) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    Sample sample = plane(random, 20, 6, 400);
    sample.disturb(random, 0.05);
    const Eigen::Isometry3d motion = sample.move(random, 1000);
    const FittedShapes fit = sample.fit();
    EXPECT_EQ(fit.best, FittedShape::kPlane);
    EXPECT_NEAR(fit.plane_residual, 0.05, 0.01);
    EXPECT_NEAR(std::abs(fit.plane_normal.dot(motion.linear() * Eigen::Vector3d::UnitZ())), 1, 1e-4);
    EXPECT_NEAR((motion.inverse() * fit.plane_point).z(), 0, 0.02);
    EXPECT_LE(fit.sphere_residual, fit.plane_residual * (1 + 1e-9)) << "a plane is a sphere without curvature";
    EXPECT_LE(fit.cylinder_residual, fit.plane_residual * (1 + 1e-9));
  }
}

TEST(FitShapes, SphereWithNoiseFromCapToWhole) {
  for (unsigned seed = 1; seed <= 20; ++seed)
    for (const double angle : {0.4, 1.2, std::numbers::pi})
      for (const double sign : {1.0, -1.0}) {
        SCOPED_TRACE(testing::Message() << "seed " << seed << " angle " << angle << " sign " << sign);
        std::mt19937 random(seed);
        Sample sample = cap(random, 10, angle, sign, 400);
        sample.disturb(random, 0.02);
        const Eigen::Isometry3d motion = sample.move(random, 1000);
        const FittedShapes fit = sample.fit();
        EXPECT_EQ(fit.best, FittedShape::kSphere);
        EXPECT_NEAR(fit.sphere_residual, 0.02, 0.004);
        const double tolerance = angle < 1 ? 0.6 : 0.02;  // a cap of 0.8 in height tells its radius so well
        EXPECT_NEAR(fit.sphere_radius, sign * 10, tolerance);
        EXPECT_NEAR((motion.inverse() * fit.sphere_centre).norm(), 0, tolerance);
        EXPECT_GT(fit.cylinder_residual, fit.sphere_residual);
      }
}

TEST(FitShapes, CylinderWithNoiseFromStripToWhole) {
  for (unsigned seed = 1; seed <= 20; ++seed)
    for (const double angle : {0.8, 2.0, 2 * std::numbers::pi})
      for (const double length : {6.0, 30.0})
        for (const double sign : {1.0, -1.0}) {
          SCOPED_TRACE(testing::Message() << "seed " << seed << " angle " << angle << " length " << length);
          std::mt19937 random(seed);
          Sample sample = tube(random, 5, angle, length, sign, 400);
          sample.disturb(random, 0.02);
          const Eigen::Isometry3d motion = sample.move(random, 1000);
          const FittedShapes fit = sample.fit();
          EXPECT_EQ(fit.best, FittedShape::kCylinder);
          EXPECT_NEAR(fit.cylinder_residual, 0.02, 0.004);
          const double tolerance = angle < 1 ? 0.4 : 0.05;
          EXPECT_NEAR(fit.cylinder_radius, sign * 5, tolerance);
          const Eigen::Vector3d axis = motion.linear() * Eigen::Vector3d::UnitZ();
          EXPECT_NEAR(std::abs(fit.cylinder_axis.dot(axis)), 1, 5e-4);
          EXPECT_NEAR(distance_to_line(fit.cylinder_point, motion.translation(), axis), 0, tolerance);
        }
}

TEST(FitShapes, ExactShapesAreFoundExactly) {
  std::mt19937 random(3);
  const FittedShapes flat = plane(random, 3, 2, 100).fit();
  EXPECT_EQ(flat.best, FittedShape::kPlane);
  EXPECT_NEAR(flat.plane_residual, 0, 1e-12);
  const FittedShapes round = cap(random, 2, 1, 1, 100).fit();
  EXPECT_EQ(round.best, FittedShape::kSphere);
  EXPECT_NEAR(round.sphere_radius, 2, 1e-7);
  EXPECT_NEAR(round.sphere_residual, 0, 1e-7);
  const FittedShapes bore = tube(random, 2, 1, 3, -1, 100).fit();
  EXPECT_EQ(bore.best, FittedShape::kCylinder);
  EXPECT_NEAR(bore.cylinder_radius, -2, 1e-6);
  EXPECT_NEAR(bore.cylinder_residual, 0, 1e-7);
}

// No neighbour of the shape found is nearer to the points by a thousandth: it is a least-squares fit.
TEST(FitShapes, NothingNearbyFitsBetter) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    // Neither sphere nor cylinder: a saddle or bowl with noise.
    std::uniform_real_distribution<double> any(-1, 1);
    const double a = any(random), b = any(random);
    Sample sample;
    for (int i = 0; i < 150; ++i) {
      const double x = 2 * any(random), y = any(random);
      sample.add({x, y, a * x * x + b * y * y + 0.1 * normal(random)}, Eigen::Vector3d::UnitZ());
      sample.weights.back() = 1.5 + any(random);
    }
    const FittedShapes fit = sample.fit();
    const auto residual = [&](auto distance) {
      double sum = 0, weight = 0;
      for (std::size_t i = 0; i < sample.points.size(); ++i) {
        const double d = distance(sample.points[i]);
        sum += sample.weights[i] * d * d;
        weight += sample.weights[i];
      }
      return std::sqrt(sum / weight);
    };
    const auto sphere = [&](const Eigen::Vector3d& centre, double radius) {
      return residual([&](const Eigen::Vector3d& p) { return (p - centre).norm() - radius; });
    };
    const auto cylinder = [&](const Eigen::Vector3d& point, const Eigen::Vector3d& axis, double radius) {
      return residual([&](const Eigen::Vector3d& p) { return distance_to_line(p, point, axis) - radius; });
    };
    ASSERT_TRUE(std::isfinite(fit.sphere_radius) && std::isfinite(fit.cylinder_radius));
    const double sphere_radius = std::abs(fit.sphere_radius), cylinder_radius = std::abs(fit.cylinder_radius);
    EXPECT_NEAR(sphere(fit.sphere_centre, sphere_radius), fit.sphere_residual, 1e-9 * sphere_radius);
    EXPECT_NEAR(cylinder(fit.cylinder_point, fit.cylinder_axis, cylinder_radius), fit.cylinder_residual,
                1e-9 * cylinder_radius);
    for (int trial = 0; trial < 60; ++trial) {
      const auto shift = [&](double by) {
        return Eigen::Vector3d(by * Eigen::Vector3d(any(random), any(random), any(random)));
      };
      const double by = std::pow(10, -1 - trial % 4);
      EXPECT_GE(sphere(fit.sphere_centre + shift(by * sphere_radius), sphere_radius * (1 + by * any(random))),
                fit.sphere_residual * (1 - 1e-3));
      EXPECT_GE(cylinder(fit.cylinder_point + shift(by * cylinder_radius), (fit.cylinder_axis + shift(by)).normalized(),
                         cylinder_radius * (1 + by * any(random))),
                fit.cylinder_residual * (1 - 1e-3));
    }
  }
}

TEST(FitShapes, TooFewOrDegeneratePointsGiveNoShape) {
  Sample sample;
  EXPECT_EQ(sample.fit().best, FittedShape::kNone);
  for (int i = 0; i < 3; ++i) sample.add({i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0, 0}, Eigen::Vector3d::UnitZ());
  EXPECT_EQ(sample.fit().best, FittedShape::kNone);
  EXPECT_NEAR(sample.fit().plane_residual, 0, 1e-15);
  EXPECT_TRUE(std::isnan(sample.fit().sphere_residual));
  Sample one_place;
  for (int i = 0; i < 20; ++i) one_place.add({1, 2, 3}, Eigen::Vector3d::UnitZ());
  EXPECT_EQ(one_place.fit().best, FittedShape::kNone);
  Sample line;
  for (int i = 0; i < 20; ++i) line.add({1.0 * i, 2.0 * i, 0}, Eigen::Vector3d::UnitZ());
  const FittedShapes fit = line.fit();
  EXPECT_EQ(fit.best, FittedShape::kPlane);
  EXPECT_NEAR(fit.plane_residual, 0, 1e-9);
  EXPECT_FALSE(std::isnan(fit.sphere_residual) || std::isnan(fit.cylinder_residual));
}

}  // namespace
}  // namespace meshmser
