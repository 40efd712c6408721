#include "pipeline/run/show.hpp"

#include <cstdio>

#include "pipeline/cli/commands.hpp"
#include "pipeline/cli/common_options.hpp"
#include "pipeline/run/console.hpp"

namespace meshmser {
namespace {

int show_stage(const CommandArguments& arguments, CommandHost& host) {
  const Configuration configuration = given_configuration(arguments);
  check_stage_name(configuration, arguments.get("STAGE"), "show");
  RunOptions options;
  options.cache = arguments.get("--cache");
  ConsoleObserver observer(true);
  std::fputs(show(configuration, arguments.get("STAGE"), options, host.execution(), observer).c_str(), stdout);
  return 0;
}

}  // namespace

CommandDefinition show_command() {
  return {.name = "show",
          .purpose = "Tells what a stage made: figures, warnings, and of each output counts, values and where it lies.",
          .options = {config_option(),
                      {.name = "STAGE", .description = "a stage of the configuration", .required = true},
                      set_option(),
                      cache_option()},
          .run = show_stage,
          .example = "meshmser show configs/demo.yaml curvature"};
}

}  // namespace meshmser
