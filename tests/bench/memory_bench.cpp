/// Memory of adjacency, tree, selection, labels and borders: every allocation is counted, and the greatest sum at a
/// time is told as bytes a triangle beyond mesh, adjacency, areas and levels, by step and for the whole; beside it the
/// greatest resident size of the process. One thread unless told.
///
///   memory_bench [TRIANGLES] [THREADS]

#include <fmt/format.h>
#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <fstream>
#include <new>
#include <string>

#include "stages/borders/borders.hpp"
#include "stages/common/adjacency.hpp"
#include "stages/mser/label_triangles.hpp"
#include "stages/mser/select_mser.hpp"
#include "stages/tree/component_tree.hpp"
#include "stages/tree/levels.hpp"
#include "tests/bench/bench_mesh.hpp"

namespace {

std::atomic<std::int64_t> bytes_now{0}, bytes_most{0};

void* counted(void* place) {
  if (place == nullptr) throw std::bad_alloc();
  const std::int64_t now = bytes_now += static_cast<std::int64_t>(::malloc_usable_size(place));
  std::int64_t most = bytes_most;
  while (now > most && !bytes_most.compare_exchange_weak(most, now)) {
  }
  return place;
}

void give_back(void* place) {
  if (place != nullptr) bytes_now -= static_cast<std::int64_t>(::malloc_usable_size(place));
  std::free(place);
}

}  // namespace

void* operator new(std::size_t size) {
  return counted(std::malloc(size));
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  const auto a = static_cast<std::size_t>(alignment);
  return counted(std::aligned_alloc(a, (size + a - 1) / a * a));
}
void operator delete(void* place) noexcept {
  give_back(place);
}
void operator delete(void* place, std::size_t) noexcept {
  give_back(place);
}
void operator delete(void* place, std::align_val_t) noexcept {
  give_back(place);
}
void operator delete(void* place, std::size_t, std::align_val_t) noexcept {
  give_back(place);
}

namespace meshmser::bench {
namespace {

std::int64_t peak_resident() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmHWM:")) return std::stoll(line.substr(6)) * 1024;
  return 0;
}

int main(std::int64_t num_triangles, int threads) {
  Execution execution;
  execution.threads = threads;
  BenchMesh mesh = make_bench_mesh(num_triangles, Shape::kHeightField, Scalar::kRough, Ids::kOrdered);
  LevelParameters level_parameters;
  level_parameters.count = 256;
  const std::vector<double> heights = make_levels(mesh.values, {}, level_parameters, false);
  std::ofstream("/proc/self/clear_refs") << "5";  // the peak of the resident size begins anew (proc(5))
  const std::int64_t of_mesh = bytes_now;
  const auto n = static_cast<double>(mesh.triangles.size());
  std::int64_t given = 0, most_of_all = 0;
  fmt::print("{:<28} {:>12} {:>12}   bytes a triangle, {} triangles, {} threads\n", "", "at most", "kept",
             mesh.triangles.size(), threads);
  const auto step = [&](const char* what, bool is_given, auto&& body) {
    const std::int64_t before = bytes_now;
    bytes_most = before;
    auto result = body();
    if (is_given)
      given += bytes_now - before;
    else
      most_of_all = std::max(most_of_all, bytes_most - of_mesh - given);
    fmt::print("{:<28} {:>12.2f} {:>12.2f}\n", what, static_cast<double>(bytes_most - before) / n,
               static_cast<double>(bytes_now - before) / n);
    return result;
  };
  const auto twins =
      step("adjacency", true, [&] { return twin_half_edges(mesh.triangles, mesh.positions.size(), execution); });
  const auto level = step("levels", true, [&] {
    return levels_of_triangles(mesh.triangles, levels_of_vertices(mesh.values, heights, 1, execution), {}, execution);
  });
  const auto areas = step("areas", true, [&] { return triangle_areas(mesh.positions, mesh.triangles, execution); });
  const auto tree = step("tree", false, [&] {
    return build_component_tree(twins, areas, level, static_cast<std::int32_t>(heights.size()), execution);
  });
  const std::span<const ComponentTree> trees(&tree, 1);
  const auto regions = step("selection", false, [&] {
    SelectMserParameters parameters;
    parameters.delta = 6;
    const std::vector<std::vector<std::int32_t>> selected{select_mser(tree, parameters)};
    return order_regions(trees, selected);
  });
  const auto labels = step("labels", false, [&] { return label_triangles(trees, regions); });
  const auto borders = step("borders", false, [&] {
    return extract_borders({mesh.positions, mesh.triangles, twins}, tree, number_of_nodes(tree, regions), labels,
                           execution);
  });
  fmt::print("{:<28} {:>12.2f} {:>12.2f}   beyond mesh, adjacency, levels and areas ({:.2f})\n", "whole",
             static_cast<double>(most_of_all) / n, static_cast<double>(bytes_now - of_mesh - given) / n,
             static_cast<double>(of_mesh + given) / n);
  fmt::print("{:.2f} border edges a triangle; greatest resident size {:.2f} GB\n",
             static_cast<double>(borders.half_edges.size()) / n, static_cast<double>(peak_resident()) / 1e9);
  return 0;
}

}  // namespace
}  // namespace meshmser::bench

int main(int argc, char** argv) {
  return meshmser::bench::main(argc > 1 ? std::stoll(argv[1]) : 1000000, argc > 2 ? std::stoi(argv[2]) : 1);
}
