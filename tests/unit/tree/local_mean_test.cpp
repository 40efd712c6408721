#include "stages/tree/local_mean.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace meshmser {
namespace {

struct Cloud {
  std::vector<Eigen::Vector3d> positions;
  std::vector<double> values, weights;
};

/// A wavy sheet with random places and weights.
Cloud wavy_sheet(std::size_t n) {
  Cloud cloud;
  std::mt19937 random(11);
  std::uniform_real_distribution<double> place(0, 10), weight(0.5, 1.5);
  for (std::size_t i = 0; i < n; ++i) {
    const double x = place(random), y = place(random);
    cloud.positions.emplace_back(x, y, 0.3 * std::sin(x));
    cloud.values.push_back(std::sin(2 * x) + 0.2 * y);
    cloud.weights.push_back(weight(random) * 100 / static_cast<double>(n));
  }
  return cloud;
}

/// From the definition, ball by ball.
double exact_mean(const Cloud& cloud, std::size_t v, double radius) {
  double weight = 0, sum = 0;
  for (std::size_t i = 0; i < cloud.positions.size(); ++i)
    if ((cloud.positions[i] - cloud.positions[v]).norm() < radius) {
      weight += cloud.weights[i];
      sum += cloud.weights[i] * cloud.values[i];
    }
  return sum / weight;
}

TEST(LocalMeans, WithinOnePercentOfTheExactMean) {
  const Cloud cloud = wavy_sheet(20000);
  const double spread = 4;  // of the values, from least to greatest
  for (const double radius : {0.6, 1.5, 4.0}) {
    const std::vector<double> means = local_means(cloud.positions, cloud.values, cloud.weights, radius);
    double square = 0;
    for (std::size_t v = 0; v < cloud.positions.size(); v += 100)
      square += std::pow(means[v] - exact_mean(cloud, v, radius), 2);
    EXPECT_LT(std::sqrt(square / 200), 0.01 * spread) << "radius " << radius;
  }
}

TEST(LocalMeans, AConstantIsItsOwnMean) {
  Cloud cloud = wavy_sheet(2000);
  for (double& value : cloud.values) value = 7.25;
  for (const double mean : local_means(cloud.positions, cloud.values, cloud.weights, 0.5))
    EXPECT_NEAR(mean, 7.25, 1e-12);
}

TEST(LocalMeans, ValuesThatAreNotNumbersCountNothing) {
  Cloud cloud = wavy_sheet(2000);
  for (double& value : cloud.values) value = 1;
  for (std::size_t v = 0; v < cloud.values.size(); v += 3) cloud.values[v] = std::nan("");
  for (const double mean : local_means(cloud.positions, cloud.values, cloud.weights, 1)) EXPECT_NEAR(mean, 1, 1e-12);
}

TEST(LocalMeans, SameBytesOnAnyThreads) {
  const Cloud cloud = wavy_sheet(20000);
  Execution one, seven;
  one.threads = 1;
  seven.threads = 7;
  EXPECT_EQ(local_means(cloud.positions, cloud.values, cloud.weights, 1, one),
            local_means(cloud.positions, cloud.values, cloud.weights, 1, seven));
}

TEST(LocalMeans, NoneAndAPointAndFarApart) {
  EXPECT_TRUE(local_means({}, {}, {}, 1).empty());
  const Cloud far{{{0, 0, 0}, {1e9, 1e9, 1e9}}, {1, 2}, {1, 1}};
  EXPECT_EQ(local_means(far.positions, far.values, far.weights, 1e-3), (std::vector<double>{1, 2}));
}

TEST(VertexAreas, AThirdOfEachTriangle) {
  const std::vector<std::array<std::int32_t, 3>> triangles{{0, 1, 2}, {2, 1, 3}};
  const std::vector<double> areas{3, 6};
  EXPECT_EQ(vertex_areas(triangles, areas, {}, 4), (std::vector<double>{1, 3, 3, 2}));
  EXPECT_EQ(vertex_areas(triangles, areas, std::vector<std::uint8_t>{1, 0}, 4), (std::vector<double>{0, 2, 2, 2}));
}

}  // namespace
}  // namespace meshmser
