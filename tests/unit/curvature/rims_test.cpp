#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "stages/curvature/curvature.hpp"
#include "tests/support/shapes.hpp"

namespace meshmser {
namespace {

using Eigen::Vector3d;

Curvature measured(const shapes::Sample& s, double spacing, double radius, RimTreatment rims = RimTreatment::kMark) {
  PointNormals normals;
  normals.normals = s.normals;
  normals.component_of_point.assign(s.normals.size(), 0);
  normals.components.push_back({static_cast<std::int64_t>(s.normals.size()), SignSource::kGiven, 1, false});
  CurvatureOptions options;
  options.radius = radius;
  options.rims = rims;
  return measure_curvature(shapes::cloud_of(s, spacing), normals, options);
}

constexpr double kSpacing = 0.02;
constexpr double kRadius = 4 * kSpacing;
constexpr double kOpening = 1.1;  // angle from the pole to the rim

/// The part of the unit sphere within kOpening of the pole, points at random: the rim of a scan is never a lattice's.
shapes::Sample cap(double noise) {
  shapes::Sample s;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> turn(0, 2 * std::numbers::pi), height(std::cos(kOpening), 1);
  const double area = 2 * std::numbers::pi * (1 - std::cos(kOpening));
  while (static_cast<double>(s.points.size()) < area / (kSpacing * kSpacing)) {
    const double a = turn(random), z = height(random), r = std::sqrt(1 - z * z);
    s.points.emplace_back(r * std::cos(a), r * std::sin(a), z);
    s.normals.push_back(s.points.back());
    s.mean_curvature.push_back(1);
  }
  shapes::add_noise(s, noise * kSpacing, 5);
  return s;
}

double true_distance(const Vector3d& p) {
  return kOpening - std::acos(p.z() / p.norm());
}

struct Mean {
  double sum = 0, count = 0;
  void add(double value) { sum += value, count += 1; }
  double value() const { return sum / count; }
};

// A sphere's cap loses curvature toward its free rim. The points where it does are told.
TEST(Rims, OfASphericalCapAreMarkedWhereCurvatureIsBiased) {
  for (const double noise : {0.0, 0.1, 0.3}) {
    SCOPED_TRACE(testing::Message() << "noise " << noise);
    const shapes::Sample s = cap(noise);
    const Curvature c = measured(s, kSpacing, kRadius);
    const auto& h = c.scalars.find("mean_curvature")->values;
    const auto& distance = c.scalars.find("rim_distance")->values;
    Mean inner, marked, unmarked, far, error;
    double num_far = 0, wrongly_marked = 0, num_at_rim = 0, missed = 0;
    for (std::size_t i = 0; i < h.size(); ++i) {
      const double truth = true_distance(s.points[i]);
      const bool is_marked = distance[i] < kRadius / 2;
      (is_marked ? marked : unmarked).add(h[i]);
      if (distance[i] == kRadius) far.add(h[i]);
      if (truth < kRadius / 2) error.add(distance[i] - truth);
      if (truth > 2 * kRadius) inner.add(h[i]);
      if (truth > kRadius) num_far += 1, wrongly_marked += is_marked;
      if (truth < kRadius / 4) num_at_rim += 1, missed += !is_marked;
    }
    EXPECT_NEAR(inner.value(), 1, 0.05);  // points at random: less even than any scanner's
    EXPECT_LT(marked.value(), 0.8 * inner.value());
    EXPECT_NEAR(unmarked.value(), inner.value(), 0.03);
    EXPECT_NEAR(far.value(), inner.value(), 0.02);
    EXPECT_LT(std::abs(error.value()), 0.5 * kSpacing);
    EXPECT_LT(wrongly_marked / num_far, 0.005);
    EXPECT_LT(missed / num_at_rim, 0.03);
    EXPECT_EQ(static_cast<double>(c.report.num_at_rims), marked.count);
  }
}

TEST(Rims, MayBeLeftOut) {
  const shapes::Sample s = cap(0.1);
  const Curvature marked = measured(s, kSpacing, kRadius),
                  without = measured(s, kSpacing, kRadius, RimTreatment::kExclude);
  const auto& distance = marked.scalars.find("rim_distance")->values;
  EXPECT_EQ(without.scalars.find("rim_distance")->values, distance);
  for (const char* name : {"mean_curvature", "k1", "k2", "max_abs_curvature", "crease"}) {
    const auto &kept = marked.scalars.find(name)->values, &left = without.scalars.find(name)->values;
    for (std::size_t i = 0; i < distance.size(); ++i) {
      ASSERT_FALSE(std::isnan(kept[i]));
      if (distance[i] < kRadius / 2)
        ASSERT_TRUE(std::isnan(left[i])) << name;
      else
        ASSERT_EQ(left[i], kept[i]) << name;
    }
  }
}

// A sharp edge is no rim.
TEST(Rims, AreNotFoundOnClosedShapes) {
  for (const shapes::Sample& s :
       {shapes::sphere(1, kSpacing), shapes::torus(1, 0.4, kSpacing), shapes::box({1, 0.8, 0.6}, kSpacing)}) {
    const Curvature c = measured(s, kSpacing, kRadius);
    EXPECT_LT(static_cast<double>(c.report.num_at_rims), 0.002 * static_cast<double>(s.points.size()));
  }
}

}  // namespace
}  // namespace meshmser
