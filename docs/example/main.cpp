/// Regions and borders of a scalar on a mesh, on plain arrays: no configuration, no cache. The mesh is a flat square of
/// 24 x 24 squares; the scalar is 0 but for a terrace of 0.5 with a step of 1 on it, and a terrace of 1 at the rim.

#include <array>
#include <cstdint>
#include <cstdio>
#include <vector>

#include "stages/borders/borders.hpp"
#include "stages/common/adjacency.hpp"
#include "stages/mser/label_triangles.hpp"
#include "stages/mser/select_mser.hpp"
#include "stages/mser/stability.hpp"
#include "stages/tree/component_tree.hpp"
#include "stages/tree/levels.hpp"

int main() {
  std::vector<Eigen::Vector3d> positions;
  std::vector<double> values;
  std::vector<std::array<std::int32_t, 3>> triangles;
  constexpr int kSide = 24;
  for (int y = 0; y <= kSide; ++y)
    for (int x = 0; x <= kSide; ++x) {
      const int corner = static_cast<int>(positions.size()), above = corner + kSide + 1;
      positions.emplace_back(x, y, 0);
      const bool terrace = x >= 3 && x <= 13 && y >= 3 && y <= 13, step = x >= 6 && x <= 10 && y >= 6 && y <= 10;
      values.push_back(step || (x >= 18 && y >= 4 && y <= 12) ? 1 : terrace ? 0.5 : 0);
      if (x == kSide || y == kSide) continue;
      triangles.push_back({corner, corner + 1, above + 1});
      triangles.push_back({corner, above + 1, above});
    }

  using namespace meshmser;
  const std::vector<std::int32_t> twins = twin_half_edges(triangles, positions.size());
  const std::vector<double> areas = triangle_areas(positions, triangles);
  const std::vector<double> levels = make_levels(values, {}, {.count = 33, .low_value = 0, .high_value = 1}, false);
  const auto level_of_triangle = levels_of_triangles(triangles, levels_of_vertices(values, levels, 1), {});
  std::vector<ComponentTree> trees = {
      build_component_tree(twins, areas, level_of_triangle, static_cast<std::int32_t>(levels.size()))};
  trees[0].levels = levels;
  const std::vector<std::vector<std::int32_t>> selected = {select_mser(trees[0], {.delta = 3})};
  const std::vector<SelectedNode> regions = order_regions(trees, selected);
  const std::vector<std::int32_t> label_of_triangle = label_triangles(trees, regions);

  std::vector<std::int32_t> number_of_node(trees[0].num_nodes(), 0);
  for (std::size_t i = 0; i < regions.size(); ++i) {
    number_of_node[static_cast<std::size_t>(regions[i].node)] = static_cast<std::int32_t>(i + 1);
    std::printf("region %zu: area %g, levels %d to %d\n", i + 1, area_of_node(trees[0], regions[i].node),
                trees[0].lo(regions[i].node), trees[0].hi_of_node[static_cast<std::size_t>(regions[i].node)]);
  }
  const BorderLoops borders =
      extract_borders({positions, triangles, twins}, trees[0], number_of_node, label_of_triangle);
  for (std::size_t loop = 0; loop < borders.num_loops(); ++loop)
    std::printf("border of region %d: %g along a level, %g along the rim\n", borders.owner_of_loop[loop],
                borders.level_length_of_loop[loop], borders.hole_length_of_loop[loop]);
}
