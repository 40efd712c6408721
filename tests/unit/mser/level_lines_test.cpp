#include "stages/mser/level_lines.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "stages/tree/component_tree.hpp"
#include "stages/tree/levels.hpp"
#include "tests/unit/mser/hand_made_tree.hpp"
#include "tests/unit/mser/height_field.hpp"

namespace meshmser {
namespace {

using ::testing::ElementsAre;

ComponentTree make_upper_tree(const HeightField& field, std::span<const double> values, std::vector<double> levels) {
  levels.insert(levels.begin(), -std::numeric_limits<double>::infinity());
  const auto of_vertex = levels_of_vertices(values, levels, 1);
  ComponentTree tree =
      build_component_tree(field.twins, field.areas, levels_of_triangles(field.triangles, of_vertex, {}),
                           static_cast<std::int32_t>(levels.size()));
  tree.levels = levels;
  return tree;
}

// A terrace of 10 x 10 on one of 20 x 20 squares; the mesh's own rim is no level line.
TEST(LevelLines, AreAsLongAsTheirLevelEdges) {
  const HeightField field = make_height_field(40, 40);
  const auto values = field.values([](const Eigen::Vector3d& p) {
    const double from_centre = std::max(std::abs(p.x() - 20), std::abs(p.y() - 20));
    return from_centre <= 5 ? 6.0 : from_centre <= 10 ? 3.0 : 0.0;
  });
  const ComponentTree tree = make_upper_tree(field, values, {1, 2, 4, 5});
  const std::vector<double> lengths = level_line_lengths(field.view(), tree);
  ASSERT_EQ(tree.num_nodes(), 3U);
  EXPECT_THAT(lengths, ElementsAre(40, 80, 0));
  EXPECT_THAT(select_length(tree, lengths, 40), ElementsAre(0, 1));
  EXPECT_THAT(select_length(tree, lengths, 41), ElementsAre(1));
  EXPECT_THAT(select_level(tree, 1.5), ElementsAre(1));
  EXPECT_THAT(select_level(tree, 4), ElementsAre(0));
  EXPECT_THAT(select_level(tree, 7), ElementsAre(0)) << "above the highest level that one counts";
  EXPECT_THAT(select_level(tree, 0), ElementsAre()) << "a root has no line";
}

TEST(SelectLevel, OfTheLowerTreeTakesTheValueOfS) {
  ComponentTree tree = make_tree({{1, 3, 1}, {-1, 1, 1}}, 3);
  tree.polarity = Polarity::kLower;
  EXPECT_THAT(select_level(tree, -1.5), ElementsAre(0));
  EXPECT_THAT(select_level(tree, 1.5), ElementsAre());
}

}  // namespace
}  // namespace meshmser
