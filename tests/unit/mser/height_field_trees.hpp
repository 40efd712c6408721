#pragma once
/// Component trees of scalars on a height field.

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "pipeline/artifacts/level_set_trees.hpp"
#include "stages/tree/component_tree.hpp"
#include "stages/tree/levels.hpp"
#include "tests/unit/mser/height_field.hpp"

namespace meshmser {

/// The upper tree of `values` (#V), and the lower one where `both`; below `levels` (ascending) is one more.
inline LevelSetTrees make_trees(const HeightField& field, std::vector<double> values, std::vector<double> levels,
                                bool both) {
  LevelSetTrees trees;
  trees.scalar = "test";
  trees.values = std::move(values);
  for (const Polarity polarity : {Polarity::kUpper, Polarity::kLower}) {
    const bool lower = polarity == Polarity::kLower;
    if (lower && !both) break;
    std::vector<double> signed_levels = levels;
    if (lower) {
      std::reverse(signed_levels.begin(), signed_levels.end());
      for (double& level : signed_levels) level = -level;
    }
    signed_levels.insert(signed_levels.begin(), -std::numeric_limits<double>::infinity());
    const auto of_vertex = levels_of_vertices(trees.values, signed_levels, lower ? -1 : 1);
    ComponentTree tree =
        build_component_tree(field.twins, field.areas, levels_of_triangles(field.triangles, of_vertex, {}),
                             static_cast<std::int32_t>(signed_levels.size()));
    tree.polarity = polarity;
    tree.levels = signed_levels;
    trees.trees.push_back(std::move(tree));
  }
  return trees;
}

}  // namespace meshmser
