/// freeform.yaml on a figurine: its parts apart, its face and its slab whole.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <set>

#include "pipeline/formats/ply.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_files.hpp"

namespace meshmser {
namespace {

TEST(Freeform, PartsAFigurineAtItsNeckShouldersAndHips) {
  const TemporaryFolder folder;
  const std::string f = folder.path().string();
  const std::string scan =
      fmt::format("'{}' figurine '{}/figurine.ply' --points 80000 --set height=50 >'{}/log'", MESHMSER_SCAN, f, f);
  ASSERT_EQ(std::system(scan.c_str()), 0);
  const Finished run = run_program(
      {"run", MESHMSER_SOURCE_DIR "/configs/freeform.yaml", "-q", "--out", f + "/out", "--cache", f + "/cache",
       "--until", "export", "--set", "load.path=" + f + "/figurine.ply", "--set", "export.pictures=false"},
      f);
  ASSERT_EQ(run.exit_code, 0) << run.err;

  const Geometry points = read_ply(read_file_bytes(folder.path() / "out" / "points.ply"));
  const auto label = std::find_if(points.properties.begin(), points.properties.end(),
                                  [](const Property& property) { return property.name == "label"; });
  ASSERT_NE(label, points.properties.end());
  // The label that most points within a millimetre of (x, y) have.
  const auto label_at = [&](double x, double y) {
    std::map<double, int> counts;
    for (std::size_t i = 0; i < points.positions.size(); ++i)
      if ((points.positions[i].head<2>() - Eigen::Vector2d(x, y)).norm() < 1) ++counts[label->values[i]];
    const auto most = std::max_element(counts.begin(), counts.end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
    return most == counts.end() ? -1 : static_cast<int>(most->first);
  };
  const int head = label_at(0, 20), trunk = label_at(0, 6), slab = label_at(-17, -20);
  const int left_leg = label_at(-5, -13.5), right_leg = label_at(5, -13.5), raised_arm = label_at(10.7, 12.5);
  EXPECT_EQ((std::set<int>{-1, 0, head, trunk, slab, left_leg, right_leg, raised_arm}.size()), 8U);
  EXPECT_EQ(label_at(0, 18), head) << "its nose";
  EXPECT_EQ(label_at(11.5, 18.5), raised_arm) << "below and above the elbow";
  EXPECT_EQ(label_at(17, 24), slab);
  EXPECT_EQ(label_at(0, -20), slab) << "between the legs";
}

}  // namespace
}  // namespace meshmser
