#pragma once
/// Who gives what to whom: the input ports of a configuration's stages resolved to output ports of earlier stages.

#include <optional>
#include <string>
#include <vector>

#include "pipeline/config/configuration.hpp"

namespace meshmser {

/// An output port of a stage of the configuration.
struct PortSource {
  std::size_t stage = 0;  ///< index into Configuration::stages; always less than the stage it feeds
  std::string port;
};

/// An input port and what is plugged in: one source, none (an optional port), or several (Need::kAll), in the order of
/// the stages.
struct PortBinding {
  std::string port;
  std::vector<PortSource> sources;
};

/// What one stage takes and makes.
struct PlannedStage {
  std::vector<PortBinding> inputs;   ///< one per input port, in declared order
  std::vector<std::string> outputs;  ///< ports that will be made with these parameters
};

struct Plan {
  std::vector<PlannedStage> stages;         ///< one per stage of the configuration
  std::vector<Diagnostic> problems;         ///< inputs that nobody makes, names that nobody bears
  std::optional<InputError> input_problem;  ///< the first input whose head could not be read
};

/// An input is given by the nearest earlier stage that makes its type, unless the key `inputs` names another. Cycles
/// cannot be: a stage sees earlier stages only. Never throws for what the configuration says. `unsure` (none or one
/// flag a stage) marks stages whose parameters are not known, because they hold errors: they are taken to make all
/// their ports, and a stage without a definition to make anything.
Plan resolve_ports(const Configuration& configuration, const std::vector<char>& unsure = {});

}  // namespace meshmser
