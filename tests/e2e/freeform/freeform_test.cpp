/// freeform.yaml on a figurine: its parts apart, its face and its slab whole.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <set>

#include "pipeline/formats/ply.hpp"

namespace meshmser {
namespace {

/// The label that most points within a millimetre of (x, y) have.
int label_at(const Geometry& points, double x, double y) {
  const auto label = std::find_if(points.properties.begin(), points.properties.end(),
                                  [](const Property& property) { return property.name == "label"; });
  std::map<double, int> counts;
  for (std::size_t i = 0; i < points.positions.size(); ++i)
    if ((points.positions[i].head<2>() - Eigen::Vector2d(x, y)).norm() < 1) ++counts[label->values[i]];
  const auto most =
      std::max_element(counts.begin(), counts.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  return most == counts.end() ? -1 : static_cast<int>(most->first);
}

TEST(Freeform, PartsAFigurineAtItsNeckShouldersAndHips) {
  const auto folder = std::filesystem::temp_directory_path() / fmt::format("meshmser-freeform-{}", getpid());
  std::filesystem::create_directories(folder);
  const std::string f = folder.string();
  ASSERT_EQ(std::system(fmt::format("'{}' figurine '{}/figurine.ply' --points 80000 --set height=50 >'{}/log'",
                                    MESHMSER_SCAN, f, f)
                            .c_str()),
            0);
  ASSERT_EQ(std::system(fmt::format("'{}' run '{}/configs/freeform.yaml' -q --out '{}/out' --cache '{}/cache' --until "
                                    "export --set load.path='{}/figurine.ply' --set export.pictures=false "
                                    ">'{}/log' 2>&1",
                                    MESHMSER_PROGRAM, MESHMSER_SOURCE_DIR, f, f, f, f)
                            .c_str()),
            0);
  const Geometry points = read_ply(read_file_bytes(folder / "out" / "points.ply"));
  const int head = label_at(points, 0, 20), trunk = label_at(points, 0, 6), slab = label_at(points, -17, -20);
  const int left_leg = label_at(points, -5, -13.5), right_leg = label_at(points, 5, -13.5);
  const int raised_arm = label_at(points, 10.7, 12.5);
  EXPECT_EQ((std::set<int>{-1, 0, head, trunk, slab, left_leg, right_leg, raised_arm}.size()), 8U);
  EXPECT_EQ(label_at(points, 0, 18), head) << "its nose";
  EXPECT_EQ(label_at(points, 11.5, 18.5), raised_arm) << "below and above the elbow";
  EXPECT_EQ(label_at(points, 17, 24), slab);
  EXPECT_EQ(label_at(points, 0, -20), slab) << "between the legs";
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace meshmser
