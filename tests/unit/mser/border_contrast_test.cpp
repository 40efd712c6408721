#include "stages/mser/border_contrast.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <random>
#include <set>
#include <utility>

#include "stages/common/surface.hpp"
#include "stages/mser/grow.hpp"
#include "tests/unit/mser/height_field_trees.hpp"

namespace meshmser {
namespace {

/// The definition word by word: from every level edge outward, first come first served.
double literal_contrast(const HeightField& field, const ComponentTree& tree, std::int32_t node,
                        const std::vector<double>& triangle_values, const std::vector<double>& areas, double band) {
  const auto corner = [&](std::int32_t t, std::int32_t k) {
    return field.positions[static_cast<std::size_t>(
        field.triangles[static_cast<std::size_t>(t)][static_cast<std::size_t>(k % 3)])];
  };
  const auto centroid = [&](std::int32_t t) {
    return Eigen::Vector3d((corner(t, 0) + corner(t, 1) + corner(t, 2)) / 3);
  };
  const auto is_inside = [&](std::int32_t t) {
    std::int32_t of = tree.node_of_triangle[static_cast<std::size_t>(t)];
    while (of >= 0 && of != node) of = tree.parent_of_node[static_cast<std::size_t>(of)];
    return of == node;
  };
  std::deque<std::pair<std::int32_t, Eigen::Vector3d>> front;
  std::set<std::int32_t> met;
  const auto reach = [&](std::int32_t t, const Eigen::Vector3d& from) {
    if (met.insert(t).second) front.emplace_back(t, from);
  };
  for (std::int32_t h = 0; h < static_cast<std::int32_t>(field.twins.size()); ++h) {
    const std::int32_t twin = field.twins[static_cast<std::size_t>(h)];
    if (twin < 0 || !is_inside(h / 3) || is_inside(twin / 3)) continue;
    const Eigen::Vector3d middle = (centroid(h / 3) + centroid(twin / 3)) / 2;
    reach(h / 3, middle);
    reach(twin / 3, middle);
  }
  double sum[2] = {0, 0}, weight[2] = {0, 0};
  std::size_t at_border = front.size();
  while (!front.empty()) {
    const auto [t, from] = front.front();
    front.pop_front();
    if (at_border > 0)
      --at_border;
    else if ((centroid(t) - from).norm() > band)
      continue;
    sum[is_inside(t)] += areas[static_cast<std::size_t>(t)] * triangle_values[static_cast<std::size_t>(t)];
    weight[is_inside(t)] += areas[static_cast<std::size_t>(t)];
    for (std::int32_t h = 3 * t; h < 3 * t + 3; ++h) {
      const std::int32_t twin = field.twins[static_cast<std::size_t>(h)];
      if (twin >= 0) reach(twin / 3, from);
    }
  }
  return weight[0] > 0 && weight[1] > 0 ? sum[1] / weight[1] - sum[0] / weight[0] : 0;
}

TEST(BorderContrast, IsTheLiteralOneNearAndFarFromTheOrigin) {
  std::mt19937 random(7);
  for (const double offset : {0.0, 1e6}) {
    for (int repeat = 0; repeat < 4; ++repeat) {
      HeightField field = make_height_field(24, 16);
      std::uniform_real_distribution<double> some(-0.2, 0.2);
      const std::vector<double> values = field.values([&](const Eigen::Vector3d& p) {
        return offset + 3 * std::sin(0.5 * p.x() + repeat) * std::cos(0.4 * p.y()) + some(random);
      });
      // Places uneven, so that no centroid lies on the band's end.
      for (Eigen::Vector3d& p : field.positions)
        p += Eigen::Vector3d(offset + some(random), -offset + some(random), some(random));
      std::vector<double> levels;
      for (int k = -6; k <= 6; ++k) levels.push_back(offset + 0.5 * k);
      const ComponentTree tree = make_trees(field, values, levels, false).trees.front();
      const std::vector<double> areas = triangle_areas(field.positions, field.triangles),
                                triangle_values = triangle_means(field.view(), values);
      std::vector<std::int32_t> selected;
      for (std::int32_t node = 0; node < static_cast<std::int32_t>(tree.num_nodes()); node += 2)
        selected.push_back(node);
      ASSERT_GT(selected.size(), 20U);
      const std::vector<double> contrasts = border_contrasts(field.view(), tree, selected, triangle_values, areas, 2.3);
      for (std::size_t i = 0; i < selected.size(); ++i)
        EXPECT_NEAR(contrasts[i], literal_contrast(field, tree, selected[i], triangle_values, areas, 2.3), 1e-5);
    }
  }
}

TEST(BorderContrast, DoesNotTakeARegionForThatOf255RegionsBefore) {
  // A peak near the border of a plateau whose other peaks are far from both: what the walk from the first peak has met
  // nobody meets again until that from the plateau's border.
  HeightField field = make_height_field(80, 50);
  const std::vector<double> values = field.values([](const Eigen::Vector3d& p) {
    if (p.x() < 4) return 0.1;
    const auto x = static_cast<int>(p.x()), y = static_cast<int>(p.y());
    return (x / 2 == 3 && y / 2 == 10) || (x >= 16 && x % 3 < 2 && y % 3 < 2) ? 2.1 : 1.1;
  });
  const ComponentTree tree = make_trees(field, values, {1.0, 1.2}, true).trees.front();
  const std::vector<double> areas = triangle_areas(field.positions, field.triangles),
                            triangle_values = triangle_means(field.view(), values);
  std::vector<std::int32_t> peaks;
  std::int32_t near = -1;
  for (std::int32_t node = 0; node < static_cast<std::int32_t>(tree.num_nodes()); ++node) {
    if (tree.first_node_of_subtree[static_cast<std::size_t>(node)] != node) continue;
    const auto at = std::find(tree.node_of_triangle.begin(), tree.node_of_triangle.end(), node);
    if (field.centroid(static_cast<std::size_t>(at - tree.node_of_triangle.begin())).x() < 10)
      near = node;
    else
      peaks.push_back(node);
  }
  ASSERT_GE(near, 0);
  const std::int32_t plateau = tree.parent_of_node[static_cast<std::size_t>(near)];
  std::vector<std::int32_t> selected{near};
  for (const std::int32_t node : peaks)
    if (node > near && selected.size() < 255) selected.push_back(node);
  selected.push_back(plateau);
  ASSERT_EQ(selected.size(), 256U);
  ASSERT_TRUE(std::is_sorted(selected.begin(), selected.end()));
  Execution one_after_another;
  one_after_another.threads = 1;
  const std::vector<double> contrasts =
      border_contrasts(field.view(), tree, selected, triangle_values, areas, 2.3, one_after_another);
  for (const std::size_t i : {std::size_t{0}, std::size_t{255}})
    EXPECT_NEAR(contrasts[i], literal_contrast(field, tree, selected[i], triangle_values, areas, 2.3), 1e-6);
}

TEST(BorderContrast, DoesNotMindTrianglesWithoutAValueThatAreCutOut) {
  HeightField field = make_height_field(6, 2);
  const std::vector<double> values = field.values([](const Eigen::Vector3d& p) { return p.x() < 3.5 ? 0.0 : 2.0; });
  std::vector<std::uint8_t> excluded(field.triangles.size(), 0);
  excluded[0] = 1;
  cut_out_triangles(field.twins, excluded);
  const ComponentTree tree = make_trees(field, values, {1.0}, false).trees.front();
  std::vector<double> triangle_values = triangle_means(field.view(), values);
  triangle_values[0] = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::int32_t> top{1};  // 0 is the triangle that is cut out, a component of its own
  const double contrast = border_contrasts(field.view(), tree, top, triangle_values, field.areas, 0.1)[0];
  EXPECT_GT(contrast, 0.6);
  EXPECT_LT(contrast, 1.4);
}

TEST(BorderContrast, IsZeroWithoutALevelBorderAndNothingWithoutNodes) {
  const HeightField field = make_height_field(3, 3);
  const std::vector<double> values(field.positions.size(), 1.0),
      areas = triangle_areas(field.positions, field.triangles);
  const ComponentTree tree = make_trees(field, values, {0.0}, false).trees.front();
  const std::vector<double> triangle_values(field.triangles.size(), 1.0);
  EXPECT_TRUE(border_contrasts(field.view(), tree, {}, triangle_values, areas, 1).empty());
  const std::vector<std::int32_t> root{0};
  EXPECT_EQ(border_contrasts(field.view(), tree, root, triangle_values, areas, 1), std::vector<double>{0});
}

}  // namespace
}  // namespace meshmser
