/// Trees, selections, labels and borders against the definitions, on random small meshes.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>
#include <string>

#include "stages/borders/borders.hpp"
#include "stages/common/adjacency.hpp"
#include "stages/common/exact_area.hpp"
#include "stages/mser/filters.hpp"
#include "stages/mser/label_triangles.hpp"
#include "stages/mser/patches.hpp"
#include "stages/mser/persistence.hpp"
#include "stages/mser/select_mser.hpp"
#include "stages/mser/stability.hpp"
#include "stages/tree/component_tree.hpp"
#include "stages/tree/levels.hpp"
#include "tests/support/node_sets.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/random_mesh.hpp"

namespace meshmser {
namespace {

using oracle::Triangles;

std::uint64_t first_seed() {
  const char* given = std::getenv("MESHMSER_TEST_SEED");
  return given == nullptr ? 1 : std::strtoull(given, nullptr, 10);
}

/// One random mesh with its levels, seen both ways.
struct Scene {
  testing::RandomMesh mesh;
  std::vector<std::uint8_t> excluded;
  std::vector<double> levels[2];  // upper, lower
  std::vector<std::int32_t> twins;
  std::vector<double> areas;
  std::vector<ComponentTree> trees;
  std::vector<oracle::Surface> surfaces;
  int delta = 1;
};

Scene make_scene(std::uint32_t seed, std::mt19937_64& random) {
  const auto uniform = [&](int least, int most) {
    return least + static_cast<int>(random() % static_cast<std::uint64_t>(most - least + 1));
  };
  Scene scene;
  scene.mesh = testing::random_mesh(seed);
  const std::size_t num_triangles = scene.mesh.triangles.size();
  scene.delta = uniform(1, 3);
  scene.excluded.assign(num_triangles, 0);
  if (uniform(0, 3) == 0)
    for (auto& flag : scene.excluded) flag = uniform(0, 9) == 0 ? 1 : 0;
  // Levels below, among and above the values; now and then none for the lowest, so that triangles are in no node.
  const bool explicit_levels = uniform(0, 3) == 0;
  for (int i = uniform(1, 12); i > 0; --i) scene.levels[0].push_back(0.5 * uniform(-20, 20));
  std::sort(scene.levels[0].begin(), scene.levels[0].end());
  scene.levels[0].erase(std::unique(scene.levels[0].begin(), scene.levels[0].end()), scene.levels[0].end());
  for (const double level : scene.levels[0]) scene.levels[1].insert(scene.levels[1].begin(), -level);
  if (!explicit_levels)
    for (auto& levels : scene.levels) levels.insert(levels.begin(), -std::numeric_limits<double>::infinity());

  scene.twins = twin_half_edges(scene.mesh.triangles, scene.mesh.positions.size());
  cut_out_triangles(scene.twins, scene.excluded);
  // Multiples of 1/2, so that the definitions' sums are exact and ties are common.
  scene.areas = triangle_areas(scene.mesh.positions, scene.mesh.triangles);
  for (double& area : scene.areas) area = 0.5 * std::round(2 * area);
  for (const Polarity polarity : {Polarity::kUpper, Polarity::kLower}) {
    const bool lower = polarity == Polarity::kLower;
    const std::vector<double>& levels = scene.levels[lower ? 1 : 0];
    const std::vector<std::int32_t> of_vertex = levels_of_vertices(scene.mesh.values, levels, lower ? -1 : 1);
    ComponentTree tree = build_component_tree(scene.twins, scene.areas,
                                              levels_of_triangles(scene.mesh.triangles, of_vertex, scene.excluded),
                                              static_cast<std::int32_t>(levels.size()));
    tree.polarity = polarity;
    tree.levels = levels;
    scene.trees.push_back(std::move(tree));

    oracle::Surface surface;
    surface.num_levels = static_cast<int>(levels.size());
    std::vector<double> signed_values = scene.mesh.values;
    if (lower)
      for (double& value : signed_values) value = -value;
    for (std::size_t t = 0; t < num_triangles; ++t) {
      const auto& triangle = scene.mesh.triangles[t];
      const bool cut_out = scene.excluded[t] != 0;
      surface.corners.push_back({triangle[0], triangle[1], triangle[2]});
      surface.cut_out.push_back(cut_out);
      surface.level.push_back(cut_out ? 0 : oracle::level_of(surface.corners.back(), signed_values, levels));
      surface.area.push_back(static_cast<std::int64_t>(2 * scene.areas[t]));
    }
    scene.surfaces.push_back(surface);
  }
  return scene;
}

/// For each node of the tree its index among the oracle's nodes.
std::vector<std::size_t> match_nodes(const std::vector<Triangles>& sets, const std::vector<oracle::Node>& nodes) {
  std::vector<std::size_t> match;
  for (const Triangles& set : sets)
    match.push_back(static_cast<std::size_t>(
        std::find_if(nodes.begin(), nodes.end(), [&](const oracle::Node& node) { return node.triangles == set; }) -
        nodes.begin()));
  return match;
}

std::set<Triangles> chosen_sets(const std::vector<Triangles>& sets, const std::vector<std::int32_t>& selected) {
  std::set<Triangles> chosen;
  for (const std::int32_t node : selected) chosen.insert(sets[static_cast<std::size_t>(node)]);
  return chosen;
}

std::vector<std::vector<int>> loops_of(const BorderLoops& borders, std::int32_t owner) {
  std::vector<std::vector<int>> loops;
  for (std::size_t l = 0; l < borders.num_loops(); ++l)
    if (borders.owner_of_loop[l] == owner)
      loops.emplace_back(borders.half_edges.begin() + borders.first_edge_of_loop[l],
                         borders.half_edges.begin() + borders.first_edge_of_loop[l + 1]);
  std::sort(loops.begin(), loops.end());
  return loops;
}

void check_tree(const Scene& scene, std::size_t side, const std::vector<oracle::Node>& nodes,
                const std::vector<std::size_t>& match) {
  const ComponentTree& tree = scene.trees[side];
  const oracle::Surface& surface = scene.surfaces[side];
  ASSERT_EQ(tree.num_nodes(), nodes.size());
  for (std::size_t n = 0; n < tree.num_nodes(); ++n) {
    ASSERT_LT(match[n], nodes.size()) << "a node that is no component";
    const oracle::Node& node = nodes[match[n]];
    const std::int32_t parent = tree.parent_of_node[n];
    EXPECT_EQ(tree.hi_of_node[n], node.hi);
    EXPECT_EQ(tree.lo(static_cast<std::int32_t>(n)), node.lo);
    ASSERT_EQ(parent < 0, node.parent < 0);
    if (parent >= 0) {
      EXPECT_EQ(match[static_cast<std::size_t>(parent)], static_cast<std::size_t>(node.parent));
    }
    std::int64_t area = 0;
    for (const int t : node.triangles)
      area += area_in_units(scene.areas[static_cast<std::size_t>(t)], tree.area_exponent_of_node[n]);
    EXPECT_EQ(tree.area_of_node[n], area);
  }
  const std::vector<std::int32_t> rebuilt = rebuild_levels(tree);
  EXPECT_EQ(rebuilt, std::vector<std::int32_t>(surface.level.begin(), surface.level.end()));
}

class AgainstOracle : public ::testing::TestWithParam<int> {};

TEST_P(AgainstOracle, EverythingIsEqual) {
  constexpr int kMeshes = 400;
  const std::uint64_t seed = first_seed() + static_cast<std::uint64_t>(GetParam()) * kMeshes;
  for (int i = 0; i < kMeshes; ++i) {
    SCOPED_TRACE("MESHMSER_TEST_SEED " + std::to_string(seed + static_cast<std::uint64_t>(i)));
    std::mt19937_64 random(seed + static_cast<std::uint64_t>(i));
    const Scene scene = make_scene(static_cast<std::uint32_t>(seed) + static_cast<std::uint32_t>(i), random);
    const Against against = random() % 2 == 0 ? Against::kChildren : Against::kMainChild;
    std::vector<std::vector<std::int32_t>> selected(2);
    std::vector<Triangles> regions[2];
    std::vector<std::vector<Triangles>> sets(2);
    for (std::size_t side = 0; side < 2; ++side) {
      SCOPED_TRACE(side == 0 ? "upper" : "lower");
      const ComponentTree& tree = scene.trees[side];
      const oracle::Surface& surface = scene.surfaces[side];
      sets[side] = testing::sets_of(tree);
      const std::vector<oracle::Node> nodes = oracle::all_nodes(surface);
      const std::vector<std::size_t> match = match_nodes(sets[side], nodes);
      check_tree(scene, side, nodes, match);
      if (HasFatalFailure()) return;

      const std::vector<std::int64_t> changes = change_of_nodes(tree, scene.delta);
      const std::vector<oracle::Ratio> q = oracle::stability(surface, nodes, scene.delta);
      for (std::size_t n = 0; n < tree.num_nodes(); ++n)
        EXPECT_TRUE(compare_stability(changes[n], tree.area_of_node[n], q[match[n]].first, q[match[n]].second) == 0);

      selected[side] =
          select_mser(tree, changes, {scene.delta, against}, open_roots(tree, scene.twins, scene.excluded));
      const std::set<Triangles> expected = oracle::selection(surface, nodes, q, against == Against::kMainChild);
      ASSERT_EQ(chosen_sets(sets[side], selected[side]), expected);
      regions[side].assign(expected.begin(), expected.end());

      std::map<Triangles, oracle::Ratio> q_of_selected;
      for (const std::int32_t node : selected[side]) {
        const auto n = static_cast<std::size_t>(node);
        q_of_selected[sets[side][n]] = q[match[n]];
      }
      for (const double share : {0.1, 0.4, 0.9}) {
        EXPECT_EQ(chosen_sets(sets[side], filter_diversity(tree, changes, selected[side], share)),
                  oracle::diverse(surface, q_of_selected, share))
            << share;
      }
      EXPECT_EQ(chosen_sets(sets[side], filter_nested(tree, changes, selected[side], Nested::kMostStable)),
                oracle::most_stable(surface, q_of_selected));

      const std::vector<double> heights = finite_levels(tree.levels);
      const Maxima maxima = find_maxima(tree);
      for (const auto& [leaf, life] : oracle::lifetimes(nodes, heights)) {
        const auto n =
            static_cast<std::size_t>(std::find(sets[side].begin(), sets[side].end(), leaf) - sets[side].begin());
        EXPECT_EQ(maxima.persistence_of_leaf[n], life.persistence);
        EXPECT_EQ(sets[side][static_cast<std::size_t>(maxima.top_of_leaf[n])], life.top);
      }
      const double min_persistence = static_cast<double>(random() % 4);
      const auto min_area = static_cast<std::int64_t>(random() % 6);
      const Significance significance{min_persistence, 0.5 * static_cast<double>(min_area)};
      EXPECT_EQ(chosen_sets(sets[side], select_persistence(tree, maxima, significance)),
                oracle::persistent(surface, nodes, heights, min_persistence, min_area, nullptr));
      EXPECT_EQ(chosen_sets(sets[side], select_stable_branch(tree, maxima, changes, significance)),
                oracle::persistent(surface, nodes, heights, min_persistence, min_area, &q));
    }

    const std::vector<SelectedNode> order = order_regions(scene.trees, selected);
    const std::vector<std::int32_t> region_of_triangle = label_triangles(scene.trees, order);
    const std::vector<int> numbers = oracle::region_numbers(scene.surfaces[0], regions[0], regions[1]);
    ASSERT_EQ(region_of_triangle, std::vector<std::int32_t>(numbers.begin(), numbers.end()));
    const Patches patches = split_patches(scene.twins, region_of_triangle, scene.areas);
    const std::vector<int> split = oracle::split_numbers(scene.surfaces[0], numbers);
    ASSERT_EQ(patches.patch_of_triangle, std::vector<std::int32_t>(split.begin(), split.end()));

    const SurfaceView view{scene.mesh.positions, scene.mesh.triangles, scene.twins};
    for (std::size_t side = 0; side < 2; ++side) {
      SCOPED_TRACE(side == 0 ? "upper" : "lower");
      std::vector<std::int32_t> number_of_node(scene.trees[side].num_nodes(), 0);
      for (std::size_t r = 0; r < order.size(); ++r)
        if (order[r].tree == static_cast<std::int32_t>(side))
          number_of_node[static_cast<std::size_t>(order[r].node)] = static_cast<std::int32_t>(r) + 1;
      const BorderLoops borders = extract_borders(view, scene.trees[side], number_of_node, region_of_triangle);
      int dropped = 0;
      std::size_t total = 0;
      for (std::size_t n = 0; n < number_of_node.size(); ++n) {
        if (number_of_node[n] == 0) continue;
        const oracle::Loops expected = oracle::border_loops(scene.surfaces[side], sets[side][n]);
        EXPECT_EQ(loops_of(borders, number_of_node[n]), expected.loops);
        dropped += expected.dropped;
        total += expected.loops.size();
      }
      EXPECT_EQ(borders.num_loops(), total);
      EXPECT_EQ(borders.num_hole_loops_dropped, dropped);
    }
    const BorderLoops label_borders = extract_label_borders(view, patches.patch_of_triangle);
    for (std::size_t label = 1; label <= patches.num_patches(); ++label) {
      Triangles members;
      for (std::size_t t = 0; t < split.size(); ++t)
        if (split[t] == static_cast<int>(label)) members.insert(static_cast<int>(t));
      EXPECT_EQ(loops_of(label_borders, static_cast<std::int32_t>(label)),
                oracle::border_loops(scene.surfaces[0], members).loops);
    }
    if (HasFailure()) return;
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, AgainstOracle, ::testing::Range(0, 10));

}  // namespace
}  // namespace meshmser
