/// Reading and ordering of a scan: a shuffled noisy sheet of 0.5 and 2.5 million points, as text and as binary PLY.

#include <benchmark/benchmark.h>

#include <filesystem>
#include <random>

#include "pipeline/formats/geometry_file.hpp"
#include "pipeline/formats/output_file.hpp"
#include "pipeline/formats/ply.hpp"
#include "stages/load/load_scan.hpp"
#include "tests/support/temporary_files.hpp"

namespace meshmser {
namespace {

Eigen::Vector3d next_point(std::mt19937& random) {
  std::uniform_real_distribution<double> across(0, 100), noise(-0.02, 0.02);
  const double x = across(random), y = across(random);
  return {x, y, std::sin(x / 5) * std::cos(y / 7) + noise(random)};
}

std::filesystem::path write_scan(const TemporaryFolder& folder, std::int64_t n, bool text) {
  std::mt19937 random(1);
  const std::filesystem::path path = folder.path() / (text ? "scan.xyz" : "scan.ply");
  if (text) {
    OutputFile file(path);
    char line[96];
    for (std::int64_t i = 0; i < n; ++i) {
      const Eigen::Vector3d p = next_point(random);
      file.bytes(line,
                 static_cast<std::size_t>(std::snprintf(line, sizeof line, "%.5f %.5f %.5f\n", p.x(), p.y(), p.z())));
    }
    file.finish();
  } else {
    PlyWriter writer(path, n, {{"x", ValueType::kFloat32}, {"y", ValueType::kFloat32}, {"z", ValueType::kFloat32}});
    for (std::int64_t i = 0; i < n; ++i) {
      const Eigen::Vector3d p = next_point(random);
      writer.add_vertex(std::array{p.x(), p.y(), p.z()});
    }
    writer.finish();
  }
  return path;
}

void read_scan(benchmark::State& state, bool text) {
  const TemporaryFolder folder;
  const std::filesystem::path path = write_scan(folder, state.range(0), text);
  for (auto _ : state) benchmark::DoNotOptimize(read_geometry_file(path));
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
void read_text(benchmark::State& state) {
  read_scan(state, true);
}
void read_binary(benchmark::State& state) {
  read_scan(state, false);
}

void order_and_measure(benchmark::State& state) {
  const TemporaryFolder folder;
  const Geometry geometry = read_geometry_file(write_scan(folder, state.range(0), false)).front();
  for (auto _ : state) {
    PosedScan scan;
    scan.geometry = geometry;
    benchmark::DoNotOptimize(load_scan({std::move(scan)}));
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
}

BENCHMARK(read_text)
    ->Arg(500'000)
    ->Arg(2'500'000)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();
BENCHMARK(read_binary)
    ->Arg(500'000)
    ->Arg(2'500'000)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();
BENCHMARK(order_and_measure)
    ->Arg(500'000)
    ->Arg(2'500'000)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

}  // namespace
}  // namespace meshmser

BENCHMARK_MAIN();
