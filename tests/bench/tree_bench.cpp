/// Speed of adjacency, levels, tree, selection, labels, borders and cleaning on one thread or more, beside a plain
/// reference on the same mesh in the same run. Times are in ns a triangle, of the clock on the wall; where other
/// programs run beside it, the column CPU is to be trusted for one thread. memory_bench tells what memory they take.
///
///   tree_bench [--benchmark_filter=...]   sizes up to 4M triangles
///   MESHMSER_BENCH_LARGE=1 tree_bench     and 40M triangles

#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <memory>
#include <numeric>
#include <string>
#include <utility>

#include "stages/borders/borders.hpp"
#include "stages/common/adjacency.hpp"
#include "stages/mser/border_contrast.hpp"
#include "stages/mser/describe_regions.hpp"
#include "stages/mser/filters.hpp"
#include "stages/mser/grow.hpp"
#include "stages/mser/label_triangles.hpp"
#include "stages/mser/patches.hpp"
#include "stages/mser/segment.hpp"
#include "stages/mser/select_mser.hpp"
#include "stages/mser/stability.hpp"
#include "stages/tree/component_tree.hpp"
#include "stages/tree/levels.hpp"
#include "stages/tree/tree_of_shapes.hpp"
#include "tests/bench/bench_mesh.hpp"
#include "tests/bench/plain_reference.hpp"

namespace meshmser::bench {
namespace {

constexpr double kNoise = 0.05;  ///< said to be that of the scalar, in its unit

struct Setting {
  std::int64_t triangles;
  Shape shape;
  Scalar scalar;
  Ids ids;
  auto operator<=>(const Setting&) const = default;

  std::string name() const {
    std::string text =
        triangles >= 1000000 ? std::to_string(triangles / 1000000) + "M" : std::to_string(triangles / 1000) + "k";
    text += shape == Shape::kSphere ? "/sphere" : "/field";
    text += scalar == Scalar::kRough ? "/rough" : "/smooth";
    return text + (ids == Ids::kShuffled ? "/shuffled" : "/ordered");
  }
};

/// A mesh with all that the steps before make of it.
struct Prepared {
  BenchMesh mesh;
  std::vector<std::int32_t> twins;
  std::vector<double> areas, levels;
  std::vector<std::int32_t> level_of_triangle;
  ComponentTree tree;
  std::vector<double> value_of_triangle;

