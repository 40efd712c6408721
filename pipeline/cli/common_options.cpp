#include "pipeline/cli/common_options.hpp"

namespace meshmser {

CommandOption config_option() {
  return {"CONFIG", "a configuration (.yaml)", true};
}

std::vector<std::string> values_of(const CommandArguments& arguments, const std::string& option) {
  const auto* values = arguments.find(option);
  return values == nullptr ? std::vector<std::string>{} : *values;
}

Configuration given_configuration(const CommandArguments& arguments) {
  return load_configuration(arguments.get("CONFIG"), values_of(arguments, "--set"));
}

void check_stage_name(const Configuration& configuration, const std::string& name, const std::string& option) {
  std::vector<std::string> names;
  std::string list;
  for (const StageEntry& stage : configuration.stages) {
    if (stage.name == name) return;
    names.push_back(stage.name);
    list += (list.empty() ? "" : ", ") + stage.name;
  }
  const std::string nearest = nearest_name(name, names);
  throw UsageError(option + ": " + configuration.path + " has no stage '" + name + "'" +
                   (nearest.empty() ? "; it has " + list : ", did you mean '" + nearest + "'?"));
}

}  // namespace meshmser
