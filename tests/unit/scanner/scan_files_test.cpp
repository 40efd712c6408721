#include "data/scanner/scan_files.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numeric>
#include <set>

#include "data/scanner/shapes.hpp"
#include "pipeline/execution/error.hpp"
#include "pipeline/formats/geometry_file.hpp"

namespace meshmser::scanner {
namespace {

class ScanFiles : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) /
              (std::string("scan_files_") + testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }
  static std::string read(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  template <class Call>
  static std::string message_of(Call&& call) {
    try {
      call();
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  }
  std::filesystem::path folder_;
};

TEST_F(ScanFiles, PointsReadBackInTheOrderAskedForWithTheOrigin) {
  const std::vector<Eigen::Vector3d> points = {{1, 2, 3}, {4.25, 5, 6}, {-7, 8.5, 9}};
  PointFileOptions options;
  options.origin = {500000, 0, -1000};
  options.double_precision = true;
  for (const char* name : {"a.ply", "a.xyz", "a.pcd"}) {
    write_points(folder_ / name, points, {2, 0}, options);
    if (std::string(name) == "a.pcd") continue;
    const Geometry geometry = read_geometry_file(folder_ / name).front();
    ASSERT_EQ(geometry.num_vertices(), 2u) << name;
    EXPECT_EQ(geometry.positions[0], Eigen::Vector3d(499993, 8.5, -991)) << name;
    EXPECT_EQ(geometry.positions[1], Eigen::Vector3d(500001, 2, -997)) << name;
  }
  const std::string pcd = read(folder_ / "a.pcd");
  EXPECT_NE(pcd.find("\nSIZE 8 8 8\n"), std::string::npos);
  EXPECT_NE(pcd.find("\nVIEWPOINT 500000 0 -1000 1 0 0 0\nPOINTS 2\nDATA binary\n"), std::string::npos);
  double x = 0;
  std::memcpy(&x, pcd.data() + pcd.size() - 48, 8);
  EXPECT_EQ(x, 499993);
  EXPECT_NE(message_of([&] {
              write_points(folder_ / "a.las", points, {0}, options);
            }).find("end it in .ply, .pcd, .xyz or .txt"),
            std::string::npos);
}

TEST_F(ScanFiles, ArraysAreNumPys) {
  write_edges_npy(folder_ / "e.npy", {{{1, 2, 3}, 90}, {{4, 5, 6}, 12.5}}, {10, 0, 0});
  const std::string edges = read(folder_ / "e.npy");
  ASSERT_EQ(edges.size(), 128u + 32u);
  EXPECT_EQ(edges.substr(0, 8), std::string("\x93NUMPY\x01\x00", 8));
  EXPECT_EQ(edges[8], 118);  // length of the header: data begin at a multiple of 64 bytes
  EXPECT_NE(edges.find("{'descr': '<f4', 'fortran_order': False, 'shape': (2, 4), }"), std::string::npos);
  EXPECT_EQ(edges[127], '\n');
  float values[8];
  std::memcpy(values, edges.data() + 128, sizeof values);
  EXPECT_EQ(std::vector<float>(values, values + 8), (std::vector<float>{11, 2, 3, 90, 14, 5, 6, 12.5}));

  write_faces_npy(folder_ / "l.npy", {0, 7, 300});
  const std::string labels = read(folder_ / "l.npy");
  EXPECT_NE(labels.find("{'descr': '<u2', 'fortran_order': False, 'shape': (3,), }"), std::string::npos);
  EXPECT_EQ(labels.substr(labels.size() - 6), std::string("\0\0\7\0\x2c\x01", 6));
}

TEST_F(ScanFiles, MeshComesBackWithFacesByAngle) {
  const Shape shape = make_shape("cylinder");
  write_shape(folder_ / "c.ply", shape, Eigen::Vector3d::Zero(), "a cylinder");
  const Shape again = read_shape(folder_ / "c.ply", 30);
  EXPECT_EQ(again.mesh.triangles, shape.mesh.triangles);
  EXPECT_EQ(again.mesh.positions, shape.mesh.positions);
  EXPECT_EQ(std::set<std::int32_t>(again.face_of_triangle.begin(), again.face_of_triangle.end()).size(), 3u);
  const auto points = write("p.xyz", "0 0 0\n1 0 0\n0 1 0\n");
  EXPECT_NE(message_of([&] { read_shape(points, 30); }).find("no faces, only points"), std::string::npos);
}

TEST_F(ScanFiles, PosesAreReadAndBadLinesNamed) {
  const auto good = write("poses.txt", "# scanner, target\n\n0 0 50\n10 0 0  1 2 3\n");
  const std::vector<Pose> poses = read_poses(good, {0, 0, 5});
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_EQ(poses[0].target, Eigen::Vector3d(0, 0, 5));
  EXPECT_EQ(poses[1].target, Eigen::Vector3d(1, 2, 3));
  const Eigen::Vector3d target = Eigen::Vector3d::Zero();
  auto message = [&](const std::string& text) {
    return message_of([&] { read_poses(write("bad.txt", text), target); });
  };
  EXPECT_NE(message("0 0 1\n0 zero 1\n").find("bad.txt:2: "), std::string::npos);
  EXPECT_NE(message("0 0 1\n0 1\n").find("bad.txt:2: 2 numbers; expected"), std::string::npos);
  EXPECT_NE(message("0 0 0\n").find("bad.txt:1: the scanner stands where it looks at"), std::string::npos);
  EXPECT_NE(message("# nothing\n").find("no poses"), std::string::npos);
}

TEST_F(ScanFiles, DemoScanIsWhatItsCommandMakes) {
  // The command stands in data/demo/make.
  const Shape shape = make_shape("tablet");
  const Extent extent = extent_of(shape.mesh);
  ScanOptions options;
  options.spacing = 0.165;
  options.noise = 0.3;
  options.holes = 4;
  options.hole_radius = 1.1;
  options.seed = 7;
  const SimulatedScan scan =
      scan_shape(shape, poses_around(extent.centre, 5 * extent.radius, 3, 25, {0, 0, 1}), options);
  const Geometry stored =
      read_geometry_file(std::filesystem::path(MESHMSER_SOURCE_DIR) / "data/demo/tablet.ply").front();
  ASSERT_EQ(stored.num_vertices(), scan.points.size());
  // Another processor may take the other triangle where a ray meets an edge.
  std::size_t different = 0;
  for (std::size_t i = 0; i < scan.points.size(); ++i)
    different += scan.points[i].cast<float>().cast<double>() != stored.positions[i];
  EXPECT_LT(different, scan.points.size() / 1000);
}

}  // namespace
}  // namespace meshmser::scanner
