#include "pipeline/formats/xyz.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/temporary_files.hpp"

namespace meshmser {
namespace {

Geometry read_text(const std::string& text, const XyzOptions& options = {}, const std::string& name = "a.xyz") {
  TemporaryFolder folder;
  return read_xyz(read_file_bytes(folder.write(name, text)), options);
}

std::vector<std::string> names_of(const Geometry& g) {
  std::vector<std::string> names;
  for (const Property& property : g.properties) names.push_back(property.name);
  return names;
}

TEST(Xyz, TheSamePointsHoweverTheyAreWritten) {
  const std::vector<Eigen::Vector3d> expected{{1, 2, 3}, {-4.5, 0.5, 6e2}, {7, 8, 9}};
  const std::vector<std::string> texts{
      "1 2 3\n-4.5 .5 6e2\n7 8 9\n",
      "1 2 3\r\n-4.5 .5 6E+2\r\n7 8 9",
      "1 2 3\r-4.5 .5 6e2\r7 8 9\r",
      "\xEF\xBB\xBF"
      "1\t2\t3\n -4.5 \t+.5  600 \n\n7 8 9\n",
      "x,y,z\n1,2,3\n-4.5,0.5,600\n7,8,9\n",
      "\"X\" ; \"Y\" ; \"Z\"\n1;2;3\n-4.5; 0.5 ;600\n7;8;9\n",
      "# a comment\n1, 2, 3,\n-4.5, 0.5, 600,\n// another\n7, 8, 9,\n",
      "3\n1 2 3\n-4.5 0.5 600\n7 8 9\n",
      "z y x\n3 2 1\n600 .5 -4.5\n9 8 7\n",
      "//Z,Y,X\n3,2,1\n600,.5,-4.5\n9,8,7\n",
  };
  for (const std::string& text : texts) EXPECT_EQ(read_text(text).positions, expected) << text;
}

TEST(Xyz, DecimalCommaByOption) {
  XyzOptions options;
  options.decimal_comma = true;
  const std::vector<Eigen::Vector3d> expected{{1.5, 2, -3.25}, {4, 5, 6}};
  EXPECT_EQ(read_text("1,5;2;-3,25\n4;5;6\n", options).positions, expected);
  EXPECT_EQ(read_text("x y z\n1,5 2,0 -3,25\n4 5 6,0\n", options).positions, expected);
}

TEST(Xyz, FurtherColumnsAreProperties) {
  const Geometry named = read_text("x,y,z,Intensity,red\n1,2,3,0.5,255\n4,5,6,0.25,0\n");
  EXPECT_EQ(names_of(named), (std::vector<std::string>{"Intensity", "red"}));
  EXPECT_EQ(named.properties[0].values, (std::vector<double>{0.5, 0.25}));
  EXPECT_EQ(named.properties[1].type, ValueType::kUint8);
  EXPECT_EQ(names_of(read_text("1 2 3 4 5\n1 2 3 4 5\n")), (std::vector<std::string>{"column4", "column5"}));
  EXPECT_EQ(names_of(read_text("1\n1 2 3 4 5 6 7\n", {}, "a.pts")),
            (std::vector<std::string>{"intensity", "red", "green", "blue"}));
  XyzOptions options;
  options.columns = {"_", "z", "y", "x", "quality"};
  const Geometry chosen = read_text("9 3 2 1 8\n9 6 5 4 7\n", options);
  EXPECT_EQ(chosen.positions[1], Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(names_of(chosen), std::vector<std::string>{"quality"});
}

TEST(Xyz, PtsMayHoldSeveralClouds) {
  const Geometry g = read_text("2\n1 2 3\n4 5 6\n1\n7 8 9\n", {}, "a.pts");
  EXPECT_EQ(g.num_vertices(), 3u);
}

TEST(Xyz, BadLinesAreSkippedByOptionAndCounted) {
  XyzOptions options;
  options.skip_bad_lines = true;
  const Geometry g = read_text("1 2 3\n4 5\n4 x 6\n7 8 9\n7 8 9 10\n1 2 3\n", options);
  EXPECT_EQ(g.num_vertices(), 3u);
  EXPECT_EQ(g.num_skipped_lines, 3);
}

TEST(Xyz, NumbersOfEveryKind) {
  const Geometry g = read_text("nan -inf 1.#QNAN\n1e400 -1e-400 1e+0\nNaN Infinity -1.#INF\n");
  EXPECT_TRUE(std::isnan(g.positions[0].x()) && std::isinf(g.positions[0].y()) && std::isnan(g.positions[0].z()));
  EXPECT_TRUE(std::isinf(g.positions[1].x()));
  EXPECT_EQ(g.positions[1].y(), 0);
  EXPECT_EQ(g.positions[1].z(), 1);
  EXPECT_TRUE(std::isnan(g.positions[2].x()) && std::isinf(g.positions[2].y()) && g.positions[2].z() < 0);
}

}  // namespace
}  // namespace meshmser
