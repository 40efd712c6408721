#include <cstdio>

#include "pipeline/cli/commands.hpp"
#include "pipeline/cli/common_options.hpp"

namespace meshmser {
namespace {

int validate(const CommandArguments& arguments, CommandHost&) {
  const Configuration configuration = given_configuration(arguments);
  std::printf("%s: valid, %zu stages\n", configuration.path.c_str(), configuration.stages.size());
  return 0;
}

}  // namespace

CommandDefinition validate_command() {
  return {.name = "validate",
          .purpose = "Checks a configuration and says everything that is wrong with it; reads no data.",
          .options = {config_option(), set_option()},
          .run = validate,
          .example = "meshmser validate configs/demo.yaml"};
}

}  // namespace meshmser
