/// The tree of shapes against saturation by the definition, on random small meshes.

#include "stages/tree/tree_of_shapes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <tuple>

#include "stages/common/adjacency.hpp"
#include "stages/common/tree_nodes.hpp"
#include "stages/tree/component_tree.hpp"
#include "stages/tree/levels.hpp"
#include "tests/support/random_mesh.hpp"

namespace meshmser {
namespace {

using Set = std::set<int>;

struct Scene {
  testing::RandomMesh mesh;
  std::vector<std::uint8_t> excluded;
  std::vector<std::int32_t> twins, level;
  std::vector<double> areas, levels;
  std::int32_t root_vertex = -1;

  SurfaceView surface() const { return {mesh.positions, mesh.triangles, twins}; }
  TreeOfShapes shapes() const { return build_tree_of_shapes(surface(), areas, level, levels, excluded, root_vertex); }
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

/// Classes of 0 .. n - 1 joined by pairs.
std::vector<int> classes(int n, const std::set<std::pair<int, int>>& pairs) {
  std::vector<int> of(static_cast<std::size_t>(n));
  std::iota(of.begin(), of.end(), 0);
  for (bool changed = true; changed;) {
    changed = false;
    for (const auto& [a, b] : pairs) {
      int &x = of[static_cast<std::size_t>(a)], &y = of[static_cast<std::size_t>(b)];
      if (x == y) continue;
      x = y = std::min(x, y);
      changed = true;
    }
  }
  return of;
}

/// The mesh as spheres, in the words of the definition: a node for each class of corners that meet in edges, then one
/// for each class of rim half-edges that meet in nodes.
struct Spheres {
  std::vector<int> node_of_corner;  // -1: excluded
  std::vector<int> level, mesh_vertex;
  std::map<int, double> rim_length;  // of the closing nodes
  std::map<int, Set> neighbours;
  std::vector<int> component;
};

Spheres make_spheres(const Scene& scene) {
  const int corners = static_cast<int>(scene.twins.size());
  std::set<std::pair<int, int>> same;
  for (int h = 0; h < corners; ++h) {
    const int twin = scene.twins[static_cast<std::size_t>(h)];
    if (twin < 0) continue;
    same.insert({h, next_half_edge(twin)});
    same.insert({next_half_edge(h), twin});
  }
  const std::vector<int> of_corner = classes(corners, same);
  Spheres spheres;
  spheres.node_of_corner.assign(static_cast<std::size_t>(corners), -1);
  std::map<int, int> number;
  for (int c = 0; c < corners; ++c) {
    const auto t = static_cast<std::size_t>(c / 3);
    if (scene.excluded[t] != 0) continue;
    const auto [found, is_new] =
        number.insert({of_corner[static_cast<std::size_t>(c)], static_cast<int>(spheres.level.size())});
    spheres.node_of_corner[static_cast<std::size_t>(c)] = found->second;
    const int vertex = scene.mesh.triangles[t][static_cast<std::size_t>(c % 3)];
    if (!is_new) continue;
    spheres.level.push_back(scene.level[static_cast<std::size_t>(vertex)]);
    spheres.mesh_vertex.push_back(vertex);
  }
  const auto node = [&](int h) { return spheres.node_of_corner[static_cast<std::size_t>(h)]; };
  std::vector<int> rim;
  for (int h = 0; h < corners; ++h) {
    if (node(h) < 0) continue;
    const int next = next_half_edge(h);
    spheres.neighbours[node(h)].insert(node(next));
    spheres.neighbours[node(next)].insert(node(h));
    if (scene.twins[static_cast<std::size_t>(h)] < 0) rim.push_back(h);
  }
  std::set<std::pair<int, int>> meet;
  for (int i = 0; i < static_cast<int>(rim.size()); ++i)
    for (int j = 0; j < static_cast<int>(rim.size()); ++j)
      if (node(next_half_edge(rim[static_cast<std::size_t>(i)])) == node(rim[static_cast<std::size_t>(j)]))
        meet.insert({i, j});
  const std::vector<int> loop_of = classes(static_cast<int>(rim.size()), meet);
  std::map<int, std::vector<int>> loops;
  for (std::size_t i = 0; i < rim.size(); ++i) loops[loop_of[i]].push_back(rim[i]);
  for (const auto& [first, loop] : loops) {
    const int closing = static_cast<int>(spheres.level.size());
    std::vector<int> levels;
    for (const int h : loop) {
      levels.push_back(spheres.level[static_cast<std::size_t>(node(h))]);
      spheres.neighbours[closing].insert(node(h));
      spheres.neighbours[node(h)].insert(closing);
      const auto position = [&](int half_edge) {
        return scene.mesh.positions[static_cast<std::size_t>(
            scene.mesh.triangles[static_cast<std::size_t>(half_edge / 3)][static_cast<std::size_t>(half_edge % 3)])];
      };
      spheres.rim_length[closing] += (position(next_half_edge(h)) - position(h)).norm();
    }
    std::sort(levels.begin(), levels.end());
    spheres.level.push_back(levels[(levels.size() - 1) / 2]);
    spheres.mesh_vertex.push_back(-1);
  }
  std::set<std::pair<int, int>> edges;
  for (const auto& [a, all] : spheres.neighbours)
    for (const int b : all) edges.insert({a, b});
  spheres.component = classes(static_cast<int>(spheres.level.size()), edges);
  return spheres;
}

/// Is every component a sphere, its rims closed? Vertices - edges + faces, where a rim of n edges is closed by n edges
/// and n faces.
bool are_spheres(const Scene& scene, const Spheres& spheres) {
  std::map<int, int> twice;
  for (std::size_t v = 0; v < spheres.component.size(); ++v) twice[spheres.component[v]] += 2;
  for (std::size_t t = 0; t < scene.excluded.size(); ++t) {
    if (scene.excluded[t] != 0) continue;
    int& sum = twice[spheres.component[static_cast<std::size_t>(spheres.node_of_corner[3 * t])]];
    sum += 2;
    for (std::size_t k = 0; k < 3; ++k) sum -= scene.twins[3 * t + k] < 0 ? 2 : 1;
  }
  return std::all_of(twice.begin(), twice.end(), [](const auto& of) { return of.second == 4; });
}

std::vector<Set> parts_of(const Spheres& spheres, Set members) {
  std::vector<Set> parts;
  while (!members.empty()) {
    Set part = {*members.begin()}, rim = part;
    while (!rim.empty()) {
      Set next;
      for (const int v : rim)
        for (const int w : spheres.neighbours.at(v))
          if (members.contains(w) && !part.contains(w)) next.insert(w);
      part.insert(next.begin(), next.end());
      rim = next;
    }
    for (const int v : part) members.erase(v);
    parts.push_back(part);
  }
  return parts;
}

Set without(const Set& all, const Set& some) {
  Set left;
  std::set_difference(all.begin(), all.end(), some.begin(), some.end(), std::inserter(left, left.end()));
  return left;
}

struct Shape {
  Set nodes;
  int threshold = 0;
  bool bright = false;
};

/// Every shape of one component, a shape of several thresholds as often.
std::vector<Shape> shapes_of(const Spheres& spheres, const Set& component, int root, int num_levels) {
  std::vector<Shape> shapes;
  for (int k = 1; k <= num_levels; ++k)
    for (const bool bright : {true, false}) {
      Set side;
      for (const int v : component)
        if ((spheres.level[static_cast<std::size_t>(v)] >= k) == bright) side.insert(v);
      for (const Set& part : parts_of(spheres, side)) {
        if (part.contains(root)) continue;
        Shape shape{part, k, bright};
        for (const Set& rest : parts_of(spheres, without(component, part)))
          if (!rest.contains(root)) shape.nodes.insert(rest.begin(), rest.end());
        shapes.push_back(shape);
      }
    }
  return shapes;
}

/// The triangles whose corners all lie in the set.
Set triangles_in(const Spheres& spheres, const Set& nodes) {
  Set triangles;
  for (int t = 0; 3 * t < static_cast<int>(spheres.node_of_corner.size()); ++t) {
    bool all = true;
    for (int k = 0; k < 3; ++k)
      all = all && nodes.contains(spheres.node_of_corner[static_cast<std::size_t>(3 * t + k)]);
    if (all) triangles.insert(t);
  }
  return triangles;
}

std::vector<Set> edge_parts(const Scene& scene, const Set& triangles) {
  std::set<std::pair<int, int>> pairs;
  for (std::size_t h = 0; h < scene.twins.size(); ++h)
    if (scene.twins[h] >= 0 && triangles.contains(static_cast<int>(h / 3)) && triangles.contains(scene.twins[h] / 3))
      pairs.insert({static_cast<int>(h / 3), scene.twins[h] / 3});
  const std::vector<int> of = classes(static_cast<int>(scene.twins.size() / 3), pairs);
  std::map<int, Set> parts;
  for (const int t : triangles) parts[of[static_cast<std::size_t>(t)]].insert(t);
  std::vector<Set> result;
  for (auto& [first, part] : parts) result.push_back(part);
  return result;
}

std::vector<Set> sets_of(const ComponentTree& tree) {
  std::vector<Set> sets(tree.num_nodes());
  for (std::size_t t = 0; t < tree.node_of_triangle.size(); ++t)
    for (std::int32_t n = tree.node_of_triangle[t]; n >= 0; n = tree.parent_of_node[static_cast<std::size_t>(n)])
      sets[static_cast<std::size_t>(n)].insert(static_cast<int>(t));
  return sets;
}

/// The root of a component as the definition has it; for one without rim and without the user's vertex any node of
/// which, taken as the root, no shape outweighs the rest.
std::vector<int> possible_roots(const Scene& scene, const Spheres& spheres, const Set& component) {
  std::vector<int> roots;
  for (const int v : component)
    if (scene.root_vertex >= 0 && spheres.mesh_vertex[static_cast<std::size_t>(v)] == scene.root_vertex) return {v};
  double longest = -1;
  for (const int v : component)
    if (spheres.rim_length.contains(v)) longest = std::max(longest, spheres.rim_length.at(v));
  for (const int v : component)
    if (longest < 0 || (spheres.rim_length.contains(v) && spheres.rim_length.at(v) > longest - 1e-9))
      roots.push_back(v);
  return roots;
}

double weight_of(const Scene& scene, const Spheres& spheres, const Set& nodes) {
  double weight = 0;
  for (std::size_t c = 0; c < spheres.node_of_corner.size(); ++c)
    if (nodes.contains(spheres.node_of_corner[c])) weight += scene.areas[c / 3] / 3;
  return weight;
}

/// Does the tree, on this component, hold what saturation about this root gives?
bool agrees(const Scene& scene, const Spheres& spheres, const Set& component, int root, const TreeOfShapes& of,
            const std::vector<Set>& sets) {
  const ComponentTree& tree = of.tree;
  const int num_levels = static_cast<int>(scene.levels.size());
  const std::vector<Shape> shapes = shapes_of(spheres, component, root, num_levels);
  const Set all = triangles_in(spheres, component);
  std::set<Set> expected;
  std::vector<int> lines(tree.node_of_triangle.size(), 1);
  for (const Set& part : edge_parts(scene, all)) expected.insert(part);
  for (const Shape& shape : shapes) {
    const Set triangles = triangles_in(spheres, shape.nodes);
    for (const int t : triangles) ++lines[static_cast<std::size_t>(t)];
    for (const Set& part : edge_parts(scene, triangles)) expected.insert(part);
  }
  std::set<Set> found;
  for (std::size_t n = 0; n < sets.size(); ++n)
    if (all.contains(*sets[n].begin())) found.insert(sets[n]);
  if (found != expected) return false;
  for (const int t : all)
    if (tree.hi_of_node[static_cast<std::size_t>(tree.node_of_triangle[static_cast<std::size_t>(t)])] !=
        lines[static_cast<std::size_t>(t)])
      return false;
  // The line of each node: of the outermost shape with just these triangles about here.
  for (std::size_t n = 0; n < sets.size(); ++n) {
    if (!all.contains(*sets[n].begin()) || tree.parent_of_node[n] < 0) continue;
    std::set<std::tuple<double, bool>> possible;
    std::size_t largest = 0;
    for (const Shape& shape : shapes) {
      const auto parts = edge_parts(scene, triangles_in(spheres, shape.nodes));
      if (std::find(parts.begin(), parts.end(), sets[n]) != parts.end())
        largest = std::max(largest, shape.nodes.size());
    }
    for (const Shape& shape : shapes) {
      const auto parts = edge_parts(scene, triangles_in(spheres, shape.nodes));
      if (shape.nodes.size() == largest && std::find(parts.begin(), parts.end(), sets[n]) != parts.end())
        possible.insert({scene.levels[static_cast<std::size_t>(shape.threshold) - 1], shape.bright});
    }
    const bool bright = of.side_of_node[n] == Polarity::kUpper;
    if (!possible.contains({of.value_of_node[n], bright})) return false;
    // Of equal sets the line next to the outside: the lowest of a bright shape, the highest of a dark one.
    for (const auto& [value, side] : possible)
      if (side != bright || (bright ? value < of.value_of_node[n] : value > of.value_of_node[n])) return false;
  }
  return true;
}

TEST(TreeOfShapes, IsSaturationOnRandomMeshes) {
  int bright = 0, dark = 0, filled = 0, closed = 0, handles = 0;
  for (std::uint32_t seed = 1; seed <= 2500; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Scene scene = make_scene(seed);
    const Spheres spheres = make_spheres(scene);
    if (!are_spheres(scene, spheres)) {
      EXPECT_THROW(scene.shapes(), StageError);
      ++handles;
      continue;
    }
    const TreeOfShapes of = scene.shapes();
    const ComponentTree& tree = of.tree;
    const std::vector<Set> sets = sets_of(tree);
    for (const Polarity side : of.side_of_node) ++(side == Polarity::kUpper ? bright : dark);
    std::map<int, Set> components;
    for (std::size_t v = 0; v < spheres.component.size(); ++v)
      components[spheres.component[v]].insert(static_cast<int>(v));
    for (const auto& [first, component] : components) {
      const std::vector<int> roots = possible_roots(scene, spheres, component);
      bool any = false;
      for (const int root : roots) {
        const std::vector<Shape> shapes = shapes_of(spheres, component, root, static_cast<int>(scene.levels.size()));
        // Nested or disjoint.
        for (const Shape& a : shapes)
          for (const Shape& b : shapes) {
            const std::size_t common = a.nodes.size() - without(a.nodes, b.nodes).size();
            ASSERT_TRUE(common == 0 || common == a.nodes.size() || common == b.nodes.size());
          }
        const double half = weight_of(scene, spheres, component) / 2;
        if (roots.size() == component.size() && roots.size() > 1 &&
            std::any_of(shapes.begin(), shapes.end(),
                        [&](const Shape& shape) { return weight_of(scene, spheres, shape.nodes) > half + 1e-9; }))
          continue;
        any = any || agrees(scene, spheres, component, root, of, sets);
        if (any) break;
      }
      EXPECT_TRUE(any) << "component of node " << first;
      closed += roots.size() == component.size();
      if (any)
        for (const Shape& shape : shapes_of(spheres, component, roots[0], static_cast<int>(scene.levels.size())))
          for (const int v : shape.nodes)
            filled += (spheres.level[static_cast<std::size_t>(v)] >= shape.threshold) != shape.bright;
    }
    for (std::size_t t = 0; t < scene.excluded.size(); ++t)
      EXPECT_EQ(tree.node_of_triangle[t] < 0, scene.excluded[t] != 0);
    if (HasFailure()) return;
  }
  // What the meshes are for did happen.
  EXPECT_GT(bright, 1000);
  EXPECT_GT(dark, 1000);
  EXPECT_GT(filled, 1000);
  EXPECT_GT(closed, 100);
  EXPECT_GT(handles, 0);
  EXPECT_LT(handles, 500);
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
  const TreeOfShapes of = scene.shapes();
  const ComponentTree& tree = of.tree;
  ASSERT_EQ(tree.num_nodes(), 3u);
  // Postorder: the dark inside, the filled ring, the sheet.
  EXPECT_EQ(tree.parent_of_node, (std::vector<std::int32_t>{1, 2, -1}));
  EXPECT_EQ(area_of_node(tree, 0), 16);
  EXPECT_EQ(area_of_node(tree, 1), 64);
  EXPECT_EQ(area_of_node(tree, 2), 144);
  EXPECT_EQ(of.side_of_node[0], Polarity::kLower);
  EXPECT_EQ(of.side_of_node[1], Polarity::kUpper);
  // 6 and 8 lie between ground and ring; 8, 6, 4, 2 between ring and inside.
  EXPECT_EQ(tree.hi_of_node, (std::vector<std::int32_t>{7, 3, 1}));
  EXPECT_EQ(of.value_of_node[0], 8);
  EXPECT_EQ(of.value_of_node[1], 6);
  EXPECT_EQ(tree.levels, (std::vector<double>{0, 2, 4, 6, 8, 10, 12}));
}

TEST(TreeOfShapes, ThePiecesOfARegionCutByAHoleAreNodes) {
  // A bright bar across a hole, and a dark rest.
  Scene scene = sheet(12, [](int x, int y) { return x >= 2 && x <= 10 && y >= 3 && y <= 9 ? 1 : 0; });
  for (int cell = 0; cell < 144; ++cell) {
    const int x = cell % 12, y = cell / 12;
    for (int half = 0; half < 2; ++half) scene.excluded.push_back(x >= 4 && x <= 7 && y >= 2 && y <= 9);
  }
  finish(scene, {0, 1});
  const TreeOfShapes of = scene.shapes();
  const ComponentTree& tree = of.tree;
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
                 "lower tree");
  }
}

TEST(TreeOfShapes, NothingAndOneTriangle) {
  Scene none;
  finish(none, {0});
  EXPECT_EQ(none.shapes().tree.num_nodes(), 0u);
  Scene one;
  one.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  one.mesh.triangles = {{0, 1, 2}};
  one.mesh.values = {0, 1, 2};
  finish(one, {0, 1, 2});
  EXPECT_EQ(one.shapes().tree.num_nodes(), 1u);
}

}  // namespace
}  // namespace meshmser
