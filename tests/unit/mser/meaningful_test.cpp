#include "stages/mser/meaningful.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

#include "stages/mser/level_lines.hpp"
#include "stages/mser/segment.hpp"
#include "stages/tree/component_tree.hpp"
#include "stages/tree/levels.hpp"
#include "tests/support/oracle.hpp"
#include "tests/unit/mser/hand_made_tree.hpp"
#include "tests/unit/mser/height_field.hpp"

namespace meshmser {
namespace {

using ::testing::ElementsAre;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

LevelSetTrees upper_tree_of(const HeightField& field, std::vector<double> values, double step, int num_levels) {
  LevelSetTrees trees;
  trees.values = std::move(values);
  std::vector<double> levels = {-kInfinity};
  for (int k = 0; k < num_levels; ++k) levels.push_back((k - num_levels / 2 + 0.5) * step);
  const auto of_vertex = levels_of_vertices(trees.values, levels, 1);
  ComponentTree tree =
      build_component_tree(field.twins, field.areas, levels_of_triangles(field.triangles, of_vertex, {}),
                           static_cast<std::int32_t>(levels.size()));
  tree.levels = levels;
  trees.trees.push_back(std::move(tree));
  return trees;
}

bool holds(const ComponentTree& tree, std::int32_t outer, std::int32_t inner) {
  while (inner >= 0 && inner != outer) inner = tree.parent_of_node[static_cast<std::size_t>(inner)];
  return inner == outer;
}

// From the sets of triangles alone: the loops between a node's triangles and others, the flattest triangle beyond each,
// the share of all lines as steep, and of each chain without branches the node of fewest false alarms.
TEST(Meaningful, AgreesWithTheDefinition) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> noise(0, 1);
    const HeightField field = make_height_field(14, 11, [&](double x, double) { return x / 3; });
    const auto values = field.values([&](const Eigen::Vector3d& p) {
      return 3 * std::sin(p.x() / 2) * std::cos(p.y() / 3) + noise(random) * (seed % 3);
    });
    const LevelSetTrees trees = upper_tree_of(field, values, 0.5, 16);
    const ComponentTree& tree = trees.trees[0];
    const auto num_nodes = static_cast<std::int32_t>(tree.num_nodes());

    const std::size_t num_triangles = field.triangles.size();
    std::vector<double> gradients;
    for (const auto& corners : field.triangles) {
      // The plane is z = x / 3: S as a function of x and y, then along the slope.
      const auto p = [&](std::size_t k) { return field.positions[static_cast<std::size_t>(corners[k])]; };
      const auto s = [&](std::size_t k) { return values[static_cast<std::size_t>(corners[k])]; };
      Eigen::Matrix2d steps;
      steps << (p(1) - p(0)).head<2>().transpose(), (p(2) - p(0)).head<2>().transpose();
      const Eigen::Vector2d slope = steps.inverse() * Eigen::Vector2d(s(1) - s(0), s(2) - s(0));
      gradients.push_back(std::hypot(slope.x() / std::sqrt(1 + 1.0 / 9), slope.y()));
    }
    const std::vector<double> computed = triangle_gradients(field.view(), values);
    for (std::size_t t = 0; t < num_triangles; ++t) EXPECT_NEAR(computed[t], gradients[t], 1e-12);
    gradients = computed;

