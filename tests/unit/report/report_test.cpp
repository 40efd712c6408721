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
#include "stages/report/pair_pages.hpp"
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

TEST(Report, FatesOfNodesNameFiltersAndRivals) {
  const TriangleMesh mesh = sheet(3);
  LevelSetTrees trees;
  trees.values.assign(9, 1);
  ComponentTree& tree = trees.trees.emplace_back();
  tree.levels = {0, 1, 2};
  tree.node_of_triangle.assign(8, 0);
  tree.parent_of_node = {2, 2, -1};
  tree.hi_of_node = {3, 3, 1};
  tree.area_of_node = {1, 2, 9};
  tree.area_exponent_of_node = {0, 0, 0};
  Segmentation segmentation = two_regions(mesh);
  using Kind = NodeFate::Kind;
  segmentation.fates = {{{{Kind::kFiltered, 0, -1}, {Kind::kLessStable, -1, 0}, {Kind::kRoot, -1, -1}}}};
  const ReportContents contents{.mesh = &mesh, .trees = &trees, .segmentation = &segmentation};
  const std::string page = written(contents);
  const auto header = nlohmann::json::parse(element(page, "header"));
  EXPECT_EQ(header["trees"][0]["fates"], (std::vector<std::string>{"filtered", "less_stable", "root"}));
  const std::string bytes = bytes_of_base64(element(page, "blocks"));
  const auto block = [&](const std::string& name) {
    for (const auto& b : header["blocks"])
      if (b["name"] == name) {
        std::vector<std::uint8_t> raw(b["count"].get<std::size_t>() * (b["coding"] == "plain8" ? 1 : 4));
        uLongf size = raw.size();
        const std::string part = bytes.substr(b["offset"].get<std::size_t>(), b["size"].get<std::size_t>());
        EXPECT_EQ(uncompress(raw.data(), &size, reinterpret_cast<const Bytef*>(part.data()), part.size()), Z_OK);
        return raw;
      }
    return std::vector<std::uint8_t>();
  };
  EXPECT_EQ(block("upper_fate"), (std::vector<std::uint8_t>{0, 1, 2}));
  EXPECT_EQ(block("upper_filter"), (std::vector<std::uint8_t>{1, 0, 0}));
  // -1, 0, -1 as differences: -1, 1, -1, zigzag 1, 2, 1.
  EXPECT_EQ(block("upper_rival"), (std::vector<std::uint8_t>{1, 2, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0}));
}

TEST(Report, OutputsTellRangeAndHistogramOfTheFullData) {
  const TriangleMesh mesh = sheet(100);
  const auto header = nlohmann::json::parse(element(written({.mesh = &mesh}, {.max_triangles = 2000}), "header"));
  ASSERT_EQ(header["outputs"].size(), 1U);
  EXPECT_EQ(header["outputs"][0]["stage"], "mesh");
  const auto positions = header["outputs"][0]["fields"][0];
  EXPECT_EQ(positions["count"], 10000);
  EXPECT_EQ(positions["columns"][0]["greatest"], 99);
  EXPECT_EQ(positions["columns"][0]["mean"], 49.5);
}

TEST(PairPages, HoldWhatBothShareOnce) {
  const TriangleMesh mesh = sheet(60);
  Segmentation one = two_regions(mesh), two = one;
  two.region_of_label = {0, 2, 1};
  two.label_of_triangle[5] = 0;
  const std::string run = "<script type=\"application/json\" id=\"run\">{\"written\": 1}</script>\n";
  const std::string first = written({.mesh = &mesh, .segmentation = &one}) + run;
  const std::string second = written({.mesh = &mesh, .segmentation = &two});
  const std::string page = pair_pages(first, second, {"a", "b<"});
  EXPECT_LT(page.size(), first.size() + 20000);
  EXPECT_EQ(element(page, "names"), "[\"a\",\"b\\u003c\"]");
  EXPECT_EQ(element(page, "run"), "{\"written\": 1}");
  EXPECT_THAT(page, Not(HasSubstr("id=\"other-run\"")));
  const auto here = nlohmann::json::parse(element(page, "header")),
             there = nlohmann::json::parse(element(page, "other-header"));
  const std::string bytes = bytes_of_base64(element(page, "blocks"));
  // Each block of either page is what it was in that page.
  const auto same = [&](const nlohmann::json& header, const std::string& before) {
    const auto old = nlohmann::json::parse(element(before, "header"));
    const std::string old_bytes = bytes_of_base64(element(before, "blocks"));
    for (const auto& block : header["blocks"])
      for (const auto& was : old["blocks"])
        if (was["name"] == block["name"]) {
          EXPECT_EQ(bytes.substr(block["offset"], block["size"]), old_bytes.substr(was["offset"], was["size"]));
        }
    return header["blocks"].size();
  };
  EXPECT_EQ(same(here, first), here["blocks"].size());
  EXPECT_GE(same(there, second), 4U);
}

TEST(PairPages, TellWhatIsNoPageAndWhatIsLeftOut) {
  const TriangleMesh mesh = sheet(60);
  PointCloud points;
  points.positions = mesh.positions;
  const std::string page = written({.points = &points, .mesh = &mesh});
  EXPECT_THROW(pair_pages("<html>", page, {"a", "b"}), StageError);
  std::string old = page;
  old.replace(old.find("\"page_format\":") + 14, 1, "9");
  EXPECT_THROW(pair_pages(page, old, {"a", "b"}), StageError);
  const std::string whole = pair_pages(page, page, {"a", "b"});
  const std::string smaller = pair_pages(page, page, {"a", "b"}, whole.size() - 1);
  EXPECT_LT(smaller.size(), whole.size());
  EXPECT_EQ(nlohmann::json::parse(element(smaller, "header"))["left_out"], std::vector<std::string>{"points"});
  EXPECT_THROW(pair_pages(page, page, {"a", "b"}, page_template().size()), StageError);
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
  std::string bytes;
  for (int i = 0; i < 300; ++i) {
    EXPECT_EQ(bytes_of_base64(base64(bytes)), bytes);
    bytes += static_cast<char>(i * 37);
  }
}

}  // namespace
}  // namespace meshmser
