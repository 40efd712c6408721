/// The stages tree, mser and borders as the program runs them: what reading from the cache and writing to it cost
/// beside the computing. Files lie in the system's page cache and fsync is left out: what is measured is the program's
/// own work, hashing included. Prints medians in ns a triangle.
///
///   stages_bench [TRIANGLES] [THREADS] [REPETITIONS] [PARAMETER=VALUE ...]   parameters as tree.polarity=upper

#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "pipeline/cache/cache.hpp"
#include "pipeline/stage/stage.hpp"
#include "tests/bench/bench_mesh.hpp"
#include "tests/support/temporary_files.hpp"

namespace meshmser::bench {
namespace {

class WithoutSync : public FileSystem {
 public:
  void sync(const std::filesystem::path&) override {}
};

/// Wall time and CPU time of the process, in seconds.
struct Seconds {
  double wall = 0, cpu = 0;
};

Seconds now() {
  timespec cpu{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &cpu);
  return {std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(),
          static_cast<double>(cpu.tv_sec) + 1e-9 * static_cast<double>(cpu.tv_nsec)};
}

Shared<TriangleMesh> make_mesh(std::int64_t num_triangles) {
  BenchMesh made = make_bench_mesh(num_triangles, Shape::kHeightField, Scalar::kRough, Ids::kOrdered);
  auto mesh = std::make_shared<TriangleMesh>();
  mesh->spacing = 1;
  mesh->positions = std::move(made.positions);
  mesh->triangles = std::move(made.triangles);
  mesh->point_of_vertex.resize(mesh->num_vertices());
  for (std::size_t v = 0; v < mesh->num_vertices(); ++v) mesh->point_of_vertex[v] = static_cast<std::int32_t>(v);
  mesh->normals.assign(mesh->num_vertices(), Eigen::Vector3d(0, 0, 1));
  mesh->turned_of_vertex.assign(mesh->num_vertices(), 0);
  mesh->properties.push_back({"s", ValueType::kFloat64, std::move(made.values)});
  return mesh;
}

struct Step {
  std::string stage;
  std::vector<std::pair<std::string, std::string>> inputs;  ///< port, stage that made it
};

class Bench {
 public:
  Bench(Shared<TriangleMesh> mesh, int threads, std::map<std::string, std::string> settings)
      : threads_(threads), settings_(std::move(settings)) {
    Outputs outputs;
    outputs.set("mesh", TriangleMesh(*mesh));
    store("mesh", outputs);
  }

  /// One pass over the three stages; times by stage and kind of work.
  std::map<std::string, Seconds> pass() {
    std::map<std::string, Seconds> times;
    const std::vector<Step> steps{{"tree", {{"mesh", "mesh"}}},
                                  {"mser", {{"mesh", "mesh"}, {"trees", "tree"}}},
                                  {"borders", {{"mesh", "mesh"}, {"trees", "tree"}, {"segmentation", "mser"}}}};
    Seconds last = now();
    const auto lap = [&](const std::string& what) {
      const Seconds here = now();
      times[what] = {here.wall - last.wall, here.cpu - last.cpu};
      last = now();
    };
    for (const Step& step : steps) {
      Inputs inputs;
      for (const auto& [port, source] : step.inputs) {
        inputs.add({port, source, cache_.load(entries_.at(source), port, threads_)});
        lap("read " + port + " for " + step.stage);
      }
      Execution execution;
      execution.threads = threads_;
      RunContext context(execution, folder_.path(), step.stage, "mm");
      const StageDefinition* stage = find_stage(step.stage);
      const std::shared_ptr<void> parameters = stage->make_parameters();
      for (const Parameter& parameter : stage->parameters) bind(step.stage, parameter, parameters.get());
      lap("");
      const Outputs outputs = stage->run(parameters.get(), inputs, context);
      lap("compute " + step.stage);
      store(step.stage, outputs);
      lap("write " + step.stage);
    }
    times.erase("");
    return times;
  }

