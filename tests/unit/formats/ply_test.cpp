#include "pipeline/formats/ply.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/temporary_files.hpp"

namespace meshmser {
namespace {

Geometry read_text(const std::string& text) {
  TemporaryFolder folder;
  return read_ply(read_file_bytes(folder.write("a.ply", text)));
}

template <class Number>
std::string packed(Number value, bool big) {
  std::string bytes(reinterpret_cast<const char*>(&value), sizeof(value));
  if (big) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

TEST(Ply, ReadsAsciiWithUnknownPropertiesAndElements) {
  const Geometry g = read_text(
      "ply\r\nformat ascii 1.0\r\ncomment made by hand\r\nobj_info a b\r\nelement camera 1\r\nproperty float view\r\n"
      "property list uchar float matrix\r\nelement vertex 4\r\nproperty float x\r\nproperty list uchar int extra\r\n"
      "property double z\r\nproperty uchar red\r\nproperty float y\r\nelement face 2\r\nproperty int flags\r\n"
      "property list uchar int vertex_indices\r\nend_header\r\n"
      "1.5 2 1 2\r\n"
      "0 0 10 255 +5\r\n\r\n1e-1 2 7 7 11 0 6\r\n  .5 1 3 12 1 7  \r\nnan 0 inf 2 -1.#IND\r\n"
      "9 3 0 1 2\r\n8 4 3 2 1 0\r\n");
  ASSERT_EQ(g.num_vertices(), 4u);
  EXPECT_EQ(g.positions[0], Eigen::Vector3d(0, 5, 10));
  EXPECT_EQ(g.positions[1], Eigen::Vector3d(0.1, 6, 11));
  EXPECT_EQ(g.positions[2], Eigen::Vector3d(0.5, 7, 12));
  EXPECT_TRUE(std::isnan(g.positions[3].x()) && std::isnan(g.positions[3].y()) && std::isinf(g.positions[3].z()));
  ASSERT_EQ(g.properties.size(), 1u);
  EXPECT_EQ(g.properties[0].name, "red");
  EXPECT_EQ(g.properties[0].type, ValueType::kUint8);
  EXPECT_EQ(g.properties[0].values, (std::vector<double>{255, 0, 1, 2}));
  EXPECT_EQ(g.first_corner_of_face, (std::vector<std::int64_t>{0, 3, 7}));
  EXPECT_EQ(g.corners, (std::vector<std::int32_t>{0, 1, 2, 3, 2, 1, 0}));
}

TEST(Ply, ReadsEveryTypeInBothBinaryOrders) {
  for (const bool big : {false, true}) {
    std::string text =
        std::string("ply\nformat ") + (big ? "binary_big_endian" : "binary_little_endian") +
        " 1.0\nelement vertex 2\nproperty char a\nproperty double x\nproperty uchar b\nproperty short c\n"
        "property float y\nproperty ushort d\nproperty int e\nproperty uint f\nproperty float64 z\n"
        "element face 1\nproperty list uchar uint vertex_index\nproperty float quality\nend_header\n";
    for (int i = 0; i < 2; ++i)
      text += packed<std::int8_t>(static_cast<std::int8_t>(-i), big) + packed(1.1 + i, big) +
              packed<std::uint8_t>(200, big) + packed<std::int16_t>(-300, big) + packed(2.5f, big) +
              packed<std::uint16_t>(60000, big) + packed<std::int32_t>(-70000, big) +
              packed<std::uint32_t>(4000000000u, big) + packed(-3.3, big);
    text += packed<std::uint8_t>(3, big) + packed<std::uint32_t>(1, big) + packed<std::uint32_t>(0, big) +
            packed<std::uint32_t>(1, big) + packed(1.f, big);
    const Geometry g = read_text(text);
    ASSERT_EQ(g.num_vertices(), 2u);
    EXPECT_EQ(g.positions[1], Eigen::Vector3d(2.1, 2.5, -3.3));
    ASSERT_EQ(g.properties.size(), 6u);
    EXPECT_EQ(g.properties[0].values[1], -1);
    EXPECT_EQ(g.properties[1].values[1], 200);
    EXPECT_EQ(g.properties[2].values[1], -300);
    EXPECT_EQ(g.properties[3].values[1], 60000);
    EXPECT_EQ(g.properties[4].values[1], -70000);
    EXPECT_EQ(g.properties[5].values[1], 4000000000.0);
    EXPECT_EQ(g.corners, (std::vector<std::int32_t>{1, 0, 1}));
  }
}

TEST(Ply, RangeGridMeansAViewAlongZ) {
  const Geometry g = read_text(
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
      "element range_grid 4\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 0\n0\n0\n1 1\n");
  ASSERT_TRUE(g.view_direction.has_value());
  EXPECT_EQ(*g.view_direction, Eigen::Vector3d::UnitZ());
  EXPECT_EQ(g.num_faces(), 0u);
}

TEST(Ply, RangeGridGivesRowAndColumn) {
  const std::string vertices =
      "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement range_grid 6\n"
      "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n2 0 0\n0\n1 1\n0\n0\n0\n1 0\n";
  const Geometry g = read_text("ply\nformat ascii 1.0\nobj_info num_cols 3\nobj_info num_rows 2\n" + vertices);
  ASSERT_EQ(g.properties.size(), 2u);
  EXPECT_EQ(g.properties[0].name, "scan_line");
  EXPECT_EQ(g.properties[0].values, (std::vector<double>{1, 0, -1}));
  EXPECT_EQ(g.properties[1].name, "scan_place");
  EXPECT_EQ(g.properties[1].values, (std::vector<double>{2, 1, -1}));
  EXPECT_TRUE(read_text("ply\nformat ascii 1.0\nobj_info num_cols many\n" + vertices).properties.empty());
}

TEST(Ply, StripsBecomeTrianglesOfOneOrientation) {
  const Geometry g = read_text(
      "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
      "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n9 0 1 2 3 -1 2 3 4 -1\n");
  EXPECT_EQ(g.corners, (std::vector<std::int32_t>{0, 1, 2, 1, 3, 2, 2, 3, 4}));
}

TEST(Ply, WhatIsWrittenReadsBackTheSame) {
  TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "out.ply";
  PlyWriter writer(path, 3, {{"x"}, {"y"}, {"z"}, {"label", ValueType::kInt32}, {"quality", ValueType::kFloat32}}, 1,
                   {{"label", ValueType::kInt32}}, {"unit mm"});
  for (int i = 0; i < 3; ++i) writer.add_vertex(std::vector<double>{0.1 + i, 1e-300, -i * 1e10, i - 1.0, 0.5 * i});
  writer.add_triangle(std::array<std::int32_t, 3>{2, 0, 1}, std::vector<double>{7});
  writer.finish();
  const Geometry g = read_ply(read_file_bytes(path));
  EXPECT_EQ(g.positions[2], Eigen::Vector3d(2.1, 1e-300, -2e10));
  EXPECT_EQ(g.properties[0].values, (std::vector<double>{-1, 0, 1}));
  EXPECT_EQ(g.properties[1].values, (std::vector<double>{0, 0.5, 1}));
  EXPECT_EQ(g.corners, (std::vector<std::int32_t>{2, 0, 1}));
}

}  // namespace
}  // namespace meshmser
