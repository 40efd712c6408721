// Orientation and curvature of a noisy torus in canonical order, at 0.5 and 2.5 million points, and their parts.
#include <benchmark/benchmark.h>

#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "stages/common/cell_grid.hpp"
#include "stages/common/nearest_neighbors.hpp"
#include "stages/curvature/curvature.hpp"
#include "stages/curvature/quadric.hpp"
#include "stages/curvature/scale_space.hpp"
#include "stages/load/load_scan.hpp"
#include "stages/orient/orient.hpp"

namespace {

using namespace meshmser;
using Eigen::Vector3d;

struct Prepared {
  PointCloud cloud;
  PointNormals normals;
};

// Uniformly sampled, with noise of .3 spacings along the normal.
const Prepared& prepared(std::int64_t num_points) {
  static std::map<std::int64_t, Prepared> made;
  const auto [entry, is_new] = made.try_emplace(num_points);
  if (!is_new) return entry->second;
  constexpr double kMajor = 3, kMinor = 1;
  const double area = 4 * std::numbers::pi * std::numbers::pi * kMajor * kMinor;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> turn(0, 2 * std::numbers::pi), share(0, 1);
  std::normal_distribution<double> noise(0, 0.3 * std::sqrt(area / static_cast<double>(num_points)));
  PosedScan scan;
  while (static_cast<std::int64_t>(scan.geometry.positions.size()) < num_points) {
    const double u = turn(random), v = turn(random);
    if (share(random) * (kMajor + kMinor) > kMajor + kMinor * std::cos(v)) continue;
    const Vector3d out(std::cos(u), std::sin(u), 0);
    const Vector3d normal = std::cos(v) * out + Vector3d(0, 0, std::sin(v));
    scan.geometry.positions.push_back(kMajor * out + (kMinor + noise(random)) * normal);
  }
  entry->second.cloud = load_scan({scan}).points;
  entry->second.normals = orient(entry->second.cloud, {}).normals;
  return entry->second;
}

Execution one_thread() {
  Execution execution;
  execution.threads = 1;
  return execution;
}

template <class Work>
void measure(benchmark::State& state, Work&& work) {
  const Prepared& p = prepared(state.range(0));
  for (auto _ : state) benchmark::DoNotOptimize(work(p));
  state.SetItemsProcessed(state.iterations() * state.range(0));
}

void neighbors(benchmark::State& state) {
  measure(state, [](const Prepared& p) { return nearest_neighbors(p.cloud.positions, 12, one_thread()); });
}
void orientation(benchmark::State& state) {
  measure(state, [](const Prepared& p) { return orient(p.cloud, {}, one_thread()); });
}
// What two radii could share at most: the grid of their first step.
void grid_of_one_step(benchmark::State& state) {
  measure(state, [](const Prepared& p) { return CellGrid(p.cloud.positions, 2 * p.cloud.spacing).num_points(); });
}
void scale_space_of_four_steps(benchmark::State& state) {
  measure(state, [](const Prepared& p) {
    return scale_space(p.cloud.positions, p.normals.normals, {4 * p.cloud.spacing, 4}, one_thread());
  });
}
void quadrics(benchmark::State& state) {
  measure(state, [](const Prepared& p) {
    return fit_quadrics(p.cloud.positions, p.normals.normals, 3.5 * p.cloud.spacing, one_thread());
  });
}
void curvature(benchmark::State& state) {
  measure(state, [](const Prepared& p) {
    CurvatureOptions options;
    options.radius = 4 * p.cloud.spacing;
    return measure_curvature(p.cloud, p.normals, options, one_thread());
  });
}

#define MESHMSER_SIZES(name) BENCHMARK(name)->Arg(500000)->Arg(2500000)->Unit(benchmark::kMillisecond)
MESHMSER_SIZES(neighbors);
MESHMSER_SIZES(orientation);
MESHMSER_SIZES(grid_of_one_step);
MESHMSER_SIZES(scale_space_of_four_steps);
MESHMSER_SIZES(quadrics);
MESHMSER_SIZES(curvature);

}  // namespace

BENCHMARK_MAIN();
