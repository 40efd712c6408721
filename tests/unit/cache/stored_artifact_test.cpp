// Artifacts written, read back and compared field by field; files that are not what they should be.
#include "pipeline/formats/stored_artifact.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>

#include "pipeline/execution/error.hpp"
#include "pipeline/formats/npy.hpp"
#include "pipeline/stage/stage.hpp"

namespace meshmser {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// Files in memory.
class MemorySource : public StoredFileSource {
 public:
  std::map<std::string, std::string> files;
  std::uint64_t size(const std::string& name) override {
    if (!files.contains(name)) throw CacheError(name + " is missing");
    return files[name].size();
  }
  void read(const std::string& name, std::uint64_t offset, std::span<std::byte> to) override {
    const std::string& text = files.at(name);
    ASSERT_LE(offset + to.size(), text.size());
    std::copy_n(text.data() + offset, to.size(), reinterpret_cast<char*>(to.data()));
  }
  void check(const std::string& name, std::span<const std::byte> header, std::span<const std::byte> content) override {
    EXPECT_EQ(header.size() + content.size(), files.at(name).size()) << name;
  }
};

MemorySource store(const Artifact& artifact) {
  MemorySource source;
  for (const StoredFile& file : stored_files(artifact))
    source.files[file.name] =
        file.header + std::string(reinterpret_cast<const char*>(file.content.data()), file.content.size());
  return source;
}

template <class T>
T round_trip(const T& value) {
  MemorySource source = store(std::make_shared<const T>(value));
  return *std::get<Shared<T>>(load_stored_artifact(artifact_index<T>(), source, "somewhere", 3));
}

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

TEST(StoredArtifact, PointCloudComesBack) {
  PointCloud cloud;
  cloud.origin = {1e6 + 0.1, -0.0, 1.0 / 3};
  cloud.spacing = 0.1;
  cloud.positions = {{1, 2, 3}, {4, kNan, -kInf}};
  cloud.raw_index_of_point = {1, std::int64_t{1} << 40};
  cloud.scan_of_point = {0, 4000000000U};
  cloud.scans = {{"a \"b\"\nü.ply", Eigen::Vector3d(1, 2, 3), 7}, {"", std::nullopt, 0}};
  cloud.properties = {{"intensity", ValueType::kUint8, {1, 2}}, {"quality", ValueType::kFloat64, {kNan, 1e-300}}};
  cloud.num_raw_points = 3;
  cloud.dropped_raw_index = {2};
  cloud.dropped_positions = {{0, 0, 0}};
  cloud.drop_reasons = {DropReason::kOutlier};
  cloud.kept_point_of_dropped = {-1};
  const PointCloud back = round_trip(cloud);
  EXPECT_EQ(back.origin, cloud.origin);
  EXPECT_TRUE(std::signbit(back.origin.y()));
  EXPECT_EQ(back.spacing, cloud.spacing);
  ASSERT_EQ(back.positions.size(), 2U);
  EXPECT_EQ(back.positions[0], cloud.positions[0]);
  EXPECT_TRUE(std::isnan(back.positions[1].y()));
  EXPECT_EQ(back.positions[1].z(), -kInf);
  EXPECT_EQ(back.raw_index_of_point, cloud.raw_index_of_point);
  EXPECT_EQ(back.scan_of_point, cloud.scan_of_point);
  ASSERT_EQ(back.scans.size(), 2U);
  EXPECT_EQ(back.scans[0].name, cloud.scans[0].name);
  EXPECT_EQ(back.scans[0].scanner_position, cloud.scans[0].scanner_position);
  EXPECT_EQ(back.scans[1].scanner_position, std::nullopt);
  ASSERT_EQ(back.properties.size(), 2U);
  EXPECT_EQ(back.properties[0].type, ValueType::kUint8);
  EXPECT_EQ(back.properties[0].values, cloud.properties[0].values);
  EXPECT_EQ(back.properties[1].values[1], 1e-300);
  EXPECT_EQ(back.drop_reasons, cloud.drop_reasons);
  EXPECT_EQ(back.kept_point_of_dropped, cloud.kept_point_of_dropped);
}

TEST(StoredArtifact, FlatRecordsGoByColumns) {
  Segmentation segmentation;
  Region region;
  region.polarity = Polarity::kLower;
  region.node = 5;
  region.stability = kInf;
  region.centroid = {1, 2, 3};
  segmentation.regions = {Region{}, region};
  segmentation.filters = {{"min_area", 10, 3}};
  segmentation.label_of_triangle = {0, 1, 2};
  const MemorySource source = store(std::make_shared<const Segmentation>(segmentation));
  EXPECT_TRUE(source.files.contains("regions.stability.npy"));
  EXPECT_FALSE(source.files.contains("regions.0.stability.npy"));
  const Segmentation back = round_trip(segmentation);
  ASSERT_EQ(back.regions.size(), 2U);
  EXPECT_EQ(back.regions[0].node, -1);
  EXPECT_EQ(back.regions[1].polarity, Polarity::kLower);
  EXPECT_EQ(back.regions[1].node, 5);
  EXPECT_EQ(back.regions[1].parent, -1);
  EXPECT_EQ(back.regions[1].stability, kInf);
  EXPECT_EQ(back.regions[1].centroid, Eigen::Vector3d(1, 2, 3));
  ASSERT_EQ(back.filters.size(), 1U);
  EXPECT_EQ(back.filters[0].filter, "min_area");
  EXPECT_EQ(back.filters[0].removed, 3);
  EXPECT_EQ(back.label_of_triangle, segmentation.label_of_triangle);
}

TEST(StoredArtifact, FlagsAndNestedListsComeBack) {
  PointNormals normals;
  normals.components = {{5, SignSource::kScanner, 0.25, true}, {2, SignSource::kGuess, 0, false}};
  const PointNormals back = round_trip(normals);
  ASSERT_EQ(back.components.size(), 2U);
  EXPECT_EQ(back.components[0].num_points, 5);
  EXPECT_EQ(back.components[0].source, SignSource::kScanner);
  EXPECT_TRUE(back.components[0].flipped_by_user);
  EXPECT_FALSE(back.components[1].flipped_by_user);

  LevelSetTrees trees;
  trees.scalar = "height";
  trees.trees.resize(2);
  trees.trees[1].polarity = Polarity::kLower;
  trees.trees[1].levels = {-kInf, 0, 1};
  trees.trees[1].node_of_triangle = {3, -1};
  const LevelSetTrees trees_back = round_trip(trees);
  EXPECT_TRUE(std::isnan(trees_back.noise));
  ASSERT_EQ(trees_back.trees.size(), 2U);
  EXPECT_EQ(trees_back.trees[1].levels, trees.trees[1].levels);
  EXPECT_EQ(trees_back.trees[1].node_of_triangle, trees.trees[1].node_of_triangle);

  TriangleMesh mesh;
  mesh.triangles = {{0, 1, 2}, {2, 1, 3}};
  EXPECT_EQ(round_trip(mesh).triangles, mesh.triangles);
}

TEST(StoredArtifact, EmptyArtifactsOfEveryTypeComeBack) {
  const auto check = []<class T>(const T& value) {
    const auto artifact = std::make_shared<const T>(value);
    MemorySource source = store(artifact);
    const Artifact back = load_stored_artifact(artifact_index<T>(), source, "", 1);
    EXPECT_EQ(store(back).files, source.files) << kArtifactInfo<T>.name;
  };
  check(PointCloud{});
  check(PointNormals{});
  check(SmoothedPoints{});
  check(ScalarFields{});
  check(TriangleMesh{});
  check(LevelSetTrees{});
  check(Segmentation{});
  check(BorderSet{});
  check(FileSet{"somewhere", {"a.ply", "b.csv"}});
}

TEST(StoredArtifact, RefusesWhatItDidNotWrite) {
  TriangleMesh mesh;
  mesh.positions = {{1, 2, 3}};
  mesh.triangles = {{0, 0, 0}};
  const MemorySource good = store(std::make_shared<const TriangleMesh>(mesh));
  const auto message = [](MemorySource source, std::size_t type) -> std::string {
    try {
      load_stored_artifact(type, source, "", 1);
    } catch (const CacheError& error) {
      return error.what();
    }
    return "accepted";
  };
  const std::size_t type = artifact_index<TriangleMesh>();
  EXPECT_EQ(message(good, type), "accepted");
  EXPECT_THAT(message(good, artifact_index<PointCloud>()), HasSubstr("its head"));
  MemorySource bad = good;
  bad.files["artifact.json"] = "{";
  EXPECT_THAT(message(bad, type), HasSubstr("its head"));
  bad = good;
  bad.files.erase("triangles.npy");
  EXPECT_THAT(message(bad, type), HasSubstr("missing"));
  bad = good;
  bad.files["triangles.npy"] = good.files.at("positions.npy");
  EXPECT_THAT(message(bad, type), HasSubstr("not the array"));
  bad = good;
  bad.files["positions.npy"].pop_back();
  EXPECT_THAT(message(bad, type), HasSubstr("not the array"));
  bad = good;
  const std::size_t at = bad.files["artifact.json"].find("\"spacing\"");
  bad.files["artifact.json"][at + 1] = 'S';
  EXPECT_THAT(message(bad, type), HasSubstr("spacing is not"));
}

TEST(Npy, HeaderIsNumPysAndAligned) {
  const std::string header = npy_header({"<f8", 7, 3});
  EXPECT_EQ(header.size() % 64, 0U);
  EXPECT_THAT(header, HasSubstr("{'descr': '<f8', 'fortran_order': False, 'shape': (7, 3), }"));
  const auto parsed = parse_npy_header(std::as_bytes(std::span<const char>(header)));
  ASSERT_TRUE(parsed);
  EXPECT_EQ(parsed->shape, (NpyShape{"<f8", 7, 3}));
  EXPECT_EQ(parsed->size, header.size());
  const std::string flat = npy_header({"|u1", 0, 0});
  EXPECT_THAT(flat, HasSubstr("'shape': (0,)"));
  EXPECT_EQ(parse_npy_header(std::as_bytes(std::span<const char>(flat)))->shape, (NpyShape{"|u1", 0, 0}));
  for (std::size_t cut = 0; cut < header.size(); ++cut)
    EXPECT_FALSE(parse_npy_header(std::as_bytes(std::span<const char>(header.data(), cut)))) << cut;
}

TEST(FieldStatistics, TellsEveryField) {
  ScalarFields fields;
  fields.fields = {{"height", "unit", Parity::kOdd, kNan, {1, kNan, 3, 2}}};
  fields.radius = 0.5;
  const auto statistics = field_statistics(std::make_shared<const ScalarFields>(fields));
  std::map<std::string, FieldStatistics> by_name;
  for (const FieldStatistics& field : statistics) by_name[field.name] = field;
  EXPECT_EQ(by_name.at("radius").text, "0.5");
  EXPECT_EQ(by_name.at("fields.0.name").text, "\"height\"");
  const FieldStatistics& values = by_name.at("fields.0.values");
  EXPECT_THAT(values.shape, ElementsAre(4U));
  EXPECT_EQ(values.type, "<f8");
  EXPECT_EQ(values.columns.at(0).least, 1);
  EXPECT_EQ(values.columns.at(0).greatest, 3);
  EXPECT_EQ(values.columns.at(0).mean, 2);
  EXPECT_EQ(values.columns.at(0).num_not_finite, 1U);
  EXPECT_EQ(values.columns.at(0).histogram.front(), 1U);
  EXPECT_EQ(values.columns.at(0).histogram.back(), 1U);
}

}  // namespace
}  // namespace meshmser
