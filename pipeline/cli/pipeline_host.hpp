#pragma once
/// What the program gives to its commands.

#include <string>
#include <vector>

#include "pipeline/run/console.hpp"
#include "pipeline/stage/command.hpp"

namespace meshmser {

class PipelineHost : public CommandHost {
 public:
  /// `cache`: folder of the cache for artifacts; empty: the configuration's own.
  PipelineHost(Execution execution, std::string cache)
      : execution_(std::move(execution)), cache_(std::move(cache)), observer_(true) {}

  std::optional<Artifact> artifact(const std::string& config_path, const std::vector<std::string>& set,
                                   std::size_t type) override;
  std::shared_ptr<const void> parameters(const std::string& config_path, const std::vector<std::string>& set,
                                         const std::string& stage) override;
  std::vector<std::filesystem::path> run(const RunRequest& request) override;
  std::string units(const std::string& config_path) override;
  const Execution& execution() const override { return execution_; }

 private:
  Execution execution_;
  std::string cache_;
  ConsoleObserver observer_;
};

}  // namespace meshmser