 private:
  void bind(const std::string& stage, const Parameter& parameter, void* parameters) {
    const auto found = settings_.find(stage + "." + parameter.name);
    if (found == settings_.end()) return;
    ConfigValue value;
    value.kind = ConfigValue::Kind::kScalar;
    value.text = found->second;
    std::vector<Diagnostic> problems;
    parameter.bind(value, {}, parameters, problems);
    for (const Diagnostic& problem : problems) throw std::runtime_error(found->first + ": " + problem.message);
  }

  void store(const std::string& stage, const Outputs& outputs) {
    const std::unique_ptr<Cache::Staging> staging = cache_.stage();
    Entry entry;
    entry.stage = stage;
    entry.key = std::to_string(num_stored_++);
    bool replaced = false;
    cache_.store(entry, "", outputs, *staging, replaced, threads_);
    entries_[stage] = std::move(entry);
  }

  int threads_;
  std::map<std::string, std::string> settings_;
  TemporaryFolder folder_;
  WithoutSync disk_;
  Cache cache_{folder_.path() / "cache", disk_};
  std::map<std::string, Entry> entries_;
  int num_stored_ = 0;
};

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

int main(int argc, char** argv) {
  std::vector<std::int64_t> numbers;
  std::map<std::string, std::string> settings{{"tree.scalar", "s"}, {"tree.levels", "256"}};
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (const std::size_t equal = word.find('='); equal != std::string::npos)
      settings[word.substr(0, equal)] = word.substr(equal + 1);
    else
      numbers.push_back(std::stoll(word));
  }
  const auto number = [&](std::size_t i, std::int64_t otherwise) {
    return i < numbers.size() ? numbers[i] : otherwise;
  };
  const std::int64_t num_triangles = number(0, 1000000);
  const int threads = static_cast<int>(number(1, 1));
  Bench bench(make_mesh(num_triangles), threads, settings);
  std::map<std::string, std::vector<double>> walls, cpus;
  for (std::int64_t i = 0; i < std::max<std::int64_t>(1, number(2, 7)); ++i)
    for (const auto& [what, seconds] : bench.pass()) {
      walls[what].push_back(seconds.wall);
      cpus[what].push_back(seconds.cpu);
    }
  const double per_triangle = 1e9 / static_cast<double>(num_triangles);
  double computing = 0, alone = 0, in_one_run = 0, computing_cpu = 0, alone_cpu = 0, in_one_run_cpu = 0;
  fmt::print("{:<32} {:>10} {:>10}   ns a triangle, {} triangles, {} threads\n", "", "wall", "CPU", num_triangles,
             threads);
  for (const auto& [what, values] : walls) {
    const double wall = median(values) * per_triangle, cpu = median(cpus[what]) * per_triangle;
    fmt::print("{:<32} {:>10.1f} {:>10.1f}\n", what, wall, cpu);
    const bool computes = what.starts_with("compute");
    (computes ? computing : alone) += wall;
    (computes ? computing_cpu : alone_cpu) += cpu;
    // In one run of the program what a stage made is still in memory.
    if (what.starts_with("write") || what == "read mesh for tree") {
      in_one_run += wall;
      in_one_run_cpu += cpu;
    }
  }
  const auto total = [&](const char* what, double wall, double cpu) {
    fmt::print("{:<32} {:>10.1f} {:>10.1f}   {:.2f} and {:.2f} times the computing\n", what, wall, cpu,
               wall / computing, cpu / computing_cpu);
  };
  total("computing", computing, computing_cpu);
  total("cache, the three in one run", in_one_run, in_one_run_cpu);
  total("cache, each in a run of its own", alone, alone_cpu);
  return 0;
}

}  // namespace
}  // namespace meshmser::bench

int main(int argc, char** argv) {
  return meshmser::bench::main(argc, argv);
}
