#include "stages/mser/fill_cut_triangles.hpp"

#include <gtest/gtest.h>

#include "stages/mser/grow.hpp"
#include "tests/unit/mser/height_field.hpp"

namespace meshmser {
namespace {

TEST(FillCutTriangles, TakesThoseWhoseMeanReachesTheLevel) {
  const HeightField field = make_height_field(12, 8);
  // Between x = 5 and 6 the means are 5 1/3 and 5 2/3: of level 5.2 all join, of 5.5 every other one, of 5.8 none.
  for (const double level : {5.2, 5.5, 5.8})
    for (const bool upper : {true, false}) {
      const double sign = upper ? 1 : -1;
      const std::vector<double> means =
          triangle_means(field.view(), field.values([&](const Eigen::Vector3d& p) { return sign * p.x(); }), {});
      const std::vector<std::int32_t> labels =
          field.numbers([](const Eigen::Vector3d& c) { return c.x() > 6 ? 1 : 0; });
      std::vector<std::uint8_t> excluded(labels.size(), 0);
      for (std::size_t t = 0; t < labels.size(); ++t) excluded[t] = field.centroid(t).y() < 2;
      const std::vector<LabelLevel> levels = {{}, {sign * level, upper}};
      const std::vector<std::int32_t> filled = fill_cut_triangles(field.view(), labels, levels, means, excluded);
      for (std::size_t t = 0; t < labels.size(); ++t) {
        const Eigen::Vector3d c = field.centroid(t);
        EXPECT_EQ(filled[t], c.x() > 6 || (c.x() >= level && c.y() > 2) ? 1 : 0) << c.transpose() << " at " << level;
      }
    }
}

}  // namespace
}  // namespace meshmser
