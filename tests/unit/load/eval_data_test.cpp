#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>

#include "pipeline/formats/geometry_file.hpp"
#include "pipeline/formats/stanford_conf.hpp"
#include "stages/load/load_scan.hpp"
#include "stages/load/pass_distance.hpp"

namespace meshmser {
namespace {

/// Real scans, where the variable MESHMSER_EVAL_DATA says.
class EvalData : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("MESHMSER_EVAL_DATA");
    if (folder == nullptr) GTEST_SKIP() << "set MESHMSER_EVAL_DATA to the folder of evaluation scans to run this";
    folder_ = folder;
  }
  std::vector<std::filesystem::path> files(const std::string& subfolder, const std::string& extension) const {
    std::vector<std::filesystem::path> found;
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / subfolder))
      if (entry.path().extension() == extension) found.push_back(entry.path());
    std::sort(found.begin(), found.end());
    return found;
  }
  static LoadedScan load(const std::filesystem::path& path, const LoadScanOptions& options = {}) {
    std::vector<PosedScan> scans;
    for (Geometry& geometry : read_geometry_file(path))
      scans.push_back({std::move(geometry), Eigen::Isometry3d::Identity(), {}});
    return load_scan(std::move(scans), options);
  }
  std::filesystem::path folder_;
};

TEST_F(EvalData, SherdsHaveTheirSpacing) {
  for (const auto& path : files("sherds", ".xyz")) {
    const LoadedScan loaded = load(path);
    EXPECT_GT(loaded.points.num_points(), 40'000u) << path;
    EXPECT_GT(loaded.points.spacing, 0.09) << path;
    EXPECT_LT(loaded.points.spacing, 0.22) << path;
    EXPECT_FALSE(loaded.mesh.has_value());
  }
}

TEST_F(EvalData, SimulatedScansHaveTheirSpacing) {
  const std::map<std::string, double> spacings{
      {"pump_0.3", 0.162}, {"bracket_0.1", 0.122}, {"diamond_0.1", 0.126}, {"tablet_0.3", 0.102}};
  for (const auto& path : files("simulated", ".ply")) {
    const LoadedScan loaded = load(path);
    const auto known = spacings.find(path.stem().string());
    if (known != spacings.end()) {
      EXPECT_NEAR(loaded.points.spacing, known->second, 0.0015) << path;
    }
    EXPECT_EQ(loaded.points.num_points() + loaded.points.dropped_raw_index.size(),
              static_cast<std::size_t>(loaded.points.num_raw_points));
  }
}

TEST_F(EvalData, PartsAreMeshes) {
  for (const auto& path : files("parts", ".ply")) {
    const LoadedScan loaded = load(path);
    ASSERT_TRUE(loaded.mesh.has_value()) << path;
    EXPECT_EQ(loaded.report.mesh.num_degenerate, 0) << path;
    EXPECT_EQ(loaded.report.mesh.num_inside_out, path.stem() == "casting" ? 1 : 0) << path;
  }
}

TEST_F(EvalData, RangeMapsOfTheBunnyLieOnEachOther) {
  std::vector<PosedScan> scans;
  for (const PosedFile& file : read_stanford_conf(read_file_bytes(folder_ / "bunny" / "bun.conf")))
    scans.push_back({read_geometry_file(file.path).at(0), file.world_from_file, {}});
  ASSERT_EQ(scans.size(), 10u);
  const LoadedScan loaded = load_scan(std::move(scans));
  const PassDistances distances = measure_pass_distances(loaded.points);
  EXPECT_GT(distances.num_samples, 1000);
  // Neighbouring maps lie about 0.3 mm apart.
  EXPECT_LT(distances.median_distance, 0.0005);
  for (const Scan& scan : loaded.points.scans) EXPECT_TRUE(scan.scanner_position.has_value());
}

}  // namespace
}  // namespace meshmser
