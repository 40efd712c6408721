/// Attributes of every node of trees on random small meshes, from the sets of triangles alone.

#include "stages/mser/node_attributes.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <vector>

#include "stages/borders/borders.hpp"
#include "stages/common/adjacency.hpp"
#include "stages/mser/segment.hpp"
#include "stages/tree/component_tree.hpp"
#include "stages/tree/levels.hpp"
#include "tests/support/node_sets.hpp"
#include "tests/support/random_mesh.hpp"

namespace meshmser {
namespace {

struct Scene {
  std::vector<Eigen::Vector3d> positions;
  std::vector<std::array<std::int32_t, 3>> triangles;
  std::vector<std::int32_t> twins;
  std::vector<double> areas;
  LevelSetTrees trees;  ///< upper, lower

  SurfaceView view() const { return {positions, triangles, twins}; }
};

Scene make_scene(std::uint32_t seed) {
  std::mt19937 random(seed);
  const testing::RandomMesh mesh = testing::random_mesh(seed);
  Scene scene;
  scene.positions = mesh.positions;
  scene.triangles = mesh.triangles;
  // Off the grid, now and then far from the origin.
  std::uniform_real_distribution<double> any(-0.2, 0.2);
  for (Eigen::Vector3d& p : scene.positions) {
    if (seed % 3 != 0) p += Eigen::Vector3d(any(random), any(random), any(random));
    if (seed % 5 == 0) p += Eigen::Vector3d(3e4, -2e4, 1e4);
  }
  scene.trees.values = mesh.values;
  scene.twins = twin_half_edges(scene.triangles, scene.positions.size());
  scene.areas = triangle_areas(scene.positions, scene.triangles);
  scene.trees.excluded_of_triangle.assign(scene.triangles.size(), 0);
  if (seed % 4 == 0)
    for (auto& flag : scene.trees.excluded_of_triangle) flag = random() % 10 == 0 ? 1 : 0;
  cut_out_triangles(scene.twins, scene.trees.excluded_of_triangle);
  for (const Polarity polarity : {Polarity::kUpper, Polarity::kLower}) {
    std::vector<double> levels;
    if (seed % 2 == 0) levels.push_back(-std::numeric_limits<double>::infinity());
    for (double level = -6; level <= 8; level += 1.5) levels.push_back(level);
    const bool lower = polarity == Polarity::kLower;
    ComponentTree tree = build_component_tree(
        scene.twins, scene.areas,
        levels_of_triangles(scene.triangles, levels_of_vertices(mesh.values, levels, lower ? -1 : 1),
                            scene.trees.excluded_of_triangle),
        static_cast<std::int32_t>(levels.size()));
    tree.polarity = polarity;
    tree.levels = levels;
    scene.trees.trees.push_back(std::move(tree));
  }
  return scene;
}

/// The integral over a triangle of a polynomial of degree 2: a third of the area times the sum at the edges' middles.
template <class Function>
auto integral(const Scene& scene, std::int32_t t, Function function) {
  const auto& c = scene.triangles[static_cast<std::size_t>(t)];
  const auto place = [&](int k) { return scene.positions[static_cast<std::size_t>(c[static_cast<std::size_t>(k)])]; };
  const auto value = [&](int k) {
    return scene.trees.values[static_cast<std::size_t>(c[static_cast<std::size_t>(k)])];
  };
  decltype(function(place(0), 0.0)) sum = function(0.5 * (place(0) + place(1)), 0.5 * (value(0) + value(1)));
  sum += function(0.5 * (place(1) + place(2)), 0.5 * (value(1) + value(2)));
  sum += function(0.5 * (place(2) + place(0)), 0.5 * (value(2) + value(0)));
  sum *= scene.areas[static_cast<std::size_t>(t)] / 3;
  return sum;
}

/// Vertices - edges + triangles, a vertex counted once for each of its fans: corners joined over inner edges.
std::int64_t euler_of(const Scene& scene, const std::set<std::int32_t>& members) {
  std::map<std::int32_t, std::int32_t> joined;  // corner 3 t + k to another of its fan
  const auto find = [&](std::int32_t corner) {
    while (joined.at(corner) != corner) corner = joined.at(corner);
    return corner;
  };
  std::int64_t inner = 0;
  for (const std::int32_t t : members)
    for (int k = 0; k < 3; ++k) joined[3 * t + k] = 3 * t + k;
  for (const std::int32_t t : members)
    for (int k = 0; k < 3; ++k) {
      const std::int32_t h = 3 * t + k, twin = scene.twins[static_cast<std::size_t>(h)];
      if (twin < 0 || members.count(twin / 3) == 0) continue;
      inner += h < twin;
      joined[find(h)] = find(next_half_edge(twin));
      joined[find(next_half_edge(h))] = find(twin);
    }
  std::int64_t vertices = 0;
  for (const auto& entry : joined) vertices += entry.first == entry.second;
  const auto faces = static_cast<std::int64_t>(members.size());
  return vertices - (3 * faces - inner) + faces;
}

void check_node(const Scene& scene, const std::set<std::int32_t>& members, const NodeAttributes& got) {
  ASSERT_EQ(got.num_triangles, static_cast<std::int64_t>(members.size()));
  double area = 0, level = 0, hole = 0, least = 1e300, greatest = -1e300;
  Eigen::AlignedBox3d box;
  Eigen::Vector3d vector_area = Eigen::Vector3d::Zero();
  for (const std::int32_t t : members) {
    area += scene.areas[static_cast<std::size_t>(t)];
    const auto& c = scene.triangles[static_cast<std::size_t>(t)];
    const auto place = [&](std::size_t k) { return scene.positions[static_cast<std::size_t>(c[k % 3])]; };
    vector_area += (place(1) - place(0)).cross(place(2) - place(0)) / 2;
    for (std::size_t k = 0; k < 3; ++k) {
      least = std::min(least, scene.trees.values[static_cast<std::size_t>(c[k])]);
      greatest = std::max(greatest, scene.trees.values[static_cast<std::size_t>(c[k])]);
      box.extend(place(k));
      const std::int32_t twin = scene.twins[3 * static_cast<std::size_t>(t) + k];
      if (twin < 0)
        hole += (place(k) - place(k + 1)).norm();
      else if (members.count(twin / 3) == 0)
        level += (place(k) - place(k + 1)).norm();
    }
  }
  EXPECT_NEAR(got.area, area, 1e-12 * area);
  EXPECT_NEAR(got.level_length, level, 1e-12 * level) << "0 must be 0";
  EXPECT_NEAR(got.hole_length, hole, 1e-12 * hole);
  EXPECT_EQ(got.scalar_min, least);
  EXPECT_EQ(got.scalar_max, greatest);
  EXPECT_EQ(got.box_min, box.min());
  EXPECT_EQ(got.box_max, box.max());
  EXPECT_NEAR((got.vector_area - vector_area).norm(), 0, 1e-9);
  if (area > 0) {
    EXPECT_NEAR(got.flatness(), vector_area.norm() / area, 1e-9);
  }
  EXPECT_EQ(got.euler, euler_of(scene, members));
  if (!(area > 0)) {
    EXPECT_TRUE(box.contains(got.centroid));
    return;
  }
  const Eigen::Vector3d about = box.center();
  double mean = 0;
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
  for (const std::int32_t t : members) {
    mean += integral(scene, t, [](const Eigen::Vector3d&, double s) { return s; });
    centroid += integral(scene, t, [&](const Eigen::Vector3d& p, double) { return Eigen::Vector3d(p - about); });
  }
  mean /= area;
  centroid = about + centroid / area;
  double variance = 0;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const std::int32_t t : members) {
    variance += integral(scene, t, [&](const Eigen::Vector3d&, double s) { return (s - mean) * (s - mean); });
    covariance += integral(scene, t, [&](const Eigen::Vector3d& p, double) {
      return Eigen::Matrix3d((p - centroid) * (p - centroid).transpose());
    });
  }
  covariance /= area;
  EXPECT_NEAR(got.scalar_mean, mean, 1e-12 * (1 + std::abs(mean)));
  EXPECT_NEAR(got.scalar_deviation, std::sqrt(variance / area), 1e-6);
  EXPECT_NEAR((got.centroid - centroid).norm(), 0, 1e-9);
  EXPECT_NEAR((got.covariance - covariance).norm(), 0, 1e-9 * covariance.norm());
  const PrincipalAxes axes = principal_axes(got.covariance);
  const Eigen::Vector3d roots = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvalues();
  for (int i = 0; i < 3; ++i)
    EXPECT_NEAR(axes.deviations[i] * axes.deviations[i], std::max(0.0, roots[2 - i]), 1e-9 * roots[2]);
  EXPECT_NEAR((axes.axes.transpose() * axes.axes - Eigen::Matrix3d::Identity()).norm(), 0, 1e-12);
  EXPECT_GT(axes.axes.determinant(), 0);
  for (int i = 0; i < 3; ++i)
    EXPECT_NEAR((covariance * axes.axes.col(i) - roots[2 - i] * axes.axes.col(i)).norm(), 0, 1e-8 * roots[2]);
}

class NodeAttributesOfRandomMeshes : public ::testing::TestWithParam<int> {};

TEST_P(NodeAttributesOfRandomMeshes, AreThoseOfTheirTriangles) {
  constexpr std::uint32_t kMeshes = 500;
  std::uint32_t with_handles = 0;
  for (std::uint32_t i = 0; i < kMeshes; ++i) {
    const std::uint32_t seed = static_cast<std::uint32_t>(GetParam()) * kMeshes + i;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    const Scene scene = make_scene(seed);
    for (const ComponentTree& tree : scene.trees.trees) {
      const std::vector<std::set<std::int32_t>> sets = testing::sets_of(tree);
      const std::vector<NodeAttributes> all = attributes_of_nodes(scene.view(), tree, scene.trees.values, scene.areas);
      ASSERT_EQ(all.size(), tree.num_nodes());
      std::vector<std::int32_t> numbers(tree.num_nodes());
      std::iota(numbers.begin(), numbers.end(), 1);
      const BorderLoops loops =
          extract_borders(scene.view(), tree, numbers, std::vector<std::int32_t>(scene.triangles.size(), 0));
      std::int64_t expected_loops = 0;
      for (std::size_t n = 0; n < all.size(); ++n) {
        SCOPED_TRACE(::testing::Message() << "node " << n);
        check_node(scene, sets[n], all[n]);
        std::int32_t depth = 0;
        for (std::int32_t up = tree.parent_of_node[n]; up >= 0; up = tree.parent_of_node[static_cast<std::size_t>(up)])
          ++depth;
        EXPECT_EQ(all[n].depth, depth);
        expected_loops += 2 - all[n].euler;
      }
      // Two less for each handle, which glued vertices make now and then.
      const std::int64_t handles =
          expected_loops - static_cast<std::int64_t>(loops.num_loops()) - loops.num_hole_loops_dropped;
      EXPECT_GE(handles, 0);
      EXPECT_EQ(handles % 2, 0);
      with_handles += handles > 0;
      // Some of the nodes alone.
      std::vector<std::int32_t> some;
      for (std::size_t n = 0; n < all.size(); ++n)
        if ((n + seed) % 3 == 0) some.push_back(static_cast<std::int32_t>(n));
      const std::vector<NodeAttributes> of_some =
          attributes_of_nodes(scene.view(), tree, some, scene.trees.values, scene.areas);
      for (std::size_t k = 0; k < some.size(); ++k) {
        SCOPED_TRACE(::testing::Message() << "node " << some[k] << " of some");
        const auto n = static_cast<std::size_t>(some[k]);
        check_node(scene, sets[n], of_some[k]);
        EXPECT_EQ(of_some[k].level_length, all[n].level_length) << "lengths are exact sums";
        EXPECT_EQ(of_some[k].depth, std::count_if(some.begin(), some.end(), [&](std::int32_t other) {
                    return other > some[k] && tree.first_node_of_subtree[static_cast<std::size_t>(other)] <= some[k];
                  }));
      }
    }
    if (HasFailure()) return;
  }
  EXPECT_LT(with_handles, kMeshes / 20);
}

INSTANTIATE_TEST_SUITE_P(Seeds, NodeAttributesOfRandomMeshes, ::testing::Range(0, 8));

// Both polarities: one table by decreasing area, each row what its own set of triangles says, each triangle the
// smallest row that holds it.
TEST(Segment, BothPolaritiesMakeOneTableAndOneLabelling) {
  for (std::uint32_t seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    const Scene scene = make_scene(seed);
    SegmentParameters parameters;
    parameters.delta = 1 + static_cast<std::int32_t>(seed % 3);
    parameters.band = 1;
    const Segmentation result = segment({scene.view(), scene.trees, {}, {}, {}}, parameters);
    std::vector<std::set<std::int32_t>> members;
    std::size_t selected = 0;
    for (const ComponentTree& tree : scene.trees.trees)
      selected += select_mser(tree, {parameters.delta, parameters.against},
                              open_roots(tree, scene.twins, scene.trees.excluded_of_triangle))
                      .size();
    ASSERT_EQ(result.regions.size(), selected);
    std::vector<std::vector<std::set<std::int32_t>>> sets;
    for (const ComponentTree& tree : scene.trees.trees) sets.push_back(testing::sets_of(tree));
    for (const Region& region : result.regions) {
      const std::size_t side = region.polarity == Polarity::kUpper ? 0 : 1;
      members.push_back(sets[side][static_cast<std::size_t>(region.node)]);
      EXPECT_EQ(region.num_triangles, static_cast<std::int64_t>(members.back().size()));
      EXPECT_EQ(region.euler, euler_of(scene, members.back()));
      // Above or below its level, as its polarity says.
      const ComponentTree& tree = scene.trees.trees[side];
      if (std::isfinite(tree.levels[static_cast<std::size_t>(region.low_level) - 1])) {
        if (side == 0) {
          EXPECT_GE(region.scalar_min, region.value);
        } else {
          EXPECT_LE(region.scalar_max, region.value);
        }
      }
      if (members.size() > 1) {
        const Region& before = result.regions[members.size() - 2];
        EXPECT_GE(before.area, region.area * (1 - 1e-12));
      }
    }
    for (std::size_t t = 0; t < scene.triangles.size(); ++t) {
      std::size_t smallest = members.size();
      for (std::size_t r = 0; r < members.size(); ++r)
        if (members[r].count(static_cast<std::int32_t>(t)) > 0 &&
            (smallest == members.size() || result.regions[r].area < result.regions[smallest].area ||
             members[r].size() < members[smallest].size()))
          smallest = r;
      const std::int32_t got = result.region_of_triangle[t];
      ASSERT_EQ(got == 0, smallest == members.size());
      if (got == 0) continue;
      const auto r = static_cast<std::size_t>(got) - 1;
      EXPECT_EQ(members[r].count(static_cast<std::int32_t>(t)), 1U);
      EXPECT_NEAR(result.regions[r].area, result.regions[smallest].area, 1e-12 * result.regions[r].area);
    }
    for (std::size_t r = 0; r < members.size(); ++r) {
      // The smallest of the same polarity that properly contains it.
      std::size_t parent = members.size();
      std::int32_t depth = 0;
      for (std::size_t o = 0; o < members.size(); ++o)
        if (o != r && result.regions[o].polarity == result.regions[r].polarity &&
            members[o].size() > members[r].size() &&
            std::includes(members[o].begin(), members[o].end(), members[r].begin(), members[r].end())) {
          ++depth;
          if (parent == members.size() || members[o].size() < members[parent].size()) parent = o;
        }
      EXPECT_EQ(result.regions[r].parent, parent == members.size() ? -1 : static_cast<std::int32_t>(parent) + 1);
      EXPECT_EQ(result.regions[r].depth, depth);
    }
    if (HasFailure()) return;
  }
}

}  // namespace
}  // namespace meshmser
