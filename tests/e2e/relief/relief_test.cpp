/// relief.yaml on a stamped sherd whose outlines are known.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "data/scanner/shapes.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_files.hpp"

namespace meshmser {
namespace {

using Points = std::vector<Eigen::Vector2d>;

double share_near(const Points& points, const Points& targets, double distance) {
  std::size_t near = 0;
  for (const auto& p : points)
    for (const auto& t : targets)
      if ((p - t).squaredNorm() < distance * distance) {
        ++near;
        break;
      }
  return points.empty() ? 0 : static_cast<double>(near) / static_cast<double>(points.size());
}

TEST(Relief, FindsTheRidgesOfAStampedSherd) {
  constexpr double kSize = 30, kInner = 8.5;  // mm; the rounded, broken edge begins farther out
  const TemporaryFolder folder;
  const std::string f = folder.path().string();
  const std::string scan = fmt::format("'{}' sherd '{}/sherd.xyz' --set size={} >'{}/log'", MESHMSER_SCAN, f, kSize, f);
  ASSERT_EQ(std::system(scan.c_str()), 0);
  const Finished run =
      run_program({"run", MESHMSER_SOURCE_DIR "/configs/relief.yaml", "-q", "--out", f + "/out", "--cache",
                   f + "/cache", "--until", "export", "--set", "load.path=" + f + "/sherd.xyz", "--set",
                   "tree.polarity=upper", "--set", "export.pictures=false"},
                  f);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  Points truth, found;
  for (const scanner::EdgeSample& sample : scanner::true_edges(scanner::make_shape("sherd", {{"size", kSize}}), 0.1))
    if (sample.position.head<2>().norm() < kInner) truth.push_back(sample.position.head<2>());
  std::ifstream file(folder.path() / "out" / "label_borders.csv");
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    double x = 0, y = 0;
    ASSERT_EQ(std::sscanf(line.c_str(), "%*d,%*d,%*d,%lf,%lf", &x, &y), 2) << line;
    if (std::hypot(x, y) < kInner) found.emplace_back(x, y);
  }
  EXPECT_GT(share_near(truth, found, 0.4), 0.9);
  EXPECT_GT(share_near(found, truth, 0.4), 0.9);
}

}  // namespace
}  // namespace meshmser
