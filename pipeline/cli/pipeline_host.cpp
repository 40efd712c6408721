#include "pipeline/cli/pipeline_host.hpp"

#include <algorithm>

#include "pipeline/config/configuration.hpp"
#include "pipeline/run/runner.hpp"

namespace meshmser {

std::optional<Artifact> PipelineHost::artifact(const std::string& config_path, const std::vector<std::string>& set,
                                               std::size_t type) {
  const Configuration configuration = load_configuration(config_path, set);
  RunOptions options;
  options.cache = cache_;
  auto made = make_artifact(configuration, type, options, execution_, observer_);
  if (!made) return std::nullopt;
  return std::move(made->second);
}

std::shared_ptr<const void> PipelineHost::parameters(const std::string& config_path,
                                                     const std::vector<std::string>& set, const std::string& stage) {
  const Configuration configuration = load_configuration(config_path, set);
  std::shared_ptr<const void> last;
  for (const StageEntry& entry : configuration.stages)
    if (entry.definition->info.name == stage) last = entry.parameters;
  return last;
}

std::vector<std::filesystem::path> PipelineHost::run(const RunRequest& request) {
  Configuration configuration = load_configuration(request.config_path, request.set);
  const auto wanted = [&](const StageEntry& entry) { return entry.definition->info.name == request.last_stage; };
  if (std::none_of(configuration.stages.begin(), configuration.stages.end(), wanted)) {
    StageEntry entry;
    entry.definition = find_stage(request.last_stage);
    if (entry.definition == nullptr) throw UsageError("this build has no stage '" + request.last_stage + "'");
    entry.name = request.last_stage;
    entry.parameters = entry.definition->make_parameters();
    configuration.stages.push_back(std::move(entry));
  }
  RunOptions options;
  options.out = request.out;
  options.cache = request.cache;
  ConsoleObserver observer(request.quiet);
  const RunResult result = meshmser::run(configuration, options, execution_, observer);
  std::vector<std::filesystem::path> files;
  for (const StageRecord& stage : result.stages)
    if (stage.stage == request.last_stage) files.insert(files.end(), stage.files.begin(), stage.files.end());
  return files;
}

std::string PipelineHost::units(const std::string& config_path) {
  return load_configuration(config_path).units;
}

}  // namespace meshmser
