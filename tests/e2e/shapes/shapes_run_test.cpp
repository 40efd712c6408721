/// tree.polarity: shapes from the program: a bump that a hole cuts, and a dent with a bump in it, of one run.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>

#include "tests/support/run_program.hpp"
#include "tests/support/temporary_files.hpp"

namespace meshmser {
namespace {

std::string read(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

/// The rows of a table, each by its column names.
std::vector<std::map<std::string, std::string>> rows_of(const std::filesystem::path& path) {
  std::istringstream file(read(path));
  std::vector<std::string> names;
  std::vector<std::map<std::string, std::string>> rows;
  for (std::string line; std::getline(file, line);) {
    std::istringstream cells(line);
    if (rows.empty() && names.empty()) {
      for (std::string cell; std::getline(cells, cell, ',');) names.push_back(cell);
      continue;
    }
    std::size_t column = 0;
    rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) rows.back()[names.at(column++)] = cell;
  }
  return rows;
}

bool in_hole(double x, double y) {
  return x > 8 && x < 13 && y > 17 && y < 24;
}

double step(double inside) {
  return 0.5 * (1 + std::tanh(2 * inside));
}

/// A sheet of 40 x 30 squares with one hole: a bump of height 2 about (10, 15), and a dent of depth 2 about (28, 15)
/// with a bump of height 1 in its middle.
std::string sheet() {
  std::string vertices, faces;
  int num_faces = 0;
  for (int y = 0; y <= 30; ++y)
    for (int x = 0; x <= 40; ++x) {
      const double bump = std::hypot(x - 10, y - 15), dent = std::hypot(x - 28, y - 15);
      vertices += fmt::format("{} {} 0 {}\n", x, y, 2 * step(5 - bump) - 2 * step(8 - dent) + step(3 - dent));
      const int a = 41 * y + x;
      if (x == 40 || y == 30 || in_hole(x + 0.5, y + 0.5)) continue;
      faces += fmt::format("3 {} {} {}\n3 {} {} {}\n", a, a + 1, a + 42, a, a + 42, a + 41);
      num_faces += 2;
    }
  return fmt::format(
      "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\nproperty "
      "double quality\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n{}{}",
      41 * 31, num_faces, vertices, faces);
}

class Shapes : public testing::Test {
 protected:
  void SetUp() override {
    folder_.write("sheet.ply", sheet());
    folder_.write("shapes.yaml",
                  "version: 1\nunits: mm\nstages:\n  - load: {path: sheet.ply}\n"
                  "  - tree: {scalar: quality, polarity: shapes}\n"
                  "  - mser: {min_area: 5 mm2, min_persistence: 0.3, min_diversity: 50 %, grow: none}\n"
                  "  - borders: {interpolate: true}\n  - export: {pictures: false, tree: true}\n  - report: {}\n");
  }
  Finished program(std::vector<std::string> arguments) const {
    if (arguments[0] == "run")
      arguments.insert(arguments.end(), {"--out", "out", "--cache", "cache"});
    else
      arguments.insert(arguments.begin() + 1, {"shapes.yaml"});
    return run_program(arguments, folder_.path().string());
  }
  std::filesystem::path file(const std::string& name) const { return folder_.path() / name; }

