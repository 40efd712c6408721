#include "pipeline/cli/commands.hpp"

namespace meshmser {

std::vector<CommandDefinition> program_commands() {
  std::vector<CommandDefinition> commands = {run_command(),   validate_command(),  explain_command(),
                                             show_command(),  stages_command(),    schema_command(),
                                             cache_command(), completion_command()};
  for (const CommandDefinition* command : all_commands()) commands.push_back(*command);
  for (CommandDefinition& command : commands)
    if (command.name != "validate" && command.name != "stages" && command.name != "schema" &&
        command.name != "completion")
      command.options.push_back({"--threads", "how many; changes no result (without: every core)"});
  return commands;
}

}  // namespace meshmser
