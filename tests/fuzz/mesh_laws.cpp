#include "tests/fuzz/mesh_laws.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "stages/borders/borders.hpp"
#include "stages/common/adjacency.hpp"
#include "stages/common/tree_nodes.hpp"
#include "stages/mser/label_triangles.hpp"
#include "stages/mser/select_mser.hpp"
#include "stages/mser/stability.hpp"
#include "stages/tree/component_tree.hpp"
#include "stages/tree/edit_tree.hpp"
#include "stages/tree/levels.hpp"
#include "stages/tree/tree_of_shapes.hpp"
#include "tests/support/border_checker.hpp"
#include "tests/support/node_sets.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/saturation.hpp"

namespace meshmser::testing {
namespace {

using oracle::Triangles;

/// Bytes one after the other; zeros after the last.
class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  bool is_empty() const { return next_ >= bytes_.size(); }
  int below(int n) { return is_empty() ? 0 : bytes_[next_++] % n; }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t next_ = 0;
};

/// Format: parameters (delta, links, explicit levels), the number of vertices; of each vertex x, y, z and its value; of
/// each level a value, after how many there are; then triangles, three vertices and a byte that excludes one in eight,
/// until the bytes end. Triangles that would make an edge no manifold's are left out.
struct Case {
  int delta = 1;
  Against against = Against::kChildren;
  std::vector<Eigen::Vector3d> positions;
  std::vector<double> values;
  std::vector<double> levels;
  std::vector<std::array<std::int32_t, 3>> triangles;
  std::vector<std::uint8_t> excluded;
};

Case read_case(std::span<const std::uint8_t> bytes) {
  Reader reader(bytes);
  Case of;
  of.delta = 1 + reader.below(4);
  of.against = reader.below(2) == 0 ? Against::kChildren : Against::kMainChild;
  const bool explicit_levels = reader.below(4) == 0;
  const int num_vertices = 3 + reader.below(18);
  for (int v = 0; v < num_vertices; ++v) {
    const double x = reader.below(5), y = reader.below(5), z = reader.below(2);
    of.positions.emplace_back(x, y, z);
    of.values.push_back(reader.below(9) - 4);
  }
  std::set<double> levels;
  for (int i = 1 + reader.below(12); i > 0; --i) levels.insert(0.5 * (reader.below(21) - 10));
  if (!explicit_levels) levels.insert(-std::numeric_limits<double>::infinity());
  of.levels.assign(levels.begin(), levels.end());
  std::set<std::pair<std::int32_t, std::int32_t>> directed;
  while (!reader.is_empty() && of.triangles.size() < 40) {
    std::array<std::int32_t, 3> corners{};
    for (std::int32_t& corner : corners) corner = reader.below(num_vertices);
    const bool excluded = reader.below(8) == 7;
    bool fits = true;
    for (std::size_t k = 0; k < 3; ++k)
      fits = fits && corners[k] != corners[(k + 1) % 3] && !directed.contains({corners[k], corners[(k + 1) % 3]});
    if (!fits) continue;
    for (std::size_t k = 0; k < 3; ++k) directed.insert({corners[k], corners[(k + 1) % 3]});
    of.triangles.push_back(corners);
    of.excluded.push_back(excluded ? 1 : 0);
  }
  return of;
}

/// One tree of a case with the program's results and the oracle's.
struct Side {
  ComponentTree tree;
  oracle::Surface surface;
  std::vector<oracle::Node> nodes;
  std::vector<oracle::Ratio> q;
  std::vector<Triangles> sets;
  std::vector<std::int32_t> selected;
};

/// All but the tree, from the levels of the triangles as the oracle has them.
void finish(const Case& of, std::span<const std::int32_t> twins, std::span<const double> areas,
            const std::vector<int>& level, int num_levels, Side& side) {
  side.surface.num_levels = num_levels;
  side.surface.level = level;
  for (std::size_t t = 0; t < of.triangles.size(); ++t) {
    side.surface.corners.push_back({of.triangles[t][0], of.triangles[t][1], of.triangles[t][2]});
    side.surface.cut_out.push_back(of.excluded[t] != 0);
    side.surface.area.push_back(static_cast<std::int64_t>(2 * areas[t]));
  }
  side.nodes = oracle::all_nodes(side.surface);
  side.q = oracle::stability(side.surface, side.nodes, of.delta);
  side.sets = testing::sets_of(side.tree);
  side.selected = select_mser(side.tree, {of.delta, of.against}, open_roots(side.tree, twins, of.excluded));
}

Side make_side(const Case& of, std::span<const std::int32_t> twins, std::span<const double> areas, Polarity polarity) {
  const bool lower = polarity == Polarity::kLower;
  Side side;
  std::vector<double> levels = of.levels, signed_values = of.values;
  if (lower) {
    // Lists are mirrored; an infinite lowest level stays the lowest.
    const bool infinite = std::isinf(levels[0]);
    if (infinite) levels.erase(levels.begin());
    std::reverse(levels.begin(), levels.end());
    for (double& level : levels) level = -level;
    if (infinite) levels.insert(levels.begin(), -std::numeric_limits<double>::infinity());
    for (double& value : signed_values) value = -value;
  }
  const std::vector<std::int32_t> of_vertex = levels_of_vertices(of.values, levels, lower ? -1 : 1);
  side.tree = build_component_tree(twins, areas, levels_of_triangles(of.triangles, of_vertex, of.excluded),
                                   static_cast<std::int32_t>(levels.size()));
  side.tree.polarity = polarity;
  side.tree.levels = levels;
  std::vector<int> level;
  for (std::size_t t = 0; t < of.triangles.size(); ++t) {
    const std::array<int, 3> corners = {of.triangles[t][0], of.triangles[t][1], of.triangles[t][2]};
    level.push_back(of.excluded[t] != 0 ? 0 : oracle::level_of(corners, signed_values, levels));
  }
  finish(of, twins, areas, level, static_cast<int>(levels.size()), side);
  return side;
}

std::string broken_tree(const Side& side, const std::vector<std::int64_t>& changes) {
  const ComponentTree& tree = side.tree;
  if (tree.num_nodes() != side.nodes.size()) return "the tree has another number of nodes";
  if (rebuild_levels(tree) != std::vector<std::int32_t>(side.surface.level.begin(), side.surface.level.end()))
    return "the levels are not rebuilt";
  for (std::size_t n = 0; n < tree.num_nodes(); ++n) {
    const auto found = std::find_if(side.nodes.begin(), side.nodes.end(),
                                    [&](const oracle::Node& node) { return node.triangles == side.sets[n]; });
    if (found == side.nodes.end()) return "a node is no component";
    const std::int32_t parent = tree.parent_of_node[n];
    if (tree.hi_of_node[n] != found->hi || tree.lo(static_cast<std::int32_t>(n)) != found->lo)
      return "a node lasts over other levels";
    if ((parent < 0) != (found->parent < 0) ||
        (parent >= 0 &&
         side.sets[static_cast<std::size_t>(parent)] != side.nodes[static_cast<std::size_t>(found->parent)].triangles))
      return "a node has another parent";
    std::int64_t area = 0;
    for (const int t : found->triangles) area += side.surface.area[static_cast<std::size_t>(t)];
    if (2 * area_of_node(tree, static_cast<std::int32_t>(n)) != static_cast<double>(area)) return "an area is wrong";
    const oracle::Ratio& q = side.q[static_cast<std::size_t>(found - side.nodes.begin())];
    if (compare_stability(changes[n], tree.area_of_node[n], q.first, q.second) != 0) return "a stability is wrong";
  }
  return "";
}

std::string broken_selection(const Case& of, const Side& side) {
  std::set<Triangles> chosen;
  for (const std::int32_t node : side.selected) chosen.insert(side.sets[static_cast<std::size_t>(node)]);
  if (chosen != oracle::selection(side.surface, side.nodes, side.q, of.against == Against::kMainChild))
    return "another selection";
  return "";
}

/// Cut at each level, area opening and reconstruction.
std::string broken_edits(const Case& of, const Side& side) {
  const ComponentTree& tree = side.tree;
  for (int k = 1; k <= side.surface.num_levels; ++k) {
    const TreeCut cut = cut_tree(tree, k);
    // Components by the definition and as cut, paired off one to one.
    std::vector<int> expected(of.triangles.size(), 0);
    for (std::size_t n = 0; n < side.nodes.size(); ++n)
      if (side.nodes[n].lo <= k && k <= side.nodes[n].hi)
        for (const int t : side.nodes[n].triangles) expected[static_cast<std::size_t>(t)] = static_cast<int>(n) + 1;
    std::map<int, int> pair_of = {{0, 0}};
    std::set<int> taken = {0};
    for (std::size_t t = 0; t < expected.size(); ++t) {
      const auto [pair, is_new] = pair_of.insert({expected[t], cut.component_of_triangle[t]});
      if (pair->second != cut.component_of_triangle[t] || (is_new && !taken.insert(pair->second).second))
        return "a cut has other components";
    }
  }
  const ComponentTree opened = simplify_tree(tree, nodes_of_area(tree, 1.5));
  const std::vector<std::int32_t> levels = rebuild_levels(opened);
  for (std::size_t t = 0; t < levels.size(); ++t) {
    std::int32_t expected = 0;
    for (std::size_t n = 0; n < tree.num_nodes(); ++n)
      if (side.sets[n].contains(static_cast<int>(t)) &&
          (tree.parent_of_node[n] < 0 || area_of_node(tree, static_cast<std::int32_t>(n)) >= 1.5))
        expected = std::max(expected, tree.hi_of_node[n]);
    if (levels[t] != expected) return "an area opening is wrong";
  }
  const std::vector<double> of_vertex =
      reconstruct_vertex_values(tree, reconstruct_triangle_values(tree), of.triangles, of.positions.size());
  const std::vector<std::int32_t> again = levels_of_triangles(
      of.triangles, levels_of_vertices(of_vertex, tree.levels, tree.polarity == Polarity::kLower ? -1 : 1),
      of.excluded);
  if (again != rebuild_levels(tree)) return "the reconstructed scalar has other levels";
  return "";
}

/// The borders of one tree's regions; `num_loops` is counted up.
std::string broken_borders(const Case& of, std::span<const std::int32_t> twins, const Side& side,
                           std::span<const SelectedNode> regions, std::int32_t tree_index,
                           std::span<const std::int32_t> labels, std::size_t& num_loops) {
  const BorderLoops borders = extract_borders({of.positions, of.triangles, twins}, side.tree,
                                              number_of_nodes(side.tree, regions, tree_index), labels);
  num_loops += borders.num_loops();
  for (std::size_t r = 0; r < regions.size(); ++r) {
    if (regions[r].tree != tree_index) continue;
    const auto number = static_cast<std::int32_t>(r) + 1;
    const Triangles& region = side.sets[static_cast<std::size_t>(regions[r].node)];
    std::vector<std::uint8_t> inside(of.triangles.size(), 0);
    for (const int t : region) inside[static_cast<std::size_t>(t)] = 1;
    const std::string broken = check_border_loops(of.positions, of.triangles, of.excluded, inside, borders, number);
    if (!broken.empty()) return broken;
    std::vector<std::vector<int>> found;
    for (std::size_t l = 0; l < borders.num_loops(); ++l)
      if (borders.owner_of_loop[l] == number)
        found.emplace_back(borders.half_edges.begin() + borders.first_edge_of_loop[l],
                           borders.half_edges.begin() + borders.first_edge_of_loop[l + 1]);
    std::sort(found.begin(), found.end());
    if (found != oracle::border_loops(side.surface, region).loops) return "other border loops";
  }
  return "";
}

/// The tree of shapes against saturation; its selection and borders. A handle must be refused.
std::string broken_shapes(const Case& of, std::span<const std::int32_t> twins, std::span<const double> areas,
                          std::size_t& num_loops) {
  const std::vector<std::int32_t> of_vertex = levels_of_vertices(of.values, of.levels, 1);
  const std::int32_t root = of.delta == 4 ? 0 : -1;
  const oracle::ShapesCase shapes{
      of.positions, of.triangles, of.excluded, twins, of_vertex, areas, static_cast<int>(of.levels.size()), root};
  const SurfaceView surface{of.positions, of.triangles, twins};
  Side side;
  const bool has_no_handle = oracle::has_no_handle(shapes);
  try {
    side.tree = build_tree_of_shapes(surface, areas, of_vertex, of.levels, of.excluded, root);
  } catch (const StageError&) {
    return has_no_handle ? "a surface without handles was refused" : "";
  }
  if (!has_no_handle) return "a surface with a handle was taken";
  const oracle::ShapesCheck check = oracle::check_shapes(shapes, side.tree);
  if (!check.broken.empty()) return check.broken;
  finish(of, twins, areas, check.lines, *std::max_element(check.lines.begin(), check.lines.end()), side);
  for (const std::string& broken :
       {broken_tree(side, change_of_nodes(side.tree, of.delta)), broken_selection(of, side)})
    if (!broken.empty()) return broken;
  const std::vector trees{side.tree};
  const std::vector<SelectedNode> regions = order_regions(trees, std::array{side.selected});
  return broken_borders(of, twins, side, regions, 0, label_triangles(trees, regions), num_loops);
}

struct Results {
  std::string broken;
  MeshLawsCase counts;
};

Results check(std::span<const std::uint8_t> bytes) {
  const Case of = read_case(bytes);
  Results results;
  results.counts.num_triangles = of.triangles.size();
  std::vector<std::int32_t> twins = twin_half_edges(of.triangles, of.positions.size());
  cut_out_triangles(twins, of.excluded);
  std::vector<double> areas = triangle_areas(of.positions, of.triangles);
  for (double& area : areas) area = 0.5 * std::round(2 * area);

  std::vector<Side> sides;
  for (const Polarity polarity : {Polarity::kUpper, Polarity::kLower}) {
    sides.push_back(make_side(of, twins, areas, polarity));
    const Side& side = sides.back();
    const char* name = polarity == Polarity::kUpper ? "upper: " : "lower: ";
    for (const std::string& broken :
         {broken_tree(side, change_of_nodes(side.tree, of.delta)), broken_selection(of, side), broken_edits(of, side)})
      if (!broken.empty()) {
        results.broken = name + broken;
        return results;
      }
    results.counts.num_nodes += side.tree.num_nodes();
  }

  std::vector<ComponentTree> trees;
  std::vector<std::vector<std::int32_t>> selected;
  std::vector<Triangles> regions_of_side[2];
  for (std::size_t i = 0; i < 2; ++i) {
    trees.push_back(sides[i].tree);
    selected.push_back(sides[i].selected);
    for (const std::int32_t node : sides[i].selected)
      regions_of_side[i].push_back(sides[i].sets[static_cast<std::size_t>(node)]);
  }
  const std::vector<SelectedNode> regions = order_regions(trees, selected);
  const std::vector<std::int32_t> labels = label_triangles(trees, regions);
  const std::vector<int> expected = oracle::region_numbers(sides[0].surface, regions_of_side[0], regions_of_side[1]);
  if (!std::equal(labels.begin(), labels.end(), expected.begin(), expected.end())) {
    results.broken = "other labels";
    return results;
  }
  results.counts.num_regions = regions.size();

  for (std::size_t i = 0; i < 2; ++i) {
    results.broken =
        broken_borders(of, twins, sides[i], regions, static_cast<std::int32_t>(i), labels, results.counts.num_loops);
    if (!results.broken.empty()) return results;
  }
  if (of.triangles.empty()) return results;
  results.broken = broken_shapes(of, twins, areas, results.counts.num_loops);
  if (!results.broken.empty()) results.broken = "shapes: " + results.broken;
  return results;
}

}  // namespace

std::string broken_law(std::span<const std::uint8_t> bytes) {
  return check(bytes).broken;
}

MeshLawsCase describe_case(std::span<const std::uint8_t> bytes) {
  return check(bytes).counts;
}

}  // namespace meshmser::testing
