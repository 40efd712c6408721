/// relief.yaml on a stamped sherd whose outlines are known.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "data/scanner/shapes.hpp"

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
  const auto folder = std::filesystem::temp_directory_path() / fmt::format("meshmser-relief-{}", getpid());
  std::filesystem::create_directories(folder);
  const std::string f = folder.string();
  ASSERT_EQ(
      std::system(fmt::format("'{}' sherd '{}/sherd.xyz' --set size={} >'{}/log'", MESHMSER_SCAN, f, kSize, f).c_str()),
      0);
  ASSERT_EQ(
      std::system(fmt::format("'{}' run '{}/configs/relief.yaml' -q --out '{}/out' --cache '{}/cache' --until export "
                              "--set load.path='{}/sherd.xyz' --set tree.polarity=upper --set export.pictures=false "
                              ">'{}/log' 2>&1",
                              MESHMSER_PROGRAM, MESHMSER_SOURCE_DIR, f, f, f, f)
                      .c_str()),
      0);
  Points truth, found;
  for (const scanner::EdgeSample& sample : scanner::true_edges(scanner::make_shape("sherd", {{"size", kSize}}), 0.1))
    if (sample.position.head<2>().norm() < kInner) truth.push_back(sample.position.head<2>());
  std::ifstream file(folder / "out" / "label_borders.csv");
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    double x = 0, y = 0;
    ASSERT_EQ(std::sscanf(line.c_str(), "%*d,%*d,%*d,%lf,%lf", &x, &y), 2) << line;
    if (std::hypot(x, y) < kInner) found.emplace_back(x, y);
  }
  EXPECT_GT(share_near(truth, found, 0.4), 0.9);
  EXPECT_GT(share_near(found, truth, 0.4), 0.9);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace meshmser