  SurfaceView surface() const { return {mesh.positions, mesh.triangles, twins}; }
};

Execution threads(int count) {
  Execution execution;
  execution.threads = count;
  return execution;
}

void finish(Prepared& p) {
  p.twins = twin_half_edges(p.mesh.triangles, p.mesh.positions.size());
  p.areas = triangle_areas(p.mesh.positions, p.mesh.triangles);
  p.level_of_triangle = levels_of_triangles(p.mesh.triangles, levels_of_vertices(p.mesh.values, p.levels, 1), {});
  p.tree = build_component_tree(p.twins, p.areas, p.level_of_triangle, static_cast<std::int32_t>(p.levels.size()));
  p.tree.levels = p.levels;
  p.value_of_triangle.clear();
  for (const auto& t : p.mesh.triangles)
    p.value_of_triangle.push_back(
        std::min({p.mesh.values[static_cast<std::size_t>(t[0])], p.mesh.values[static_cast<std::size_t>(t[1])],
                  p.mesh.values[static_cast<std::size_t>(t[2])]}));
}

/// The last mesh asked for is kept: benchmarks of one mesh stand together.
const Prepared& prepared(const Setting& setting) {
  static std::unique_ptr<std::pair<Setting, Prepared>> last;
  if (!last || last->first != setting) {
    last.reset();
    last = std::make_unique<std::pair<Setting, Prepared>>(setting, Prepared{});
    Prepared& p = last->second;
    p.mesh = make_bench_mesh(setting.triangles, setting.shape, setting.scalar, setting.ids);
    LevelParameters parameters;
    parameters.count = 256;
    p.levels = make_levels(p.mesh.values, {}, parameters, false);
    finish(p);
  }
  return last->second;
}

void count_triangles(benchmark::State& state, const Prepared& p) {
  const auto n = static_cast<double>(p.mesh.triangles.size());
  state.counters["ns/triangle"] =
      benchmark::Counter(n * 1e-9, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  state.counters["peak MB"] = static_cast<double>(usage.ru_maxrss) / 1024;
}

/// What the stage mser does by default between selection and labels, and the watershed: on a grid of spacing 1.
struct Cleaning {
  explicit Cleaning(const Prepared& prepared) : p(prepared) {
    parameters.min_area = 60;
    parameters.min_persistence = 6 * kNoise;
    parameters.min_contrast = 3;
    parameters.band = 3;
    parameters.min_diversity = 0.2;
    parameters.absorb_area = 20;
    SelectMserParameters mser;
    mser.delta = 6;
    changes = change_of_nodes(p.tree, mser.delta);
    maxima = find_maxima(p.tree);
    selected = select_mser(p.tree, changes, mser);
    large = without_small(selected);
    values = triangle_means(p.surface(), p.mesh.values);
    for (const double value : p.mesh.values) strength.push_back(std::abs(value));
    labels = split_patches(p.twins, label_triangles(trees(), ordered(filter({}))), p.areas).patch_of_triangle;
  }

  std::span<const ComponentTree> trees() const { return {&p.tree, 1}; }
  std::vector<SelectedNode> ordered(std::vector<std::int32_t> nodes) const {
    const std::vector<std::vector<std::int32_t>> selections{std::move(nodes)};
    return order_regions(trees(), selections);
  }
  std::vector<std::int32_t> without_small(std::span<const std::int32_t> nodes) const {
    constexpr double kAnyArea = std::numeric_limits<double>::infinity();
    return filter_persistence(maxima, filter_area(p.tree, nodes, parameters.min_area, kAnyArea),
                              parameters.min_persistence);
  }
  std::vector<std::int32_t> filter(const Execution& execution) const {
    std::vector<std::int32_t> nodes = without_small(selected);
    const std::vector<double> contrasts =
        border_contrasts(p.surface(), p.tree, nodes, values, p.areas, parameters.band, execution);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < nodes.size(); ++i)
      if (contrasts[i] >= parameters.min_contrast * kNoise) nodes[kept++] = nodes[i];
    nodes.resize(kept);
    return filter_diversity(p.tree, changes, nodes, parameters.min_diversity);
  }
  std::vector<std::int32_t> grow(const Execution& execution) const {
    return absorb_small_patches(p.surface(), flood_by_strength(p.surface(), labels, strength, {}, execution), p.areas,
                                parameters.absorb_area, execution, true);
  }

  const Prepared& p;
  SegmentParameters parameters;
  std::vector<std::int64_t> changes;
  Maxima maxima;
  std::vector<std::int32_t> selected, large, labels;  ///< nodes; those that are asked for their contrast; before growth
  std::vector<double> values, strength;               ///< of triangles; of vertices
};

struct Selected {
  std::vector<std::int32_t> number_of_node, region_of_triangle;
};

Selected select_and_label(const ComponentTree& tree) {
  SelectMserParameters parameters;
  parameters.delta = 6;
  const std::vector<std::vector<std::int32_t>> selected{select_mser(tree, parameters)};
  const std::span<const ComponentTree> trees(&tree, 1);
  const std::vector<SelectedNode> regions = order_regions(trees, selected);
  Selected result{std::vector<std::int32_t>(tree.num_nodes(), 0), label_triangles(trees, regions)};
  for (std::size_t r = 0; r < regions.size(); ++r)
    result.number_of_node[static_cast<std::size_t>(regions[r].node)] = static_cast<std::int32_t>(r) + 1;
  return result;
}

void add(const Setting& s) {
  auto run = [&s](const std::string& what, auto body) {
    benchmark::RegisterBenchmark((what + "/" + s.name()).c_str(),
                                 [s, body](benchmark::State& state) {
                                   const Prepared& p = prepared(s);
                                   body(state, p);
                                   count_triangles(state, p);
                                 })
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime();
  };
  for (const int n : {1, 2})
    run("adjacency/" + std::to_string(n), [n](benchmark::State& state, const Prepared& p) {
      for (auto _ : state)
        benchmark::DoNotOptimize(twin_half_edges(p.mesh.triangles, p.mesh.positions.size(), threads(n)));
    });
  for (const bool erase_met : {false, true})
    run(erase_met ? "adjacency_plain_erasing" : "adjacency_plain",
        [erase_met](benchmark::State& state, const Prepared& p) {
          for (auto _ : state) benchmark::DoNotOptimize(plain_twins(p.mesh.triangles, erase_met));
        });
  for (const int n : {1, 2})
    run("quantise_and_areas/" + std::to_string(n), [n](benchmark::State& state, const Prepared& p) {
      for (auto _ : state) {
        benchmark::DoNotOptimize(levels_of_triangles(
            p.mesh.triangles, levels_of_vertices(p.mesh.values, p.levels, 1, threads(n)), {}, threads(n)));
        benchmark::DoNotOptimize(triangle_areas(p.mesh.positions, p.mesh.triangles, threads(n)));
      }
    });
  for (const int n : {1, 2})
    run("tree/" + std::to_string(n), [n](benchmark::State& state, const Prepared& p) {
      for (auto _ : state)
        benchmark::DoNotOptimize(build_component_tree(p.twins, p.areas, p.level_of_triangle,
                                                      static_cast<std::int32_t>(p.levels.size()), threads(n)));
      state.counters["nodes"] = static_cast<double>(p.tree.num_nodes());
    });
  for (const bool by_rank : {false, true})
    run(by_rank ? "tree_plain_by_rank" : "tree_plain", [by_rank](benchmark::State& state, const Prepared& p) {
      std::int64_t nodes = 0;
      for (auto _ : state) nodes = plain_tree<std::int32_t>(p.twins, p.areas, p.level_of_triangle, by_rank).num_nodes;
      if (nodes != static_cast<std::int64_t>(p.tree.num_nodes()))
        state.SkipWithError("the reference finds other nodes");
    });
  run("tree_every_value/1", [](benchmark::State& state, const Prepared& p) {
    for (auto _ : state) {
      const RankedValues ranked = rank_values(p.mesh.values, 1, threads(1));
      const std::vector<std::int32_t> level =
          levels_of_triangles(p.mesh.triangles, ranked.level_of_vertex, {}, threads(1));
      benchmark::DoNotOptimize(
          build_component_tree(p.twins, p.areas, level, static_cast<std::int32_t>(ranked.levels.size()), threads(1)));
    }
  });
  run("tree_every_value_plain", [](benchmark::State& state, const Prepared& p) {
    for (auto _ : state) benchmark::DoNotOptimize(plain_tree<double>(p.twins, p.areas, p.value_of_triangle, false));
  });
  run("select_and_label/1", [](benchmark::State& state, const Prepared& p) {
    for (auto _ : state) benchmark::DoNotOptimize(select_and_label(p.tree));
  });
  for (const int n : {1, 2})
    run("borders/" + std::to_string(n), [n](benchmark::State& state, const Prepared& p) {
      const Selected selected = select_and_label(p.tree);
      std::size_t edges = 0, num_loops = 0;
      for (auto _ : state) {
        const BorderLoops loops =
            extract_borders(p.surface(), p.tree, selected.number_of_node, selected.region_of_triangle, threads(n));
        edges = loops.half_edges.size();
        num_loops = loops.num_loops();
      }
      state.counters["border edges"] = static_cast<double>(edges);
      state.counters["loops"] = static_cast<double>(num_loops);
    });
  for (const int n : {1, 2})
    run("contrasts/" + std::to_string(n), [n](benchmark::State& state, const Prepared& p) {
      const Cleaning cleaning(p);
      for (auto _ : state)
        benchmark::DoNotOptimize(border_contrasts(p.surface(), p.tree, cleaning.large, cleaning.values, p.areas,
                                                  cleaning.parameters.band, threads(n)));
      state.counters["regions"] = static_cast<double>(cleaning.large.size());
    });
  for (const int n : {1, 2})
    run("cleaning/" + std::to_string(n), [n](benchmark::State& state, const Prepared& p) {
      const Cleaning cleaning(p);
      std::size_t kept = 0;
      for (auto _ : state) {
        kept = cleaning.filter(threads(n)).size();
        benchmark::DoNotOptimize(cleaning.grow(threads(n)));
      }
      state.counters["regions"] = static_cast<double>(kept);
    });
  run("attributes/1", [](benchmark::State& state, const Prepared& p) {
    const Cleaning cleaning(p);
    const std::vector<TreeSelection> selections{{cleaning.changes, cleaning.maxima, {}, cleaning.selected}};
    const std::vector<SelectedNode> regions = cleaning.ordered(cleaning.selected);
    for (auto _ : state)
      benchmark::DoNotOptimize(
          describe_regions(p.surface(), cleaning.trees(), selections, regions, p.mesh.values, p.areas, threads(1)));
    state.counters["regions"] = static_cast<double>(regions.size());
  });
  run("tree_of_shapes/1", [](benchmark::State& state, const Prepared& p) {
    const std::vector<std::int32_t> level = levels_of_vertices(p.mesh.values, p.levels, 1);
    std::size_t nodes = 0;
    for (auto _ : state)
      nodes = build_tree_of_shapes(p.surface(), p.areas, level, p.levels, {}, -1, threads(1)).num_nodes();
    state.counters["nodes"] = static_cast<double>(nodes);
  });
  for (const int n : {1, 2})
    run("whole/" + std::to_string(n), [n](benchmark::State& state, const Prepared& p) {
      for (auto _ : state) {
        const std::vector<std::int32_t> twins = twin_half_edges(p.mesh.triangles, p.mesh.positions.size(), threads(n));
        const std::vector<std::int32_t> level = levels_of_triangles(
            p.mesh.triangles, levels_of_vertices(p.mesh.values, p.levels, 1, threads(n)), {}, threads(n));
        const std::vector<double> areas = triangle_areas(p.mesh.positions, p.mesh.triangles, threads(n));
        const ComponentTree tree =
            build_component_tree(twins, areas, level, static_cast<std::int32_t>(p.levels.size()), threads(n));
        const Selected selected = select_and_label(tree);
        benchmark::DoNotOptimize(extract_borders({p.mesh.positions, p.mesh.triangles, twins}, tree,
                                                 selected.number_of_node, selected.region_of_triangle, threads(n)));
      }
    });
}

/// Borders of nested regions: twice the depth, the same output.
void add_nesting() {
  for (const std::int32_t depth : {4, 8, 16})
    benchmark::RegisterBenchmark(
        ("borders_nested/depth_" + std::to_string(depth)).c_str(),
        [depth](benchmark::State& state) {
          Prepared p;
          p.mesh = make_nested_mesh(1000000, depth);
          p.levels.resize(static_cast<std::size_t>(depth) + 1);
          std::iota(p.levels.begin(), p.levels.end(), 0.0);
          finish(p);
          std::vector<std::int32_t> number(p.tree.num_nodes(), 0);
          std::iota(number.begin(), number.end(), 1);
          const std::vector<std::int32_t> behind(p.mesh.triangles.size(), 0);
          std::size_t edges = 0;
          for (auto _ : state)
            edges = extract_borders(p.surface(), p.tree, number, behind, threads(1)).half_edges.size();
          state.counters["border edges"] = static_cast<double>(edges);
          count_triangles(state, p);
        })
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime();
}

}  // namespace
}  // namespace meshmser::bench

int main(int argc, char** argv) {
  using namespace meshmser::bench;
  for (const std::int64_t triangles : {std::int64_t{400000}, std::int64_t{1000000}, std::int64_t{4000000}})
    for (const Ids ids : {Ids::kOrdered, Ids::kShuffled})
      for (const Scalar scalar : {Scalar::kSmooth, Scalar::kRough}) add({triangles, Shape::kHeightField, scalar, ids});
  add({1000000, Shape::kSphere, Scalar::kRough, Ids::kOrdered});
  if (std::getenv("MESHMSER_BENCH_LARGE") != nullptr)
    add({40000000, Shape::kHeightField, Scalar::kRough, Ids::kOrdered});
  add_nesting();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
