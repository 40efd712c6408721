#include <cstdio>

#include "pipeline/cli/commands.hpp"
#include "pipeline/cli/common_options.hpp"
#include "pipeline/run/console.hpp"
#include "pipeline/run/runner.hpp"

namespace meshmser {
namespace {

int explain(const CommandArguments& arguments, CommandHost& host) {
  const Configuration configuration = given_configuration(arguments);
  const std::string only = arguments.get("STAGE");
  if (!only.empty()) check_stage_name(configuration, only, "explain");
  RunOptions options;
  options.cache = arguments.get("--cache");
  options.until = only;
  options.dry_run = true;
  ConsoleObserver observer(true);
  for (const StageRecord& stage : run(configuration, options, host.execution(), observer).stages) {
    if (!only.empty() && stage.name != only) continue;
    if (stage.outcome == StageOutcome::kCached)
      std::printf("%s: cached, nothing it depends on changed\n", stage.name.c_str());
    else
      std::printf("%s: %s: %s\n", stage.name.c_str(), stage.outcome == StageOutcome::kMayRun ? "may run" : "would run",
                  stage.reason.c_str());
  }
  return 0;
}

}  // namespace

CommandDefinition explain_command() {
  return {.name = "explain",
          .purpose = "Tells which stages would run, and why.",
          .options = {config_option(), {"STAGE", "this stage alone"}, set_option(), cache_option()},
          .run = explain,
          .example = "meshmser explain configs/demo.yaml --set orient.neighbors=20"};
}

}  // namespace meshmser
