#include "stages/report/report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "stages/report/block_writer.hpp"
#include "stages/report/display_mesh.hpp"
#include "stages/report/page_template.hpp"
#include "tests/support/temporary_files.hpp"

namespace meshmser {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// A wavy sheet of side x side vertices, one apart.
TriangleMesh sheet(std::int32_t side) {
  TriangleMesh mesh;
  mesh.spacing = 1;
  for (std::int32_t y = 0; y < side; ++y)
    for (std::int32_t x = 0; x < side; ++x) mesh.positions.emplace_back(x, y, std::sin(0.3 * x) + std::cos(0.2 * y));
  for (std::int32_t y = 0; y + 1 < side; ++y)
    for (std::int32_t x = 0; x + 1 < side; ++x) {
      const std::int32_t a = y * side + x;
      mesh.triangles.push_back({a, a + 1, a + side});
      mesh.triangles.push_back({a + 1, a + side + 1, a + side});
    }
  return mesh;
}

Segmentation two_regions(const TriangleMesh& mesh) {
  Segmentation s;
  s.regions.resize(2);
  s.regions[0].area = 41.0 / 3;
  s.regions[0].stability = std::numeric_limits<double>::infinity();
  s.regions[0].contrast = 0.1;
  s.regions[1].area = 1e-7;
  for (std::size_t t = 0; t < mesh.num_triangles(); ++t)
    s.label_of_triangle.push_back(static_cast<std::int32_t>(t % 3));
  s.region_of_triangle = s.label_of_triangle;
  s.region_of_label = {0, 1, 2};
  s.area_of_label = {5, 41.0 / 3, 1e-7};
  s.filters = {{"min_area", 9, 7}};
  return s;
}

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

std::string element(const std::string& page, const std::string& id) {
  const std::string begin = "id=\"" + id + "\">";
  const std::size_t from = page.rfind(begin) + begin.size();
  return page.substr(from, page.find("</script>", from) - from);
}

std::string written(const ReportContents& contents, const ReportOptions& options = {}) {
  const TemporaryFolder folder;
  const ReportSummary summary = write_report(folder.path() / "report.html", contents, options);
  std::string page = text_of(folder.path() / "report.html");
  EXPECT_EQ(summary.num_bytes, static_cast<std::int64_t>(page.size()));
  return page;
}

TEST(Report, FiguresAreThoseOfTheRunToTheLastDigit) {
  const TriangleMesh mesh = sheet(12);
  const Segmentation segmentation = two_regions(mesh);
  const auto header = nlohmann::json::parse(element(written({.mesh = &mesh, .segmentation = &segmentation}), "header"));
  EXPECT_EQ(header["summary"]["num_triangles"], 242);
  EXPECT_EQ(header["summary"]["num_regions"], 2);
  ASSERT_EQ(header["regions"].size(), 2U);
  EXPECT_EQ(header["regions"][0]["area"].get<double>(), 41.0 / 3);
  EXPECT_EQ(header["regions"][0]["stability"], "inf");
  EXPECT_EQ(header["regions"][0]["contrast"].get<double>(), 0.1);
  EXPECT_EQ(header["regions"][1]["area"].get<double>(), 1e-7);
  EXPECT_EQ(header["labels"][1]["area"].get<double>(), 1e-7);
  EXPECT_EQ(header["filters"][0]["removed"], 7);
  EXPECT_EQ(header["label_colours"].size(), 3U);
}

TEST(Report, NamesOfFilesStayText) {
  PointCloud points;
  points.positions = {{0, 0, 0}, {1, 2, 3}};
  points.scans.push_back({"</script><script>alert(1)</script>.ply", {}, 2});
  const std::string page = written({.points = &points}, {.title = "<img src=x onerror=alert(2)>"});
  EXPECT_THAT(page, Not(HasSubstr("<script>alert(1)")));
  EXPECT_THAT(page, Not(HasSubstr("<img src=x")));
  const auto header = nlohmann::json::parse(element(page, "header"));
  EXPECT_EQ(header["summary"]["scans"][0], "</script><script>alert(1)</script>.ply");
  EXPECT_EQ(header["title"], "<img src=x onerror=alert(2)>");
}

TEST(Report, StartsWithTheTemplateAndIsTheSameEachTime) {
  const TriangleMesh mesh = sheet(8);
  const std::string page = written({.mesh = &mesh});
  ASSERT_GT(page_template().size(), 100000U);
  EXPECT_EQ(page.substr(0, page_template().size()), page_template());
  EXPECT_EQ(page, written({.mesh = &mesh}));
}

TEST(Report, IsSimplifiedUntilItFits) {
  const TriangleMesh mesh = sheet(400);
  const std::string whole = written({.mesh = &mesh});
  EXPECT_EQ(nlohmann::json::parse(element(whole, "header"))["cell"], 0);
  const std::string smaller = written({.mesh = &mesh}, {.max_bytes = whole.size() - 1});
  EXPECT_LT(smaller.size(), whole.size());
  EXPECT_GT(nlohmann::json::parse(element(smaller, "header"))["cell"], 0);
}

TEST(Report, WithNothingToShowSaysSo) {
  const TemporaryFolder folder;
  EXPECT_THROW(write_report(folder.path() / "report.html", {}), StageError);
}

TEST(DisplayMesh, KeepsTheLimitAndRealTriangles) {
  const TriangleMesh mesh = sheet(100);
  const DisplayMesh display = display_mesh(mesh, 3000);
  EXPECT_LE(display.triangles.size(), 3000U);
  EXPECT_GT(display.triangles.size(), 1000U);
  ASSERT_EQ(display.triangle_of_display_triangle.size(), display.triangles.size());
  std::set<std::array<std::int32_t, 3>> seen;
  for (std::size_t t = 0; t < display.triangles.size(); ++t) {
    std::array<std::int32_t, 3> corners = display.triangles[t];
    const auto& full = mesh.triangles[static_cast<std::size_t>(display.triangle_of_display_triangle[t])];
    Eigen::Vector3d drawn_sum = Eigen::Vector3d::Zero(), full_sum = drawn_sum;
    for (std::size_t k = 0; k < 3; ++k) {
      drawn_sum += mesh.positions[static_cast<std::size_t>(
          display.vertex_of_display_vertex[static_cast<std::size_t>(corners[k])])];
      full_sum += mesh.positions[static_cast<std::size_t>(full[k])];
    }
    // A corner moves by less than the diagonal of a cell.
    EXPECT_LT((drawn_sum - full_sum).norm() / 3, display.cell * std::sqrt(3.0));
    std::sort(corners.begin(), corners.end());
    EXPECT_LT(corners[0], corners[1]);
    EXPECT_LT(corners[1], corners[2]);
    EXPECT_TRUE(seen.insert(corners).second);
  }
}

TEST(DisplayMesh, IsTheMeshWhereThatIsSmall) {
  const TriangleMesh mesh = sheet(10);
  const DisplayMesh display = display_mesh(mesh, 162);
  EXPECT_EQ(display.cell, 0);
  ASSERT_EQ(display.triangles.size(), 162U);
  for (std::size_t t = 0; t < 162; ++t)
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_EQ(display.vertex_of_display_vertex[static_cast<std::size_t>(display.triangles[t][k])],
                mesh.triangles[t][k]);
}

std::vector<std::uint8_t> unpacked(const BlockWriter& writer, std::size_t bytes) {
  std::vector<std::uint8_t> raw(bytes);
  uLongf size = bytes;
  EXPECT_EQ(uncompress(raw.data(), &size, reinterpret_cast<const Bytef*>(writer.bytes().data()), writer.bytes().size()),
            Z_OK);
  EXPECT_EQ(size, bytes);
  return raw;
}

TEST(BlockWriter, CodesDifferencesAsPlanesOfBytes) {
  BlockWriter writer;
  writer.add("x", std::vector<std::int32_t>{5, 4, 300});  // 5, -1, 296: zigzag 10, 1, 592
  EXPECT_EQ(unpacked(writer, 12), (std::vector<std::uint8_t>{10, 1, 0x50, 0, 0, 2, 0, 0, 0, 0, 0, 0}));
  BlockWriter corners;
  corners.add_corners("c", std::vector<std::int32_t>{0, 1, 2, 2, 1, 3});
  EXPECT_EQ(unpacked(corners, 24), (std::vector<std::uint8_t>{0, 0, 0, 1, 2, 0, 0, 0, 0, 0, 0, 0,  //
                                                              0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}));
  BlockWriter steps;
  steps.add("s", std::vector<std::uint16_t>{1, 65535, 0, 65534}, 2);  // 1, -1; -1, -1
  EXPECT_EQ(unpacked(steps, 8), (std::vector<std::uint8_t>{2, 1, 1, 1, 0, 0, 0, 0}));
}

TEST(Base64, AgreesWithTheRfc) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
}

}  // namespace
}  // namespace meshmser
