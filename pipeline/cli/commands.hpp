#pragma once
/// The commands of the program; each in the file of its name.

#include <vector>

#include "pipeline/stage/command.hpp"

namespace meshmser {

CommandDefinition run_command();
CommandDefinition validate_command();
CommandDefinition explain_command();
CommandDefinition show_command();
CommandDefinition stages_command();
CommandDefinition schema_command();
CommandDefinition cache_command();
CommandDefinition completion_command();

/// Those above and those that stages registered, in the order of the help text: ours first, then by name.
std::vector<CommandDefinition> program_commands();

}  // namespace meshmser
