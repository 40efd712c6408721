#include <cstdio>

#include "pipeline/cli/commands.hpp"
#include "pipeline/cli/common_options.hpp"
#include "pipeline/run/console.hpp"
#include "pipeline/run/runner.hpp"

namespace meshmser {
namespace {

void tell_plan(const RunResult& result) {
  for (const StageRecord& stage : result.stages) {
    const char* what = stage.outcome == StageOutcome::kCached    ? "cached"
                       : stage.outcome == StageOutcome::kWillRun ? "would run"
                       : stage.outcome == StageOutcome::kMayRun  ? "may run"
                                                                 : "ran";
    std::printf("%-12s %-9s %s\n", stage.name.c_str(), what, stage.reason.c_str());
  }
}

int run_configuration(const CommandArguments& arguments, CommandHost& host) {
  const Configuration configuration = given_configuration(arguments);
  RunOptions options;
  options.out = arguments.get("--out");
  options.cache = arguments.get("--cache");
  options.until = arguments.get("--until");
  options.from = arguments.get("--from");
  options.only = arguments.get("--only");
  options.dry_run = arguments.find("--dry-run") != nullptr;
  for (const std::string& stage : values_of(arguments, "--force"))
    if (stage.empty())
      options.force_all = true;
    else
      options.force.push_back(stage);
  if (!options.only.empty() && !(options.until + options.from).empty())
    throw UsageError("run: --only runs one stage alone, leave --until and --from out");

  ConsoleObserver observer(arguments.find("--quiet") != nullptr || options.dry_run);
  const RunResult result = run(configuration, options, host.execution(), observer);
  if (options.dry_run) {
    tell_plan(result);
    return 0;
  }
  for (const StageRecord& stage : result.stages)
    for (const std::filesystem::path& file : stage.files) std::printf("%s\n", file.c_str());
  return 0;
}

}  // namespace

CommandDefinition run_command() {
  return {
      .name = "run",
      .purpose = "Runs a configuration; what the cache holds is not made again. Prints the files it wrote.",
      .options = {config_option(),
                  set_option(),
                  {"--out", "folder of the results (without: CONFIG's name with -out)"},
                  cache_option(),
                  {"--until", "the last stage to run"},
                  {"--from", "this stage and those after it run again, cached or not"},
                  {"--only", "runs this stage alone, its inputs taken from the cache"},
                  {.name = "--force",
                   .description = "a stage to run again, cached or not; without a value: all",
                   .repeated = true,
                   .optional_value = true},
                  {.name = "--dry-run,-n", .description = "tells what would run, runs nothing", .flag = true},
                  {.name = "--quiet,-q", .description = "no progress: warnings, and the files it wrote", .flag = true}},
      .run = run_configuration,
      .example = "meshmser run configs/demo.yaml --set mser.min_area='2 mm2' --out /tmp/demo"};
}

}  // namespace meshmser
