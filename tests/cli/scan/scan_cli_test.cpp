#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "pipeline/formats/geometry_file.hpp"

namespace meshmser {
namespace {

struct Result {
  int code = -1;
  std::string out, err;
};

class ScanProgram : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) /
              (std::string("scan_cli_") + testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  static std::string read(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  Result run(const std::string& arguments) {
    const std::string command =
        fmt::format("cd '{}' && '{}' {} >out 2>err", folder_.string(), MESHMSER_SCAN, arguments);
    Result result;
    const int status = std::system(command.c_str());
    result.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    result.out = read(folder_ / "out");
    result.err = read(folder_ / "err");
    return result;
  }
  bool exists(const std::string& name) { return std::filesystem::exists(folder_ / name); }
  std::filesystem::path folder_;
};

TEST_F(ScanProgram, WritesPointsAndTruthTheSameForAnyNumberOfThreads) {
  const Result result = run("diamond d.ply --spacing 0.5 --holes 2 --hole-radius 2 --truth");
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_NE(result.out.find("d.ply: "), std::string::npos);
  for (const char* name : {"d-labels.npy", "d-normals.npy", "d-passes.npy", "d-edges.npy", "d-scan.json"})
    EXPECT_TRUE(exists(name)) << name;
  EXPECT_NE(read(folder_ / "d-scan.json").find("\"holes\": [\n"), std::string::npos);
  EXPECT_EQ(run("diamond e.ply --spacing 0.5 --holes 2 --hole-radius 2 --threads 1 --truth").code, 0);
  for (const char* ending : {".ply", "-labels.npy", "-normals.npy", "-passes.npy", "-edges.npy"})
    EXPECT_EQ(read(folder_ / (std::string("d") + ending)), read(folder_ / (std::string("e") + ending))) << ending;
}

TEST_F(ScanProgram, ScansItsOwnMeshFileLikeTheShape) {
  EXPECT_EQ(run("cylinder a.ply --spacing 0.5 --noise 0 --mesh-out m.ply --keep-order").code, 0);
  EXPECT_EQ(run("./m.ply b.ply --spacing 0.5 --noise 0 --views 10 --keep-order --labels").code, 0);
  EXPECT_EQ(read_geometry_file(folder_ / "a.ply").front().positions,
            read_geometry_file(folder_ / "b.ply").front().positions);
  EXPECT_TRUE(exists("b-labels.npy"));
  EXPECT_FALSE(exists("b-edges.npy"));
}

TEST_F(ScanProgram, WritesOneFileAPassWithItsViewpoint) {
  EXPECT_EQ(run("sphere s.pcd --spacing 1 --views 3 --per-pass --origin 1000000,0,0").code, 0);
  EXPECT_FALSE(exists("s.pcd"));
  for (const char* name : {"s-00.pcd", "s-01.pcd", "s-02.pcd"}) {
    const Geometry scan = read_geometry_file(folder_ / name).front();
    ASSERT_TRUE(scan.scanner_position.has_value()) << name;
    EXPECT_NEAR((*scan.scanner_position - Eigen::Vector3d(1000000, 0, 0)).norm(), 5 * std::sqrt(300.0), 0.01);
    for (const Eigen::Vector3d& p : scan.positions) ASSERT_NEAR((p - Eigen::Vector3d(1000000, 0, 0)).norm(), 10, 2);
  }
}

TEST_F(ScanProgram, MeetsTheNumberOfPointsAskedFor) {
  EXPECT_EQ(run("torus t.xyz --points 30000 --seed 3").code, 0);
  EXPECT_NEAR(static_cast<double>(read_geometry_file(folder_ / "t.xyz").front().num_vertices()), 30000, 900);
}

TEST_F(ScanProgram, ListsItsShapesAndOptions) {
  const Result list = run("--list");
  EXPECT_EQ(list.code, 0);
  for (const char* text : {"pump: ", "tablet: ", "--set groove_depth=0.2", "figurine: "})
    EXPECT_NE(list.out.find(text), std::string::npos) << text;
  const Result help = run("--help");
  EXPECT_EQ(help.code, 0);
  EXPECT_NE(help.out.find("--registration"), std::string::npos);
  EXPECT_EQ(run("--version").code, 0);
}

TEST_F(ScanProgram, ErrorsHaveTheirCodesAndOneMessage) {
  auto expect = [&](const std::string& arguments, int code, const std::string& message) {
    const Result result = run(arguments);
    EXPECT_EQ(result.code, code) << arguments;
    EXPECT_NE(result.err.find(message), std::string::npos) << arguments << ": " << result.err;
    EXPECT_EQ(result.out, "") << arguments;
  };
  expect("", 2, "give an object and an output file");
  expect("cube c.ply", 2, "unknown shape 'cube'; known: plane");
  expect("sphere s.las", 2, "end it in .ply, .pcd, .xyz or .txt");
  expect("sphere s.ply --set radius", 2, "--set radius: expected name=number");
  expect("sphere s.ply --set size=3", 2, "has no parameter 'size'");
  expect("sphere s.ply --noise -1", 2, "noise = -1 must be from 0 to 10 spacings");
  expect("sphere s.ply --spacing 1 --points 5", 2, "--points");
  expect("sphere s.ply --distance 1", 2, "--distance must be at least 1.2");
  expect("./none.ply s.ply", 4, "none.ply: no such file");
  expect("sphere s.ply --poses none.txt", 4, "none.txt");
  expect("sphere nowhere/s.ply --spacing 1", 6, "nowhere/s.ply");
  expect("sphere s.ply --spacing 1 --holes 400", 5, "holes of radius 12 fit three radii apart");
}

}  // namespace
}  // namespace meshmser
