/// Every stage of a configuration on virtual scans of the pump of growing size, from a cold cache: processor and wall
/// time, time a point, its growth from size to size, peak memory.
///
///   run_bench CONFIG [POINTS ...]                         sizes ascending; 500000 and 2500000 if none are given
///   run_bench CONFIG --set mesh.method=advancing_front    parameters as of `meshmser run`

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <map>
#include <string>
#include <vector>

#include "data/scanner/scan_files.hpp"
#include "data/scanner/shapes.hpp"
#include "data/scanner/virtual_scanner.hpp"
#include "pipeline/run/runner.hpp"
#include "tests/support/temporary_files.hpp"

namespace meshmser::bench {
namespace {

class Silence : public RunObserver {
  void stage_started(const StageRecord&, std::size_t, std::size_t) override {}
  void progress(std::string_view, std::int64_t, std::int64_t) override {}
  void stage_finished(const StageRecord&, std::size_t, std::size_t) override {}
  void note(const std::string&) override {}
};

/// 19 overlapping passes, noise of .3 of a pass's spacing, four holes; the number of points written.
std::int64_t write_scan(const std::filesystem::path& path, std::int64_t num_points) {
  const scanner::ShapeInfo& info = scanner::shape_info("pump");
  const scanner::Shape shape = scanner::make_shape(info.name);
  const scanner::Extent extent = scanner::extent_of(shape.mesh);
  const auto poses =
      scanner::poses_around(extent.centre, 6 * extent.radius, info.views, info.cone, Eigen::Vector3d::UnitZ());
  scanner::ScanOptions options;
  options.holes = 4;
  options.spacing = scanner::spacing_for_points(shape, poses, options, num_points);
  const scanner::SimulatedScan scan = scanner::scan_shape(shape, poses, options);
  std::vector<std::uint32_t> all(scan.points.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::uint32_t>(i);
  scanner::write_points(path, scan.points, all, {});
  return static_cast<std::int64_t>(scan.points.size());
}

int bench(const std::string& config, const std::vector<std::int64_t>& sizes, const std::vector<std::string>& set) {
  std::map<std::string, double> us_before;
  double doublings = 0, points_before = 0;
  for (const std::int64_t size : sizes) {
    const TemporaryFolder folder;
    const std::int64_t points = write_scan(folder.path() / "scan.ply", size);
    std::vector<std::string> overrides{"load.path=" + (folder.path() / "scan.ply").string()};
    overrides.insert(overrides.end(), set.begin(), set.end());
    RunOptions options;
    options.out = (folder.path() / "out").string();
    options.cache = (folder.path() / "cache").string();
    Silence silence;
    const RunResult result = run(load_configuration(config, overrides), options, {}, silence);
    std::printf("%lld points\n%-12s %9s %9s %11s %10s %9s\n", static_cast<long long>(points), "stage", "CPU s",
                "wall s", "us a point", "x doubling", "peak GiB");
    if (points_before > 0) doublings = std::log2(static_cast<double>(points) / points_before);
    points_before = static_cast<double>(points);
    double cpu = 0, wall = 0;
    const auto tell = [&](const std::string& name, double cpu_seconds, double wall_seconds, double peak) {
      const double us = 1e6 * cpu_seconds / static_cast<double>(points);
      double& before = us_before[name];
      std::printf("%-12s %9.2f %9.2f %11.2f ", name.c_str(), cpu_seconds, wall_seconds, us);
      if (before > 0)
        std::printf("%10.2f ", std::pow(us / before, 1 / doublings));
      else
        std::printf("%10s ", "");
      before = us;
      std::printf("%9.2f\n", peak / (1 << 30));
    };
    double peak = 0;
    for (const StageRecord& stage : result.stages) {
      tell(stage.name, stage.cpu_seconds, stage.wall_seconds, static_cast<double>(stage.peak_bytes));
      cpu += stage.cpu_seconds, wall += stage.wall_seconds;
      peak = std::max(peak, static_cast<double>(stage.peak_bytes));
    }
    tell("all", cpu, wall, peak);
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace
}  // namespace meshmser::bench

int main(int count, char** values) {
  std::string config;
  std::vector<std::int64_t> sizes;
  std::vector<std::string> set;
  for (int i = 1; i < count; ++i) {
    const std::string word = values[i];
    if (word == "--set" && i + 1 < count)
      set.emplace_back(values[++i]);
    else if (config.empty())
      config = word;
    else
      sizes.push_back(std::atoll(word.c_str()));
  }
  if (config.empty()) {
    std::fprintf(stderr, "usage: run_bench CONFIG [--set STAGE.KEY=VALUE] [POINTS ...]\n");
    return 2;
  }
  if (sizes.empty()) sizes = {500'000, 2'500'000};
  try {
    return meshmser::bench::bench(config, sizes, set);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "run_bench: %s\n", error.what());
    return 1;
  }
}
