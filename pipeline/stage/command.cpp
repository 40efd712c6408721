#include "pipeline/stage/command.hpp"

#include <algorithm>
#include <stdexcept>

namespace meshmser {
namespace {

std::vector<std::unique_ptr<CommandDefinition>>& registry() {
  static std::vector<std::unique_ptr<CommandDefinition>> commands;
  return commands;
}

}  // namespace

bool register_command(CommandDefinition definition) {
  for (const auto& known : registry())
    if (known->name == definition.name) throw std::logic_error("two commands are called '" + definition.name + "'");
  registry().push_back(std::make_unique<CommandDefinition>(std::move(definition)));
  return true;
}

std::vector<const CommandDefinition*> all_commands() {
  std::vector<const CommandDefinition*> commands;
  for (const auto& command : registry()) commands.push_back(command.get());
  std::sort(commands.begin(), commands.end(), [](const auto* a, const auto* b) { return a->name < b->name; });
  return commands;
}

}  // namespace meshmser
