/// The tree of shapes against saturation by the definition, and what is made of it against brute force, on random small
/// meshes.

#include "stages/tree/tree_of_shapes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <random>
#include <set>

#include "stages/borders/borders.hpp"
#include "stages/borders/curves.hpp"
#include "stages/common/adjacency.hpp"
#include "stages/common/maxima.hpp"
#include "stages/common/tree_nodes.hpp"
#include "stages/mser/label_triangles.hpp"
#include "stages/mser/level_lines.hpp"
#include "stages/mser/persistence.hpp"
#include "stages/mser/segment.hpp"
#include "stages/mser/stability.hpp"
#include "stages/tree/component_tree.hpp"
#include "stages/tree/edit_tree.hpp"
#include "stages/tree/levels.hpp"
#include "tests/support/border_checker.hpp"
#include "tests/support/node_sets.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/random_mesh.hpp"
#include "tests/support/saturation.hpp"

namespace meshmser {
namespace {

using oracle::Triangles;

struct Scene {
  testing::RandomMesh mesh;
  std::vector<std::uint8_t> excluded;
  std::vector<std::int32_t> twins, level;
  std::vector<double> areas, levels;
  std::int32_t root_vertex = -1;

  SurfaceView surface() const { return {mesh.positions, mesh.triangles, twins}; }
  ComponentTree shapes() const { return build_tree_of_shapes(surface(), areas, level, levels, excluded, root_vertex); }
  oracle::ShapesCase words() const {
    return {mesh.positions, mesh.triangles, excluded, twins, level, areas, static_cast<int>(levels.size()),
            root_vertex};
  }
};

Scene make_scene(std::uint32_t seed) {
  std::mt19937_64 random(seed);
  Scene scene;
  scene.mesh = testing::random_mesh(seed);
  scene.excluded.assign(scene.mesh.triangles.size(), 0);
  if (random() % 4 == 0)
    for (auto& flag : scene.excluded) flag = random() % 8 == 0;
  scene.twins = twin_half_edges(scene.mesh.triangles, scene.mesh.positions.size());
  cut_out_triangles(scene.twins, scene.excluded);
  scene.areas = triangle_areas(scene.mesh.positions, scene.mesh.triangles);
  for (double& area : scene.areas) area = 0.5 * std::round(2 * area);
  for (int k = -5; k <= 5; ++k)
    if (random() % 4 != 0) scene.levels.push_back(k);
  if (scene.levels.empty() || random() % 2 == 0)
    scene.levels.insert(scene.levels.begin(), -std::numeric_limits<double>::infinity());
  scene.level = levels_of_vertices(scene.mesh.values, scene.levels, 1);
  if (random() % 3 == 0) scene.root_vertex = static_cast<std::int32_t>(random() % scene.mesh.positions.size());
  return scene;
}

TEST(TreeOfShapes, IsSaturationOnRandomMeshes) {
  int bright = 0, dark = 0, filled = 0, closed = 0, handles = 0;
  for (std::uint32_t seed = 1; seed <= 2500; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Scene scene = make_scene(seed);
    if (!oracle::has_no_handle(scene.words())) {
      EXPECT_THROW(scene.shapes(), StageError);
      ++handles;
      continue;
    }
    const ComponentTree tree = scene.shapes();
    for (const Polarity side : tree.side_of_node) ++(side == Polarity::kUpper ? bright : dark);
    const oracle::ShapesCheck check = oracle::check_shapes(scene.words(), tree);
    ASSERT_EQ(check.broken, "");
    filled += check.num_filled;
    closed += check.num_closed;
  }
  // What the meshes are for did happen.
  EXPECT_GT(bright, 1000);
  EXPECT_GT(dark, 1000);
  EXPECT_GT(filled, 1000);
  EXPECT_GT(closed, 100);
  EXPECT_GT(handles, 0);
  EXPECT_LT(handles, 500);
}

/// The surface as the oracle of selections and borders takes it, with the numbers of lines by saturation as its levels.
oracle::Surface lines_of(const Scene& scene, const std::vector<int>& lines) {
  oracle::Surface surface;
  for (std::size_t t = 0; t < scene.mesh.triangles.size(); ++t) {
    const auto& corners = scene.mesh.triangles[t];
    surface.corners.push_back({corners[0], corners[1], corners[2]});
    surface.cut_out.push_back(scene.excluded[t] != 0);
    surface.area.push_back(static_cast<std::int64_t>(2 * scene.areas[t]));
    surface.num_levels = std::max(surface.num_levels, lines[t]);
  }
  surface.level = lines;
  return surface;
}

/// Borders of regions against the triangles of their nodes, and S on both sides of them.
void check_borders(const Scene& scene, const oracle::Surface& surface, const ComponentTree& tree,
                   const std::vector<std::int32_t>& nodes, const std::vector<Triangles>& sets) {
  const std::vector trees{tree};
  const std::vector<SelectedNode> regions = order_regions(trees, std::array{nodes});
  const std::vector<std::int32_t> labels = label_triangles(trees, regions);
  const BorderLoops loops = extract_borders(scene.surface(), tree, number_of_nodes(tree, regions), labels);
  for (std::size_t r = 0; r < regions.size(); ++r) {
    const auto number = static_cast<std::int32_t>(r) + 1;
    const Triangles& set = sets[static_cast<std::size_t>(regions[r].node)];
    std::vector<std::uint8_t> inside(scene.excluded.size(), 0);
    for (const int t : set) inside[static_cast<std::size_t>(t)] = 1;
    EXPECT_EQ(
        testing::check_border_loops(scene.mesh.positions, scene.mesh.triangles, scene.excluded, inside, loops, number),
        "");
    std::vector<std::vector<int>> found;
    for (std::size_t l = 0; l < loops.num_loops(); ++l) {
      if (loops.owner_of_loop[l] != number) continue;
      found.emplace_back(loops.half_edges.begin() + loops.first_edge_of_loop[l],
                         loops.half_edges.begin() + loops.first_edge_of_loop[l + 1]);
      // The line lies between what is within and what is without.
      for (const int h : found.back()) {
        const int twin = scene.twins[static_cast<std::size_t>(h)];
        if (twin < 0) continue;
        const auto value = [&](int half_edge) {
          return scene.mesh.values[static_cast<std::size_t>(
              scene.mesh.triangles[static_cast<std::size_t>(half_edge / 3)][static_cast<std::size_t>(half_edge % 3)])];
        };
        const bool bright = tree.side(regions[r].node) == Polarity::kUpper;
        const double line = tree.value(regions[r].node);
        for (const int end : {h, twin}) EXPECT_EQ(value(end) >= line, bright);
        EXPECT_EQ(value(previous_half_edge(twin)) >= line, !bright);
      }
    }
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, oracle::border_loops(surface, set).loops);
  }
}

TEST(TreeOfShapes, SelectionAndBordersAreThoseOfBruteForce) {
  int selected = 0, dark = 0, on_levels = 0;
  for (std::uint32_t seed = 3001; seed <= 6000; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Scene scene = make_scene(seed);
    if (!oracle::has_no_handle(scene.words())) continue;
    const ComponentTree tree = scene.shapes();
    const oracle::ShapesCheck check = oracle::check_shapes(scene.words(), tree);
    ASSERT_EQ(check.broken, "");
    const oracle::Surface surface = lines_of(scene, check.lines);
    const std::vector<oracle::Node> nodes = oracle::all_nodes(surface);
    const std::vector<Triangles> sets = testing::sets_of(tree);
    const int delta = 1 + static_cast<int>(seed % 3);
    const Against against = seed % 2 == 0 ? Against::kChildren : Against::kMainChild;
    const std::vector<oracle::Ratio> q = oracle::stability(surface, nodes, delta);
    const std::vector<std::int32_t> stable =
        select_mser(tree, {delta, against}, open_roots(tree, scene.twins, scene.excluded));
    std::set<Triangles> chosen;
    for (const std::int32_t node : stable) chosen.insert(sets[static_cast<std::size_t>(node)]);
    ASSERT_EQ(chosen, oracle::selection(surface, nodes, q, against == Against::kMainChild));
    check_borders(scene, surface, tree, stable, sets);

    // Every node at one level is a region as well.
    const double level = static_cast<double>(seed % 9) - 4;
    const std::vector<std::int32_t> at_level = select_level(tree, level);
    check_borders(scene, surface, tree, at_level, sets);
    const TreeCut cut = cut_tree(tree, level_of_value(tree, level));
    EXPECT_EQ(std::set<std::int32_t>(cut.nodes.begin(), cut.nodes.end()),
              std::set<std::int32_t>(at_level.begin(), at_level.end()));
    selected += static_cast<int>(stable.size());
    on_levels += static_cast<int>(at_level.size());
    for (const std::int32_t node : stable) dark += tree.side(node) == Polarity::kLower;
    if (HasFailure()) return;
  }
  EXPECT_GT(selected, 500);
  EXPECT_GT(dark, 100);
  EXPECT_GT(selected - dark, 100);
  EXPECT_GT(on_levels, 300);
}

/// Maxima of bright nodes and minima of dark ones, and what is selected by them, word by word.
struct LiteralMaxima {
  const ComponentTree& tree;
  std::vector<std::int32_t> smallest;  ///< triangle of each node

