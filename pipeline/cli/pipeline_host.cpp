#include "pipeline/cli/pipeline_host.hpp"

#include "pipeline/config/configuration.hpp"
#include "pipeline/run/runner.hpp"

namespace meshmser {

std::optional<Artifact> PipelineHost::artifact(const std::string& config_path, const std::vector<std::string>& set,
                                               std::size_t type) {
  const Configuration configuration = load_configuration(config_path, set);
  auto made = make_artifact(configuration, type, RunOptions{}, execution_, observer_);
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

std::string PipelineHost::units(const std::string& config_path) {
  return load_configuration(config_path).units;
}

}  // namespace meshmser
