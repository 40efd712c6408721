/// Speed and peak memory of the mesh stage on a noisy ring scanned evenly, in us of processor time a point.
///
///   mesh_bench [--benchmark_filter=...]   0.5M and 2.5M points; advancing front at 0.1M and 0.5M
///   MESHMSER_BENCH_LARGE=1 mesh_bench     and 10M, advancing front at 2.5M

#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <cmath>
#include <cstdlib>
#include <map>
#include <memory>
#include <numbers>
#include <random>
#include <string>

#include "stages/mesh/close_loops.hpp"
#include "stages/mesh/local_delaunay.hpp"
#include "stages/mesh/mesh_points.hpp"
#include "stages/mesh/refit_normals.hpp"

namespace meshmser::bench {
namespace {

constexpr double kMaxEdge = 5;

struct BenchCloud {
  PointCloud cloud;
  PointNormals normals;
};

/// A ring about z of about `num_points` points at spacing 1, in blocks of space as the load stage orders them:
/// uniformly random on the surface, a twentieth of a spacing of noise, as smoothing leaves it, on positions and 0.1 on
/// normals.
const BenchCloud& ring(std::int64_t num_points) {
  static std::map<std::int64_t, std::unique_ptr<BenchCloud>> made;
  auto& ring = made[num_points];
  if (ring) return *ring;
  ring = std::make_unique<BenchCloud>();
  // 4 pi^2 R r points with R = 3 r.
  const double r = std::sqrt(static_cast<double>(num_points) / 12) / std::numbers::pi, big = 3 * r;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> share(0, 1);
  std::normal_distribution<double> noise(0, 0.05), tilt(0, 0.1);
  const auto rows = static_cast<int>(2 * std::numbers::pi * big / 16),
             columns = static_cast<int>(2 * std::numbers::pi * r / 16);
  const double per_cell = static_cast<double>(num_points) / rows / columns;
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j) {
      const double b0 = 2 * std::numbers::pi * (j + 0.5) / columns;
      const auto n = static_cast<int>(per_cell * (1 + std::cos(b0) / 3) + share(random));
      for (int k = 0; k < n; ++k) {
        const double a = 2 * std::numbers::pi * (i + share(random)) / rows,
                     b = 2 * std::numbers::pi * (j + share(random)) / columns;
        const Eigen::Vector3d normal(std::cos(b) * std::cos(a), std::cos(b) * std::sin(a), std::sin(b));
        ring->cloud.positions.push_back(Eigen::Vector3d(big * std::cos(a), big * std::sin(a), 0) +
                                        (r + noise(random)) * normal);
        ring->normals.normals.push_back(
            (normal + Eigen::Vector3d(tilt(random), tilt(random), tilt(random))).normalized());
      }
    }
  ring->cloud.spacing = 1;
  ring->normals.component_of_point.assign(ring->cloud.num_points(), 0);
  ring->normals.components = {{static_cast<std::int64_t>(ring->cloud.num_points()), SignSource::kScanner, 1, false}};
  return *ring;
}

Execution with_threads(std::int64_t threads) {
  Execution execution;
  execution.threads = static_cast<int>(threads);
  return execution;
}

/// The processor time of this process, in microseconds.
double processor_time() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto us = [](const timeval& t) { return static_cast<double>(t.tv_sec) * 1e6 + static_cast<double>(t.tv_usec); };
  return us(usage.ru_utime) + us(usage.ru_stime);
}

/// Processor time a point since `start`, and the peak memory of the whole process so far.
void tell(benchmark::State& state, double start, std::size_t num_points) {
  state.counters["us_per_point"] =
      (processor_time() - start) / static_cast<double>(state.iterations()) / static_cast<double>(num_points);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  state.counters["peak_MB"] = static_cast<double>(usage.ru_maxrss) / 1024;
}

void whole(benchmark::State& state, MeshMethod method) {
  const BenchCloud& points = ring(state.range(0));
  std::int64_t triangles = 0;
  const double start = processor_time();
  for (auto _ : state) {
    const MeshedPoints made =
        mesh_points(points.cloud, points.normals, nullptr, {method, kMaxEdge, 12}, with_threads(state.range(1)));
    triangles = static_cast<std::int64_t>(made.mesh.num_triangles());
  }
  tell(state, start, points.cloud.num_points());
  state.counters["triangles"] = static_cast<double>(triangles);
}

void local_delaunay_whole(benchmark::State& state) {
  whole(state, MeshMethod::kLocalDelaunay);
}
void advancing_front_whole(benchmark::State& state) {
  whole(state, MeshMethod::kAdvancingFront);
}

void refit(benchmark::State& state) {
  const BenchCloud& points = ring(state.range(0));
  const double start = processor_time();
  for (auto _ : state)
    benchmark::DoNotOptimize(
        refit_normals(points.cloud.positions, points.normals.normals, 1, kMaxEdge, with_threads(state.range(1))));
  tell(state, start, points.cloud.num_points());
}

void votes(benchmark::State& state) {
  const BenchCloud& points = ring(state.range(0));
  const auto normals = refit_normals(points.cloud.positions, points.normals.normals, 1, kMaxEdge);
  const double start = processor_time();
  for (auto _ : state)
    benchmark::DoNotOptimize(
        local_delaunay(points.cloud.positions, normals, 1, kMaxEdge, with_threads(state.range(1))));
  tell(state, start, points.cloud.num_points());
}

void loops(benchmark::State& state) {
  const BenchCloud& points = ring(state.range(0));
  const auto normals = refit_normals(points.cloud.positions, points.normals.normals, 1, kMaxEdge);
  const auto triangles = local_delaunay(points.cloud.positions, normals, 1, kMaxEdge);
  const double start = processor_time();
  for (auto _ : state) {
    auto closed = triangles;
    close_loops(closed, points.cloud.positions, normals, nullptr, kMaxEdge, 12);
    benchmark::DoNotOptimize(closed);
  }
  tell(state, start, points.cloud.num_points());
}

void sizes(benchmark::internal::Benchmark* benchmark) {
  benchmark->Unit(benchmark::kMillisecond)->UseRealTime()->ArgNames({"points", "threads"});
  for (const std::int64_t threads : {1, 2})
    for (const std::int64_t points : {500'000, 2'500'000}) benchmark->Args({points, threads});
  if (std::getenv("MESHMSER_BENCH_LARGE") != nullptr) benchmark->Args({10'000'000, 2});
}
void front_sizes(benchmark::internal::Benchmark* benchmark) {
  benchmark->Unit(benchmark::kMillisecond)->UseRealTime()->Iterations(1)->ArgNames({"points", "threads"});
  for (const std::int64_t points : {100'000, 500'000}) benchmark->Args({points, 1});
  if (std::getenv("MESHMSER_BENCH_LARGE") != nullptr) benchmark->Args({2'500'000, 1});
}

BENCHMARK(refit)->Apply(sizes);
BENCHMARK(votes)->Apply(sizes);
BENCHMARK(loops)
    ->ArgNames({"points", "threads"})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->Args({500'000, 1})
    ->Args({2'500'000, 1});
BENCHMARK(local_delaunay_whole)->Apply(sizes);
BENCHMARK(advancing_front_whole)->Apply(front_sizes);

}  // namespace
}  // namespace meshmser::bench

BENCHMARK_MAIN();
