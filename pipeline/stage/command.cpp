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

CommandOption set_option() {
  return {"--set",
          "STAGE.KEY=VALUE: gives a parameter another value than the file does; paths begin at the file's folder",
          false, true};
}

CommandOption cache_option() {
  return {"--cache", "folder of the cache (without: $MESHMSER_CACHE, else .meshmser-cache beside the configuration)"};
}

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
