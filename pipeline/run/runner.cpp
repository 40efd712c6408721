#include "pipeline/run/runner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <map>

#include "pipeline/cache/file_publisher.hpp"
#include "pipeline/config/plan.hpp"
#include "pipeline/run/measure.hpp"
#include "pipeline/run/run_report.hpp"

namespace meshmser {
namespace {

std::size_t stage_index(const Configuration& configuration, const std::string& name, const char* option) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < configuration.stages.size(); ++i) {
    if (configuration.stages[i].name == name) return i;
    names.push_back(configuration.stages[i].name);
  }
  const std::string nearest = nearest_name(name, names);
  throw UsageError(fmt::format("{}: {} has no stage '{}'{}", option, configuration.path, name,
                               nearest.empty() ? "" : ", did you mean '" + nearest + "'?"));
}

/// One run of a configuration.
class Run {
 public:
  Run(const Configuration& configuration, const RunOptions& options, const Execution& execution, RunObserver& observer)
      : configuration_(configuration),
        options_(options),
        execution_(execution),
        observer_(observer),
        plan_(resolve_ports(configuration)),
        artifacts_(configuration.stages.size()),
        scratch_(std::filesystem::temp_directory_path() / ("meshmser-" + unique_name())) {
    result_.out = options.out.empty() ? default_out_folder(configuration) : std::filesystem::path(options.out);
    result_.cache = options.cache.empty() ? default_cache_folder(configuration) : std::filesystem::path(options.cache);
    execution_.progress = [&observer](std::string_view what, std::int64_t done, std::int64_t total) {
      observer.progress(what, done, total);
    };
    for (const StageEntry& stage : configuration.stages) {
      const auto files = stage.definition->files(stage.parameters.get());
      input_files_.insert(input_files_.end(), files.begin(), files.end());
    }
    input_files_.emplace_back(configuration.path);
  }
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;
  ~Run() {
    std::error_code ignored;
    std::filesystem::remove_all(scratch_, ignored);
  }

  RunResult whole() {
    count_ = options_.until.empty() ? configuration_.stages.size()
                                    : stage_index(configuration_, options_.until, "--until") + 1;
    for (std::size_t i = 0; i < count_; ++i) make(i);
    publish();
    return std::move(result_);
  }

  std::optional<std::pair<std::string, Artifact>> artifact(std::size_t type) {
    for (std::size_t i = configuration_.stages.size(); i-- > 0;)
      for (const OutputPort& port : configuration_.stages[i].definition->outputs) {
        const std::vector<std::string>& made = plan_.stages[i].outputs;
        if (port.type != type || std::find(made.begin(), made.end(), port.name) == made.end()) continue;
        count_ = i + 1;
        for (std::size_t k = 0; k < count_; ++k) make(k);
        return std::pair(configuration_.stages[i].name, artifacts_[i].at(port.name));
      }
    return std::nullopt;
  }

 private:
  Inputs inputs_of(std::size_t i) const {
    Inputs inputs;
    for (const PortBinding& binding : plan_.stages[i].inputs)
      for (const PortSource& source : binding.sources)
        inputs.add({binding.port, configuration_.stages[source.stage].name, artifacts_[source.stage].at(source.port)});
    return inputs;
  }

  void make(std::size_t i) {
    const StageEntry& stage = configuration_.stages[i];
    StageRecord record;
    record.name = stage.name;
    record.stage = stage.definition->info.name;
    record.outcome = StageOutcome::kRan;
    record.reason = "never ran";
    observer_.stage_started(record, i, count_);
    const std::filesystem::path folder = scratch_ / stage.name;
    std::filesystem::create_directories(folder);
    RunContext context(execution_, folder, stage.name, configuration_.units);
    const Measure measure;
    const Outputs outputs = stage.definition->run(stage.parameters.get(), inputs_of(i), context);
    record.wall_seconds = measure.wall_seconds();
    record.cpu_seconds = measure.cpu_seconds();
    record.peak_bytes = measure.peak_bytes();
    record.warnings = context.warnings();
    record.report = context.report_items();
    for (const auto& [port, artifact] : outputs.items()) artifacts_[i].emplace(port, artifact);
    observer_.stage_finished(record, i, count_);
    result_.stages.push_back(std::move(record));
  }

  void publish() {
    FilePublisher publisher(real_file_system(), result_.out, input_files_);
    for (std::size_t i = 0; i < count_; ++i)
      for (const auto& [port, artifact] : artifacts_[i]) {
        const auto* set = std::get_if<Shared<FileSet>>(&artifact);
        if (set == nullptr) continue;
        for (const std::string& name : (*set)->names)
          result_.stages[i].files.push_back(publisher.copy((*set)->folder / name, name));
      }
    publisher.write("run.json", run_report(configuration_, result_, {}, execution_));
  }

  const Configuration& configuration_;
  const RunOptions& options_;
  Execution execution_;
  RunObserver& observer_;
  Plan plan_;
  std::vector<std::map<std::string, Artifact>> artifacts_;  ///< of each stage, by port
  std::filesystem::path scratch_;
  std::vector<std::filesystem::path> input_files_;
  std::size_t count_ = 0;  ///< of stages to take
  RunResult result_;
};

}  // namespace

std::filesystem::path default_out_folder(const Configuration& configuration) {
  return std::filesystem::path(configuration.path).stem().string() + "-out";
}

std::filesystem::path default_cache_folder(const Configuration& configuration) {
  if (const char* named = std::getenv("MESHMSER_CACHE"); named != nullptr && *named != '\0') return named;
  const std::filesystem::path beside = std::filesystem::path(configuration.path).parent_path();
  return beside / ".meshmser-cache";
}

RunResult run(const Configuration& configuration, const RunOptions& options, const Execution& execution,
              RunObserver& observer) {
  return Run(configuration, options, execution, observer).whole();
}

std::optional<std::pair<std::string, Artifact>> make_artifact(const Configuration& configuration, std::size_t type,
                                                              const RunOptions& options, const Execution& execution,
                                                              RunObserver& observer) {
  return Run(configuration, options, execution, observer).artifact(type);
}

}  // namespace meshmser