    oracle::Surface surface;
    surface.num_levels = static_cast<int>(tree.levels.size());
    for (std::size_t t = 0; t < num_triangles; ++t) {
      const auto& c = field.triangles[t];
      surface.corners.push_back({c[0], c[1], c[2]});
      surface.cut_out.push_back(false);
      surface.level.push_back(tree.hi_of_node[static_cast<std::size_t>(tree.node_of_triangle[t])]);
      surface.area.push_back(1);
    }
    const auto at = [&](int triangle, int corner) {
      return field.positions[static_cast<std::size_t>(
          field.triangles[static_cast<std::size_t>(triangle)][static_cast<std::size_t>(corner % 3)])];
    };
    const double independent = 2.5;
    std::vector<LevelLine> expected_lines;
    std::vector<double> log_alarms(tree.num_nodes(), kInfinity);
    for (std::int32_t node = 0; node < num_nodes; ++node) {
      oracle::Triangles members;
      for (std::size_t t = 0; t < num_triangles; ++t)
        if (holds(tree, node, tree.node_of_triangle[t])) members.insert(static_cast<int>(t));
      for (const std::vector<int>& loop : oracle::border_loops(surface, members).loops) {
        LevelLine line{node, 0, kInfinity};
        for (const int h : loop)
          for (std::size_t u = 0; u < num_triangles; ++u) {
            if (members.count(static_cast<int>(u)) > 0) continue;
            const auto& from = field.triangles[static_cast<std::size_t>(h / 3)];
            const auto& beyond = field.triangles[u];
            const std::int32_t a = from[static_cast<std::size_t>(h % 3)],
                               b = from[static_cast<std::size_t>((h + 1) % 3)];
            if (std::count(beyond.begin(), beyond.end(), a) == 0 || std::count(beyond.begin(), beyond.end(), b) == 0)
              continue;
            line.length += (at(h / 3, h % 3) - at(h / 3, h % 3 + 1)).norm();
            line.least_gradient = std::min(line.least_gradient, gradients[u]);
          }
        expected_lines.push_back(line);
      }
    }
    for (const LevelLine& line : expected_lines) {
      double steep = 0, all = 0;
      for (std::size_t t = 0; t < num_triangles; ++t) {
        all += field.areas[t] * gradients[t];
        if (gradients[t] >= line.least_gradient) steep += field.areas[t] * gradients[t];
      }
      double& of_node = log_alarms[static_cast<std::size_t>(line.node)];
      of_node =
          std::min(of_node, std::log10(expected_lines.size()) + line.length / independent * std::log10(steep / all));
    }
    const std::vector<LevelLine> lines = level_lines(field.view(), tree, gradients);
    ASSERT_EQ(lines.size(), expected_lines.size());
    std::vector<double> total(tree.num_nodes(), 0);
    for (std::size_t l = 0; l < lines.size(); ++l) {
      EXPECT_EQ(lines[l].node, expected_lines[l].node);
      EXPECT_NEAR(lines[l].length, expected_lines[l].length, 1e-9);
      EXPECT_EQ(lines[l].least_gradient, expected_lines[l].least_gradient);
      total[static_cast<std::size_t>(lines[l].node)] += lines[l].length;
    }
    EXPECT_THAT(level_line_lengths(field.view(), tree), testing::Pointwise(testing::DoubleNear(1e-9), total));
    const GradientShare share(gradients, field.areas);
    const std::vector<double> logs =
        log_false_alarms(tree.num_nodes(), lines, share, {independent, static_cast<std::int64_t>(lines.size())});
    for (std::size_t n = 0; n < logs.size(); ++n)
      if (std::isinf(log_alarms[n])) {
        EXPECT_EQ(logs[n], kInfinity);
      } else {
        EXPECT_NEAR(logs[n], log_alarms[n], 1e-9);
      }

    for (const double log_most : {-3.0, 0.0, 2.0}) {
      std::vector<std::int32_t> expected;
      for (std::int32_t a = 0; a < num_nodes; ++a) {
        const auto i = static_cast<std::size_t>(a);
        if (tree.parent_of_node[i] < 0 || logs[i] > log_most) continue;
        bool best = true;
        for (std::int32_t b = 0; b < num_nodes; ++b) {
          const std::int32_t outer = std::max(a, b), inner = std::min(a, b);
          const auto j = static_cast<std::size_t>(b);
          if (a == b || tree.parent_of_node[j] < 0 || !holds(tree, outer, inner)) continue;
          bool chain = true;
          for (std::int32_t n = inner; n != outer; n = tree.parent_of_node[static_cast<std::size_t>(n)])
            chain = chain && std::count(tree.parent_of_node.begin(), tree.parent_of_node.end(),
                                        tree.parent_of_node[static_cast<std::size_t>(n)]) == 1;
          if (chain && (logs[j] < logs[i] || (logs[j] == logs[i] && b > a))) best = false;
        }
        if (best) expected.push_back(a);
      }
      EXPECT_EQ(select_meaningful(tree, logs, log_most), expected) << log_most;
    }
  }
}

TEST(SelectMeaningful, TakesTheBestOfEachSectionAndTellsWhy) {
  // 0 - 1 - 2 is a chain below the root 5; 3 - 4 another.
  const ComponentTree tree = make_tree({{1, 5, 1}, {2, 4, 1}, {5, 3, 1}, {4, 5, 1}, {5, 4, 1}, {-1, 1, 1}}, 5);
  const std::vector<double> logs = {-4, -9, -9, 1, 3, kInfinity};
  NodeFates fates(6);
  EXPECT_THAT(select_meaningful(tree, logs, 0, {}, &fates), ElementsAre(2));
  EXPECT_EQ(fates[0], (NodeFate{NodeFate::Kind::kLessMeaningful, -1, 2}));
  EXPECT_EQ(fates[1], (NodeFate{NodeFate::Kind::kLessMeaningful, -1, 2}));
  EXPECT_EQ(fates[2].kind, NodeFate::Kind::kRegion);
  EXPECT_EQ(fates[3].kind, NodeFate::Kind::kFalseAlarm);
  EXPECT_EQ(fates[5].kind, NodeFate::Kind::kRoot);
  EXPECT_THAT(select_meaningful(tree, logs, 1), ElementsAre(2, 3));
}

TEST(SelectMeaningful, ASectionOfShapesEndsWhereBrightTurnsIntoDark) {
  // A chain of only children: two lines into a bump, which stands in a pit of two lines.
  ComponentTree tree = make_tree({{1, 5, 1}, {2, 4, 1}, {3, 3, 1}, {4, 2, 1}, {-1, 1, 1}}, 5);
  const std::vector<double> logs = {-2, -1, -3, -4, std::numeric_limits<double>::infinity()};
  EXPECT_THAT(select_meaningful(tree, logs, 0), ElementsAre(3));
  tree.polarity = Polarity::kShapes;
  tree.side_of_node = {Polarity::kUpper, Polarity::kUpper, Polarity::kLower, Polarity::kLower, Polarity::kUpper};
  tree.own_level_of_node = {3, 2, 1, 2, 3};
  EXPECT_THAT(select_meaningful(tree, logs, 0), ElementsAre(0, 3));
}