  TemporaryFolder folder_;
};

TEST_F(Shapes, OneRunFindsBumpDentAndTheBumpInTheDent) {
  const Finished finished = program({"run", "shapes.yaml"});
  ASSERT_EQ(finished.exit_code, 0) << finished.err;
  auto regions = rows_of(file("out/regions.csv"));
  ASSERT_EQ(regions.size(), 3u);
  // By area: the dent with all that is in it, the bump without what the hole took, the bump in the dent.
  const auto number = [&](int region, const char* column) {
    return std::stod(regions.at(static_cast<std::size_t>(region)).at(column));
  };
  EXPECT_EQ(regions[0]["polarity"], "lower");
  EXPECT_EQ(regions[1]["polarity"], "upper");
  EXPECT_EQ(regions[2]["polarity"], "upper");
  EXPECT_EQ(regions[0]["parent"], "-1");
  EXPECT_EQ(regions[1]["parent"], "-1");
  EXPECT_EQ(regions[2]["parent"], "1");
  EXPECT_NEAR(number(0, "area"), M_PI * 64, 35);
  EXPECT_NEAR(number(2, "area"), M_PI * 9, 14);
  for (int region = 0; region < 3; ++region) {
    EXPECT_NEAR(number(region, "x"), region == 1 ? 10 : 28, 0.7);
    EXPECT_EQ(number(region, "euler"), 1);
    const double value = number(region, "value"), low = region == 1 ? 0 : -2,
                 high = region == 0   ? 0
                        : region == 1 ? 2
                                      : -1;
    EXPECT_GT(value, low);
    EXPECT_LT(value, high);
    EXPECT_EQ(number(region, "hole_length") > 0, region == 1);
    // The bump in the dent is filled into it.
    EXPECT_EQ(number(region, "scalar_min") >= value, region != 0);
    EXPECT_GT(number(region, "scalar_max"), value);
    EXPECT_EQ(number(region, "contrast") < 0, region == 0);
  }
  // tree.csv knows each region's node by the same line.
  int matched = 0;
  for (auto& node : rows_of(file("out/tree.csv"))) {
    if (node["region"] == "0") continue;
    auto& region = regions.at(static_cast<std::size_t>(std::stoi(node["region"])) - 1);
    for (const char* column : {"polarity", "node", "level", "high_level", "value", "area"})
      EXPECT_EQ(node[column], region[column]) << column;
    ++matched;
  }
  EXPECT_EQ(matched, 3);
  EXPECT_NE(read(file("out/report.html")).find("\"polarity\":\"shapes\""), std::string::npos);
}

TEST_F(Shapes, BordersCloseAndDoNotCrossTheHole) {
  ASSERT_EQ(program({"run", "shapes.yaml"}).exit_code, 0);
  std::map<std::string, std::vector<std::map<std::string, std::string>>> loops;
  for (auto& edge : rows_of(file("out/borders.csv"))) loops[edge["region"] + "/" + edge["loop"]].push_back(edge);
  EXPECT_EQ(loops.size(), 3u);
  int at_hole = 0;
  for (auto& [name, edges] : loops)
    for (std::size_t k = 0; k < edges.size(); ++k) {
      auto& next = edges[(k + 1) % edges.size()];
      EXPECT_EQ(edges[k]["x1"] + edges[k]["y1"], next["x0"] + next["y0"]) << name;
      const double x0 = std::stod(edges[k]["x0"]), y0 = std::stod(edges[k]["y0"]), x1 = std::stod(edges[k]["x1"]),
                   y1 = std::stod(edges[k]["y1"]);
      EXPECT_FALSE(in_hole((x0 + x1) / 2, (y0 + y1) / 2)) << name;
      if (edges[k]["kind"] != "hole") continue;
      EXPECT_TRUE((x0 == x1 && (x0 == 8 || x0 == 13)) || (y0 == y1 && (y0 == 17 || y0 == 24))) << name;
      EXPECT_EQ(edges[k]["region"], "2");
      ++at_hole;
    }
  EXPECT_GT(at_hole, 3);
}

TEST_F(Shapes, CommandsReadTheTree) {
  ASSERT_EQ(program({"run", "shapes.yaml"}).exit_code, 0);
  const Finished why = program({"why", "--point=28,15,0"});
  ASSERT_EQ(why.exit_code, 0) << why.err;
  EXPECT_NE(why.out.find("\ntree of shapes, "), std::string::npos) << why.out;
  EXPECT_NE(why.out.find("REGION 3"), std::string::npos) << why.out;
  EXPECT_NE(why.out.find("REGION 1"), std::string::npos) << why.out;
  EXPECT_NE(why.out.find("  >= -"), std::string::npos) << why.out;
  EXPECT_NE(why.out.find("  < -"), std::string::npos) << why.out;

  const Finished tree = program({"tree", "tree.json"});
  ASSERT_EQ(tree.exit_code, 0) << tree.err;
  const std::string json = read(file("tree.json"));
  for (const char* part : {"\"polarity\": \"shapes\"", "\"value\": [", "\"sign\": ["})
    EXPECT_NE(json.find(part), std::string::npos) << part;
  EXPECT_EQ(program({"tree", "tree.json", "--polarity", "shapes"}).exit_code, 0);
  const Finished upper = program({"tree", "tree.json", "--polarity", "upper"});
  EXPECT_EQ(upper.exit_code, 2);
  EXPECT_NE(upper.err.find("makes no upper tree"), std::string::npos) << upper.err;

  // At -1.5 the dent, and in it the bump; at 1 the other bump alone.
  const auto num_components = [&](const std::string& at) {
    const Finished cut = program({"cut", "cut.ply", "--at=" + at});
    EXPECT_EQ(cut.exit_code, 0) << cut.err;
    return std::count(cut.out.begin(), cut.out.end(), '\n') - 1;
  };
  EXPECT_EQ(num_components("-1.5"), 2);
  EXPECT_EQ(num_components("1"), 1);
  const Finished flat = program({"reconstruct", "flat.ply", "--min-persistence", "0.5"});
  EXPECT_EQ(flat.exit_code, 0) << flat.err;
  EXPECT_TRUE(std::filesystem::exists(file("flat.ply")));
}

TEST_F(Shapes, SelectionsByMaximaFindTheSameThree) {
  for (const char* select : {"persistence", "stable_branch"}) {
    const Finished finished = program({"run", "shapes.yaml", "--set", std::string("mser.select=") + select});
    ASSERT_EQ(finished.exit_code, 0) << finished.err;
    auto regions = rows_of(file("out/regions.csv"));
    ASSERT_EQ(regions.size(), 3u) << select;
    EXPECT_EQ(regions[0]["polarity"], "lower");
    EXPECT_EQ(regions[1]["polarity"], "upper");
    EXPECT_EQ(regions[2]["polarity"], "upper");
    EXPECT_EQ(regions[2]["parent"], "1");
  }
}

TEST_F(Shapes, WhatCannotBeIsToldInOneSentence) {
  // From within the dent, what lies around it is a region.
  const Finished rooted = program({"run", "shapes.yaml", "--set", "tree.root=[22.1, 15, 0]"});
  ASSERT_EQ(rooted.exit_code, 0) << rooted.err;
  const auto regions = rows_of(file("out/regions.csv"));
  ASSERT_FALSE(regions.empty());
  EXPECT_GT(std::stod(regions[0].at("area")), 800);

  const Finished by_value = program({"run", "shapes.yaml", "--set", "mser.delta_value=0.1"});
  EXPECT_NE(by_value.exit_code, 0);
  EXPECT_NE(by_value.err.find("mser.delta_value: a tree of shapes counts level lines"), std::string::npos)
      << by_value.err;
  const Finished root = program({"run", "shapes.yaml", "--set", "tree.polarity=both", "--set", "tree.root=[0, 0, 0]"});
  EXPECT_NE(root.exit_code, 0);
  EXPECT_NE(root.err.find("only polarity: shapes has a root to choose"), std::string::npos) << root.err;

  std::string torus =
                  "ply\nformat ascii 1.0\nelement vertex 36\nproperty double x\nproperty double y\nproperty double "
                  "z\nproperty double quality\nelement face 72\nproperty list uchar int vertex_indices\nend_header\n",
              faces;
  for (int i = 0; i < 36; ++i) {
    const double a = i / 6 * M_PI / 3, b = i % 6 * M_PI / 3;
    torus += fmt::format("{} {} {} {}\n", (3 + std::cos(b)) * std::cos(a), (3 + std::cos(b)) * std::sin(a), std::sin(b),
                         std::cos(a));
    const int right = i / 6 * 6 + (i + 1) % 6, above = (i + 6) % 36, both = (right + 6) % 36;
    faces += fmt::format("3 {} {} {}\n3 {} {} {}\n", i, above, both, i, both, right);
  }
  folder_.write("torus.ply", torus + faces);
  const Finished handle = program({"run", "shapes.yaml", "--set", "load.path=torus.ply"});
  EXPECT_NE(handle.exit_code, 0);
  EXPECT_NE(handle.err.find("but the component of triangle 0 has 1"), std::string::npos) << handle.err;
}

}  // namespace
}  // namespace meshmser
