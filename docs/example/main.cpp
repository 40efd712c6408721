/// Regions and borders of a scalar on plain arrays: a flat square of 24 x 24 squares, 0 but for a terrace of 0.5 with a
/// step of 1 on it, and a terrace of 1 at the rim.
#include <cstdio>

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
  for (int y = 0; y <= 24; ++y)
    for (int x = 0; x <= 24; ++x) {
      const int corner = 25 * y + x, above = corner + 25;
      positions.emplace_back(x, y, 0);
      const bool terrace = x >= 3 && x <= 13 && y >= 3 && y <= 13, step = x >= 6 && x <= 10 && y >= 6 && y <= 10;
      values.push_back(step || (x >= 18 && y >= 4 && y <= 12) ? 1 : terrace ? 0.5 : 0);
      if (x == 24 || y == 24) continue;
      triangles.insert(triangles.end(), {{corner, corner + 1, above + 1}, {corner, above + 1, above}});
    }
  using namespace meshmser;
  const auto twins = twin_half_edges(triangles, positions.size());
  const auto levels = make_levels(values, {}, {.count = 33, .low_value = 0, .high_value = 1}, false);
  const auto level_of_triangle = levels_of_triangles(triangles, levels_of_vertices(values, levels, 1), {});
  const std::vector trees{build_component_tree(twins, triangle_areas(positions, triangles), level_of_triangle, 33)};
  const auto regions = order_regions(trees, std::array{select_mser(trees[0], {.delta = 3})});
  const auto labels = label_triangles(trees, regions);
  const auto borders =
      extract_borders({positions, triangles, twins}, trees[0], number_of_nodes(trees[0], regions), labels);
  for (std::size_t i = 0; i < borders.num_loops(); ++i)
    std::printf("region %d of area %g: border of %g along a level, %g along the rim\n", borders.owner_of_loop[i],
                area_of_node(trees[0], regions[borders.owner_of_loop[i] - 1].node), borders.level_length_of_loop[i],
                borders.hole_length_of_loop[i]);
}