  std::size_t size() const { return tree.num_nodes(); }
  std::int32_t parent(std::int32_t n) const { return tree.parent_of_node[static_cast<std::size_t>(n)]; }
  /// The node around a node that is of its side and no root; else -1.
  std::int32_t above(std::int32_t n) const {
    const std::int32_t p = parent(n);
    return p < 0 || parent(p) < 0 || tree.side(p) != tree.side(n) ? -1 : p;
  }
  std::vector<std::int32_t> leaves_in(std::int32_t node) const {
    std::set<std::int32_t> leaves;
    for (std::int32_t n = 0; n < static_cast<std::int32_t>(size()); ++n) {
      bool is_leaf = true;
      for (std::int32_t m = 0; m < static_cast<std::int32_t>(size()); ++m) is_leaf = is_leaf && above(m) != n;
      std::int32_t at = n;
      while (at >= 0 && at != node) at = above(at);
      if (is_leaf && at == node) leaves.insert(n);
    }
    return {leaves.begin(), leaves.end()};
  }
  std::int32_t highest_in(std::int32_t node) const {
    const std::vector<std::int32_t> leaves = leaves_in(node);
    return *std::min_element(leaves.begin(), leaves.end(), [&](std::int32_t a, std::int32_t b) {
      const auto rank = [&](std::int32_t n) {
        return std::pair(-tree.hi_of_node[static_cast<std::size_t>(n)], smallest[static_cast<std::size_t>(n)]);
      };
      return rank(a) < rank(b);
    });
  }
  std::int32_t top_of(std::int32_t leaf) const {
    std::int32_t top = leaf;
    while (above(top) >= 0 && highest_in(above(top)) == leaf) top = above(top);
    return top;
  }
};

TEST(TreeOfShapes, PersistentNodesAreThoseOfBruteForce) {
  int found = 0, dark = 0, within_others = 0;
  for (std::uint32_t seed = 6001; seed <= 12000; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Scene scene = make_scene(seed);
    if (!oracle::has_no_handle(scene.words())) continue;
    const ComponentTree tree = scene.shapes();
    const Maxima maxima = find_maxima(tree);
    const LiteralMaxima literal{tree, smallest_triangle_of_nodes(tree)};
    const Significance significance{static_cast<double>(seed % 4), 0.5 * (seed / 4 % 4)};
    const auto n = static_cast<std::int32_t>(tree.num_nodes());
    std::vector<std::size_t> significant(tree.num_nodes(), 0);
    const std::vector<double> heights = heights_of_levels(tree.levels);
    const auto height = [&](std::int32_t node) { return heights[static_cast<std::size_t>(tree.own_level(node))]; };
    for (std::int32_t node = 0; node < n; ++node) {
      ASSERT_EQ(maxima.highest_of_node[static_cast<std::size_t>(node)], literal.highest_in(node));
      for (const std::int32_t leaf : literal.leaves_in(node)) {
        const std::int32_t top = literal.top_of(leaf);
        const double persistence = literal.parent(top) < 0 ? heights.back() - heights[1]
                                                           : std::abs(height(leaf) - height(literal.parent(top)));
        ASSERT_EQ(maxima.top_of_leaf[static_cast<std::size_t>(leaf)], top);
        ASSERT_EQ(maxima.persistence_of_leaf[static_cast<std::size_t>(leaf)], persistence);
        significant[static_cast<std::size_t>(node)] +=
            persistence > significance.min_persistence && area_of_node(tree, top) >= significance.min_area;
      }
    }
    const std::vector<std::int64_t> changes = change_of_nodes(tree, 1 + static_cast<int>(seed % 3));
    std::vector<std::int32_t> persistent, stable;
    for (std::int32_t node = 0; node < n; ++node) {
      const std::int32_t above = literal.above(node);
      if (literal.parent(node) < 0 || significant[static_cast<std::size_t>(node)] != 1 ||
          (above >= 0 && significant[static_cast<std::size_t>(above)] == 1))
        continue;
      persistent.push_back(node);
      std::int32_t best = -1;
      for (std::int32_t at = literal.highest_in(node); at >= 0; at = at == node ? -1 : literal.above(at)) {
        if (at != node && area_of_node(tree, at) < significance.min_area) continue;
        const auto a = static_cast<std::size_t>(at), b = static_cast<std::size_t>(std::max(best, 0));
        if (best < 0 || compare_stability(changes[a], tree.area_of_node[a], changes[b], tree.area_of_node[b]) <= 0)
          best = at;
      }
      stable.push_back(best);
      dark += tree.side(node) == Polarity::kLower;
      within_others += literal.parent(literal.parent(node)) >= 0 && above < 0;
    }
    std::sort(stable.begin(), stable.end());
    NodeFates fates(tree.num_nodes());
    ASSERT_EQ(select_persistence(tree, maxima, significance, &fates), persistent);
    for (std::int32_t node = 0; node < n; ++node)
      ASSERT_EQ(fates[static_cast<std::size_t>(node)].kind == NodeFate::Kind::kRegion,
                std::binary_search(persistent.begin(), persistent.end(), node));
    ASSERT_EQ(select_stable_branch(tree, maxima, changes, significance, &fates), stable);
    for (std::int32_t node = 0; node < n; ++node)
      ASSERT_EQ(fates[static_cast<std::size_t>(node)].kind == NodeFate::Kind::kRegion,
                std::binary_search(stable.begin(), stable.end(), node));
    found += static_cast<int>(persistent.size());
  }
  EXPECT_GT(found, 500);
  EXPECT_GT(dark, 100);
  EXPECT_GT(within_others, 40);
}

/// Where a curve may leave its line for the vertex itself: the region has several wedges of triangles there, or an edge
/// without triangles leads on to a vertex of its side.
bool touches_itself(const Scene& scene, const Triangles& region, std::int32_t vertex,
                    const std::vector<bool>& in_side) {
  std::multiset<std::int32_t> ends;  // of the region's edges at the vertex, one a triangle
  std::set<std::int32_t> outside;    // of other triangles
  std::size_t num_triangles = 0;
  for (std::size_t t = 0; t < scene.mesh.triangles.size(); ++t) {
    const auto& corners = scene.mesh.triangles[t];
    if (scene.excluded[t] != 0 || std::find(corners.begin(), corners.end(), vertex) == corners.end()) continue;
    num_triangles += region.contains(static_cast<int>(t));
    for (const std::int32_t corner : corners) {
      if (corner == vertex) continue;
      if (region.contains(static_cast<int>(t)))
        ends.insert(corner);
      else
        outside.insert(corner);
    }
  }
  // An open wedge of n triangles has n + 1 edges.
  const std::set<std::int32_t> different(ends.begin(), ends.end());
  if (different.size() > num_triangles + 1) return true;
  return std::any_of(outside.begin(), outside.end(), [&](std::int32_t end) {
    return in_side[static_cast<std::size_t>(end)] && !different.contains(end);
  });
}

TEST(TreeOfShapes, CurvesRunWhereTheScalarIsThatOfTheLine) {
  int on_edges = 0, on_vertices = 0, through_regions = 0;
  for (std::uint32_t seed = 6001; seed <= 8000; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Scene scene = make_scene(seed);
    if (!oracle::has_no_handle(scene.words())) continue;
    const ComponentTree tree = scene.shapes();
    const std::vector<Triangles> sets = testing::sets_of(tree);
    std::vector<std::int32_t> number_of_node(tree.num_nodes(), 0);
    std::vector<BorderRegion> regions;
    for (std::size_t n = 0; n < tree.num_nodes(); ++n) {
      regions.push_back({&tree, static_cast<std::int32_t>(n)});
      number_of_node[n] = static_cast<std::int32_t>(n) + 1;
    }
    const std::vector<std::int32_t> behind(scene.excluded.size(), 0);
    const BorderLoops loops = extract_borders(scene.surface(), tree, number_of_node, behind);
    // Places that tell which vertex they are, and S.
    for (std::size_t v = 0; v < scene.mesh.positions.size(); ++v)
      scene.mesh.positions[v] = {static_cast<double>(v), static_cast<double>(v * v), scene.mesh.values[v]};
    const BorderCurves curves = interpolate_borders(scene.surface(), scene.mesh.values, loops, regions);
    for (std::size_t c = 0; c < loops.num_loops(); ++c) {
      const auto edge = [&](std::int64_t e) { return loops.kinds[static_cast<std::size_t>(e)]; };
      bool at_hole = false;
      for (std::int64_t e = loops.first_edge_of_loop[c]; e < loops.first_edge_of_loop[c + 1]; ++e)
        at_hole |= edge(e) == EdgeKind::kHole;
      for (std::int64_t i = curves.first_point_of_curve[c]; i < curves.first_point_of_curve[c + 1]; ++i)
        at_hole |= curves.kinds[static_cast<std::size_t>(i)] == EdgeKind::kHole;
      if (at_hole) continue;
      const std::int32_t node = loops.owner_of_loop[c] - 1;
      const double line = tree.value(node);
      std::vector<bool> in_side;
      for (const double value : scene.mesh.values)
        in_side.push_back((value >= line) == (tree.side(node) == Polarity::kUpper));
      for (std::int64_t i = curves.first_point_of_curve[c]; i < curves.first_point_of_curve[c + 1]; ++i) {
        const Eigen::Vector3d& point = curves.points[static_cast<std::size_t>(i)];
        const auto vertex = static_cast<std::int32_t>(
            std::find(scene.mesh.positions.begin(), scene.mesh.positions.end(), point) - scene.mesh.positions.begin());
        const bool at_vertex = static_cast<std::size_t>(vertex) < scene.mesh.positions.size();
        ++(at_vertex ? on_vertices : on_edges);
        if (std::abs(point.z() - line) < 1e-12) continue;
        ++through_regions;
        ASSERT_TRUE(at_vertex) << "S is " << point.z() << " on the line of " << line;
        EXPECT_TRUE(touches_itself(scene, sets[static_cast<std::size_t>(node)], vertex, in_side))
            << "vertex " << vertex;
      }
    }
    if (HasFailure()) return;
  }
  EXPECT_GT(on_edges, 300);
  EXPECT_GT(on_vertices, 300);
  EXPECT_GT(through_regions, 10);
}

/// A square sheet with one value a vertex.
Scene sheet(int side, const std::function<double(int, int)>& value) {
  Scene scene;
  for (int y = 0; y <= side; ++y)
    for (int x = 0; x <= side; ++x) {
      const int corner = (side + 1) * y + x, above = corner + side + 1;
      scene.mesh.positions.emplace_back(x, y, 0);
      scene.mesh.values.push_back(value(x, y));
      if (x == side || y == side) continue;
      scene.mesh.triangles.push_back({corner, corner + 1, above + 1});
      scene.mesh.triangles.push_back({corner, above + 1, above});
    }
  return scene;
}

void finish(Scene& scene, std::vector<double> levels) {
  scene.levels = std::move(levels);
  scene.excluded.resize(scene.mesh.triangles.size(), 0);
  scene.twins = twin_half_edges(scene.mesh.triangles, scene.mesh.positions.size());
  cut_out_triangles(scene.twins, scene.excluded);
  scene.areas = triangle_areas(scene.mesh.positions, scene.mesh.triangles);
  scene.level = levels_of_vertices(scene.mesh.values, scene.levels, 1);
}

TEST(TreeOfShapes, ARingIsFilledAndItsInsideIsAShapeOfItsOwn) {
  // A bright ring on a grey ground, dark within.
  Scene scene = sheet(12, [](int x, int y) {
    const int far = std::max(std::abs(x - 6), std::abs(y - 6));
    return far > 4 ? 5 : far > 2 ? 9 : 1;
  });
  finish(scene, {0, 2, 4, 6, 8});
  const ComponentTree tree = scene.shapes();
  ASSERT_EQ(tree.num_nodes(), 3u);
  // Postorder: the dark inside, the filled ring, the sheet.
  EXPECT_EQ(tree.parent_of_node, (std::vector<std::int32_t>{1, 2, -1}));
  EXPECT_EQ(area_of_node(tree, 0), 16);
  EXPECT_EQ(area_of_node(tree, 1), 64);
  EXPECT_EQ(area_of_node(tree, 2), 144);
  EXPECT_EQ(tree.side_of_node, (std::vector{Polarity::kLower, Polarity::kUpper, Polarity::kUpper}));
  // 6 and 8 lie between ground and ring; 8, 6, 4, 2 between ring and inside.
  EXPECT_EQ(tree.hi_of_node, (std::vector<std::int32_t>{7, 3, 1}));
  EXPECT_EQ(tree.value(0), 8);
  EXPECT_EQ(tree.value(1), 6);
  EXPECT_EQ(tree.value(2), -std::numeric_limits<double>::infinity());
  EXPECT_EQ(tree.levels, (std::vector<double>{0, 2, 4, 6, 8}));
  // The triangles' own levels: 0 inside, 8 on the ring, 4 on the ground.
  EXPECT_EQ(tree.own_level_of_node, (std::vector<std::int32_t>{1, 5, 3}));
  std::set<double> values;
  for (const double value : reconstruct_triangle_values(tree)) values.insert(value);
  EXPECT_EQ(values, (std::set<double>{0, 4, 8}));
  // The ring lasts from the ground to its crest, the inside from the crest to its floor.
  const Maxima maxima = find_maxima(tree);
  EXPECT_EQ(maxima.persistence_of_node(1), 4);
  EXPECT_EQ(maxima.persistence_of_node(0), 8);
}

TEST(TreeOfShapes, ABumpInAPitLastsAsLongAsItRisesAboveTheFloor) {
  // A deep pit with a low bump, a shallow one with a high bump, and a hill of two tops.
  Scene scene = sheet(24, [](int x, int y) {
    const auto within = [&](int cx, int cy, int r) { return std::max(std::abs(x - cx), std::abs(y - cy)) <= r; };
    if (within(5, 5, 1)) return 11;
    if (within(5, 5, 4)) return 10;
    if (within(15, 5, 1)) return 27;
    if (within(15, 5, 4)) return 19;
    if (within(4, 17, 1)) return 30;
    if (within(10, 17, 1)) return 26;
    if (y >= 12 && y <= 22 && x >= 1 && x <= 13) return 24;
    return 20;
  });
  std::vector<double> levels;
  for (int k = 8; k <= 32; ++k) levels.push_back(k);
  finish(scene, levels);
  const ComponentTree tree = scene.shapes();
  ASSERT_EQ(tree.num_nodes(), 8u);
  const Maxima maxima = find_maxima(tree);
  std::map<double, double> persistence_of_value;
  for (std::int32_t n = 0; n < 8; ++n) {
    const double own = tree.levels[static_cast<std::size_t>(tree.own_level(n)) - 1];
    persistence_of_value[own] = maxima.persistence_of_node(n);
  }
  EXPECT_EQ(persistence_of_value,
            (std::map<double, double>{{10, 10}, {11, 1}, {19, 1}, {27, 8}, {24, 10}, {30, 10}, {26, 2}, {20, 24}}));
  // Simplified, the shallow pit stays for the bump in it.
  const ComponentTree simple = simplify_tree(tree, nodes_of_persistence(tree, 3));
  EXPECT_EQ(simple.num_nodes(), 6u);
  for (std::int32_t n = 0; n < 6; ++n) {
    const double own = simple.levels[static_cast<std::size_t>(simple.own_level(n)) - 1];
    EXPECT_TRUE(own != 11 && own != 26);
    if (own == 27) {
      EXPECT_EQ(simple.value(n), 20);
    }
    if (own == 19) {
      EXPECT_EQ(simple.side(n), Polarity::kLower);
    }
  }
}

TEST(TreeOfShapes, ThePiecesOfARegionCutByAHoleAreNodes) {
  // A bright bar across a hole, and a dark rest.
  Scene scene = sheet(12, [](int x, int y) { return x >= 2 && x <= 10 && y >= 3 && y <= 9 ? 1 : 0; });
  for (int cell = 0; cell < 144; ++cell) {
    const int x = cell % 12, y = cell / 12;
    for (int half = 0; half < 2; ++half) scene.excluded.push_back(x >= 4 && x <= 7 && y >= 2 && y <= 9);
  }
  finish(scene, {0, 1});
  const ComponentTree tree = scene.shapes();
  ASSERT_EQ(tree.num_nodes(), 3u);
  for (std::size_t n = 0; n < 2; ++n) {
    EXPECT_EQ(tree.hi_of_node[n], 2);
    EXPECT_EQ(area_of_node(tree, static_cast<std::int32_t>(n)), 12);
  }
}

TEST(TreeOfShapes, HandlesAreRefused) {
  Scene scene;
  constexpr int kAround = 6;
  for (int i = 0; i < kAround; ++i)
    for (int j = 0; j < kAround; ++j) {
      const double a = 2 * M_PI * i / kAround, b = 2 * M_PI * j / kAround;
      scene.mesh.positions.emplace_back((3 + std::cos(b)) * std::cos(a), (3 + std::cos(b)) * std::sin(a), std::sin(b));
      scene.mesh.values.push_back(i);
      const auto id = [&](int k, int l) { return kAround * (k % kAround) + l % kAround; };
      scene.mesh.triangles.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      scene.mesh.triangles.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  finish(scene, {0, 3});
  try {
    scene.shapes();
    FAIL() << "a torus was taken";
  } catch (const StageError& error) {
    EXPECT_STREQ(error.what(),
                 "the tree of shapes needs a surface without handles, but the component of triangle 0 has 1: on it a "
                 "closed line need not part the inside from the outside; cut the handles open, or build an upper and a "
                 "lower tree (polarity: both)");
  }
}

TEST(TreeOfShapes, NothingAndOneTriangle) {
  Scene none;
  finish(none, {0});
  EXPECT_EQ(none.shapes().num_nodes(), 0u);
  Scene one;
  one.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  one.mesh.triangles = {{0, 1, 2}};
  one.mesh.values = {0, 1, 2};
  finish(one, {0, 1, 2});
  EXPECT_EQ(one.shapes().num_nodes(), 1u);
}

}  // namespace
}  // namespace meshmser
