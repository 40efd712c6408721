#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "pipeline/formats/geometry_file.hpp"
#include "pipeline/formats/obj.hpp"
#include "pipeline/formats/off.hpp"
#include "pipeline/formats/stanford_conf.hpp"
#include "pipeline/formats/stl.hpp"
#include "tests/support/temporary_files.hpp"

namespace meshmser {
namespace {

using Corners = std::vector<std::int32_t>;

FileBytes bytes_of(const std::string& name, const std::string& text) {
  TemporaryFolder folder;
  return read_file_bytes(folder.write(name, text));
}

TEST(Off, ReadsNormalsColoursAndPolygons) {
  const Geometry g =
      read_off(bytes_of("a.off",
                        "# by hand\nCNOFF 4 2 0\n0 0 0  0 0 1  255 0 0 255\n1 0 0  0 0 1  0 255 0 255 # corner\n"
                        "1 1 0  0 0 1  0 0 255 255\n0 1 0  0 0 1  9 9 9 255\n3 0 1 2\n4 0 1 2 3 0.5 0.5 0.5\n"));
  EXPECT_EQ(g.num_vertices(), 4u);
  EXPECT_EQ(g.positions[2], Eigen::Vector3d(1, 1, 0));
  ASSERT_EQ(g.properties.size(), 7u);
  EXPECT_EQ(g.properties[2].values, (std::vector<double>{1, 1, 1, 1}));
  EXPECT_EQ(g.properties[4].name, "green");
  EXPECT_EQ(g.properties[4].values, (std::vector<double>{0, 255, 0, 9}));
  EXPECT_EQ(g.corners, (Corners{0, 1, 2, 0, 1, 2, 3}));
}

TEST(Off, CountsMayStandOnTheirOwnLine) {
  const Geometry g = read_off(bytes_of("a.off", "OFF\r\n\r\n3 1\r\n0 0 0\r\n1 0 0\r\n0 1 0\r\n3 2 1 0\r\n"));
  EXPECT_EQ(g.corners, (Corners{2, 1, 0}));
}

TEST(Obj, ReadsFacesOfEveryForm) {
  const Geometry g = read_obj(bytes_of(
      "a.obj",
      "# by hand\nmtllib a.mtl\no thing\nv 0 0 0\nv 1 0 0 1.0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n"
      "usemtl red\ns off\nf 1 2 3\nf 1/1 2/1 3/1 4/1\nf -4//1 -3//1 -1//1 # three\nf 1/1/1 \\\n 2/1/1 3/1/1\n"));
  EXPECT_EQ(g.num_vertices(), 4u);
  EXPECT_EQ(g.first_corner_of_face, (std::vector<std::int64_t>{0, 3, 7, 10, 13}));
  EXPECT_EQ(g.corners, (Corners{0, 1, 2, 0, 1, 2, 3, 0, 1, 3, 0, 1, 2}));
}

TEST(Obj, ColoursOfVerticesAreProperties) {
  const Geometry g = read_obj(bytes_of("a.obj", "v 0 0 0 1 0.5 0\nv 1 0 0 0 0 1\n"));
  ASSERT_EQ(g.properties.size(), 3u);
  EXPECT_EQ(g.properties[1].values, (std::vector<double>{0.5, 0}));
  EXPECT_EQ(g.num_faces(), 0u);
}

std::string binary_stl(const std::string& head, const std::vector<std::array<float, 9>>& facets) {
  std::string bytes = head;
  bytes.resize(80, ' ');
  auto append = [&bytes](const auto& value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof(value)); };
  append(static_cast<std::uint32_t>(facets.size()));
  for (const auto& facet : facets) {
    append(std::array<float, 3>{0, 0, 1});
    append(facet);
    append(std::uint16_t{0});
  }
  return bytes;
}

TEST(Stl, BinaryAndTextGiveTheSame) {
  const std::string text =
      "solid a\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 0 1.5e0 0\n  endloop\n "
      "endfacet\n"
      "endsolid a\n";
  for (const std::string& bytes : {text, binary_stl("made by hand", {{0, 0, 0, 1, 0, 0, 0, 1.5f, 0}}),
                                   binary_stl("solid but binary", {{0, 0, 0, 1, 0, 0, 0, 1.5f, 0}})}) {
    const Geometry g = read_stl(bytes_of("a.stl", bytes));
    ASSERT_EQ(g.num_vertices(), 3u);
    EXPECT_EQ(g.positions[2], Eigen::Vector3d(0, 1.5, 0));
    EXPECT_EQ(g.corners, (Corners{0, 1, 2}));
  }
}

TEST(Ptx, ScansStandWhereTheirMatrixPutsThem) {
  TemporaryFolder folder;
  const std::string text =
      "2\n2\n1 2 3\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"
      "1 0 0 0.5 255 0 0\n0 0 0 0.5 0 0 0\n0 1 0 0.25 0 255 0\n0 0 1 0.75 0 0 255\n"
      "1\n1\n5 0 0\n0 1 0\n-1 0 0\n0 0 1\n0 1 0 0\n-1 0 0 0\n0 0 1 0\n5 0 0 1\n1 0 0 0.5 1 2 3\n";
  const std::vector<Geometry> scans = read_geometry_file(folder.write("a.ptx", text));
  ASSERT_EQ(scans.size(), 2u);
  EXPECT_EQ(scans[0].name, "a.ptx #1");
  EXPECT_EQ(scans[0].num_vertices(), 3u);
  EXPECT_EQ(scans[0].num_empty_cells, 1);
  EXPECT_EQ(*scans[0].scanner_position, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(scans[0].properties[0].values, (std::vector<double>{0.5, 0.25, 0.75}));
  // Cells go line by line; the empty one counts.
  EXPECT_EQ(scans[0].properties[4].name, "scan_line");
  EXPECT_EQ(scans[0].properties[4].values, (std::vector<double>{0, 1, 1}));
  EXPECT_EQ(scans[0].properties[5].name, "scan_place");
  EXPECT_EQ(scans[0].properties[5].values, (std::vector<double>{0, 0, 1}));
  // Row vectors times the matrix: x goes to y, then the translation.
  EXPECT_EQ(scans[1].positions[0], Eigen::Vector3d(5, 1, 0));
  EXPECT_EQ(*scans[1].scanner_position, Eigen::Vector3d(5, 0, 0));
}

// The same grid of 2 x 3 cells as Leica writes it (columns first, column by column) and as Photoneo does (rows first,
// row by row): the first number counts the lines, the second the places along one.
TEST(Ptx, LeicaColumnsAndPhotoneoRowsAreScanLines) {
  TemporaryFolder folder;
  const std::string head = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
  const std::string text = "2\n3\n" + head + "1 1 9 .5\n1 2 9 .5\n1 3 9 .5\n2 1 9 .5\n2 2 9 .5\n2 3 9 .5\n";
  const Geometry scan = read_geometry_file(folder.write("a.ptx", text)).at(0);
  ASSERT_EQ(scan.properties.size(), 3u);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(scan.properties[1].values[i], scan.positions[i].x() - 1);
    EXPECT_EQ(scan.properties[2].values[i], scan.positions[i].y() - 1);
  }
}

std::string pcd_header(const std::string& encoding) {
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z rgb intensity normal_x\nSIZE 4 4 4 4 8 "
         "4\n"
         "TYPE F F F F F F\nCOUNT 1 1 1 1 1 1\nWIDTH 2\nHEIGHT 1\nVIEWPOINT 1 2 3 1 0 0 0\nPOINTS 2\nDATA " +
         encoding + "\n";
}

TEST(Pcd, TextAndBinaryGiveTheSame) {
  const std::uint32_t rgb = 0x00112233;
  float packed;
  std::memcpy(&packed, &rgb, 4);
  std::string binary = pcd_header("binary");
  for (int i = 0; i < 2; ++i) {
    auto append = [&binary](const auto& value) { binary.append(reinterpret_cast<const char*>(&value), sizeof(value)); };
    append(1.5f + static_cast<float>(i));
    append(2.f);
    append(3.f);
    append(packed);
    append(0.125);
    append(1.f);
  }
  char text[64];
  snprintf(text, sizeof(text), "%.9g", static_cast<double>(packed));
  const std::string ascii = pcd_header("ascii") + "1.5 2 3 " + text + " .125 1\n2.5 2 3 " + text + " .125 1\n";
  TemporaryFolder folder;
  for (const std::string& bytes : {binary, ascii}) {
    const Geometry g = read_geometry_file(folder.write("a.pcd", bytes)).at(0);
    ASSERT_EQ(g.num_vertices(), 2u);
    EXPECT_EQ(g.positions[1], Eigen::Vector3d(2.5, 2, 3));
    ASSERT_EQ(g.properties.size(), 5u);
    EXPECT_EQ(g.properties[0].name, "red");
    EXPECT_EQ(g.properties[0].values[1], 0x11);
    EXPECT_EQ(g.properties[2].values[1], 0x33);
    EXPECT_EQ(g.properties[3].values[1], 0.125);
    EXPECT_EQ(g.properties[4].name, "nx");
    EXPECT_EQ(*g.scanner_position, Eigen::Vector3d(1, 2, 3));
  }
}

TEST(Pcd, ReadsCompressedData) {
  // Field after field; one LZF literal run of 24 bytes: control byte 23, then the bytes.
  std::string bytes =
      "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA binary_compressed\n";
  const std::array<std::uint32_t, 2> sizes{25, 24};
  bytes.append(reinterpret_cast<const char*>(sizes.data()), 8);
  bytes.push_back(23);
  const std::array<float, 6> values{1, 2, 3, 4, 5, 6};
  bytes.append(reinterpret_cast<const char*>(values.data()), 24);
  TemporaryFolder folder;
  const Geometry g = read_geometry_file(folder.write("a.pcd", bytes)).at(0);
  ASSERT_EQ(g.num_vertices(), 2u);
  EXPECT_EQ(g.positions[0], Eigen::Vector3d(1, 3, 5));
  EXPECT_EQ(g.positions[1], Eigen::Vector3d(2, 4, 6));
}

TEST(StanfordConf, TurnsByTheConjugate) {
  const std::vector<PosedFile> files = read_stanford_conf(bytes_of(
      "a.conf", "camera 0 0 0 0 0 0 1\nbmesh a.ply 0 0 0 0 0 0 1\nbmesh b.ply 1 2 3 0 0 0.70710678 0.70710678\n"));
  ASSERT_EQ(files.size(), 2u);
  EXPECT_TRUE(files[0].world_from_file.matrix().isIdentity(0));
  EXPECT_EQ(files[1].path.filename(), "b.ply");
  // The stored quaternion turns x to y; its conjugate turns y to x.
  EXPECT_LT((files[1].world_from_file * Eigen::Vector3d(0, 1, 0) - Eigen::Vector3d(2, 2, 3)).norm(), 1e-7);
}

TEST(GeometryFile, TellsFormatsByContentThenExtension) {
  TemporaryFolder folder;
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 "
      "3\n";
  EXPECT_EQ(read_geometry_file(folder.write("scan.dat", ply)).at(0).num_vertices(), 1u);
  EXPECT_EQ(read_geometry_file(folder.write("SCAN.XYZ", "1 2 3\n")).at(0).num_vertices(), 1u);
  ReadOptions options;
  options.format = "xyz";
  EXPECT_EQ(read_geometry_file(folder.write("scan", "1 2 3\n"), options).at(0).num_vertices(), 1u);
}

}  // namespace
}  // namespace meshmser
