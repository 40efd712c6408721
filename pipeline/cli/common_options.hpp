#pragma once
/// What several commands take.

#include <string>
#include <vector>

#include "pipeline/config/configuration.hpp"
#include "pipeline/stage/command.hpp"

namespace meshmser {

CommandOption config_option();

/// The values of a repeatable option; none where it was not given.
std::vector<std::string> values_of(const CommandArguments& arguments, const std::string& option);

/// The configuration named by CONFIG, with what --set changes.
Configuration given_configuration(const CommandArguments& arguments);

/// Throws a UsageError with the nearest name unless the configuration has a stage of that name.
void check_stage_name(const Configuration& configuration, const std::string& name, const std::string& option);

}  // namespace meshmser