/// White noise of deviation 1, averaged over neighbours so many times.
std::vector<double> noise_on(std::int32_t size, unsigned seed, int rounds) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, 1);
  std::vector<double> values(static_cast<std::size_t>((size + 1) * (size + 1)));
  for (double& value : values) value = noise(random);
  for (int round = 0; round < rounds; ++round) {
    const std::vector<double> before = values;
    for (std::int32_t j = 0; j <= size; ++j)
      for (std::int32_t i = 0; i <= size; ++i) {
        double sum = 0;
        int count = 0;
        for (std::int32_t y = std::max(0, j - 1); y <= std::min(size, j + 1); ++y)
          for (std::int32_t x = std::max(0, i - 1); x <= std::min(size, i + 1); ++x, ++count)
            sum += before[static_cast<std::size_t>(y * (size + 1) + x)];
        values[static_cast<std::size_t>(j * (size + 1) + i)] = sum / count;
      }
  }
  return values;
}

/// Levels over the range of the values, as the tree stage lays them.
LevelSetTrees both_trees_of(const HeightField& field, std::vector<double> values) {
  LevelSetTrees trees;
  trees.values = std::move(values);
  for (const Polarity polarity : {Polarity::kUpper, Polarity::kLower}) {
    const bool lower = polarity == Polarity::kLower;
    const std::vector<double> levels = make_levels(trees.values, {}, {}, lower);
    const auto of_vertex = levels_of_vertices(trees.values, levels, lower ? -1 : 1);
    trees.trees.push_back(build_component_tree(field.twins, field.areas,
                                               levels_of_triangles(field.triangles, of_vertex, {}),
                                               static_cast<std::int32_t>(levels.size())));
    trees.trees.back().polarity = polarity;
    trees.trees.back().levels = levels;
  }
  return trees;
}

// What the number of false alarms promises, of noise as it comes and of smooth noise: fewer lines than that on average.
TEST(Segment, NoiseHasFewerMeaningfulLinesThanFalseAlarms) {
  const HeightField field = make_height_field(80, 80);
  for (const int rounds : {0, 1, 2, 4})
    for (const double false_alarms : {1.0, 10.0}) {
      SegmentParameters parameters;
      parameters.select = Select::kMeaningful;
      parameters.max_false_alarms = false_alarms;
      parameters.independent = 2.0 * std::max(2, rounds + 1);
      parameters.band = 1;
      constexpr unsigned kSeeds = 10;
      std::size_t lines = 0;
      for (unsigned seed = 1; seed <= kSeeds; ++seed)
        lines += segment({field.view(), both_trees_of(field, noise_on(80, seed, rounds)), {}, {}, {}}, parameters)
                     .regions.size();
      EXPECT_LT(static_cast<double>(lines) / kSeeds, false_alarms) << rounds << " rounds";
    }
}

// What the number of false alarms promises: noise gives hardly a line, a step in the same noise gives its outline.
TEST(Segment, MeaningfulLinesAreNotNoise) {
  const HeightField field = make_height_field(80, 80);
  SegmentParameters parameters;
  parameters.select = Select::kMeaningful;
  parameters.independent = 10;
  std::size_t by_chance = 0;
  std::ptrdiff_t others = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    std::vector<double> values = noise_on(80, seed, 2);
    by_chance += segment({field.view(), upper_tree_of(field, values, 0.05, 60), {}, {}, {}}, parameters).regions.size();
    for (std::size_t v = 0; v < values.size(); ++v)
      if ((field.positions[v] - Eigen::Vector3d(40, 40, 0)).norm() < 20) values[v] += 2;
    const Segmentation step = segment({field.view(), upper_tree_of(field, values, 0.05, 100), {}, {}, {}}, parameters);
    const auto is_disc = [](const Region& region) { return std::abs(region.area - std::numbers::pi * 400) < 80; };
    EXPECT_TRUE(std::any_of(step.regions.begin(), step.regions.end(), is_disc))
        << seed << ": " << (step.regions.empty() ? 0 : step.regions[0].area);
    others += std::count_if(step.regions.begin(), step.regions.end(), std::not_fn(is_disc));
  }
  EXPECT_LE(by_chance, 10U) << "one a surface is expected at most";
  EXPECT_LE(others, 10);
  parameters.independent = 0;
  const LevelSetTrees flat = upper_tree_of(field, std::vector<double>(field.positions.size(), 0), 1, 4);
  EXPECT_THROW(segment({field.view(), flat, {}, {}, {}}, parameters), StageError);
  parameters.independent = 1;
  EXPECT_TRUE(segment({field.view(), flat, {}, {}, {}}, parameters).regions.empty());
}

}  // namespace
}  // namespace meshmser
