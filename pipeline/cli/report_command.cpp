#include <algorithm>
#include <cstdio>

#include "pipeline/cli/commands.hpp"
#include "pipeline/cli/common_options.hpp"
#include "pipeline/run/console.hpp"
#include "pipeline/run/runner.hpp"

namespace meshmser {
namespace {

int make_report(const CommandArguments& arguments, CommandHost& host) {
  Configuration configuration = given_configuration(arguments);
  const auto reports = [](const StageEntry& entry) { return entry.definition->info.name == "report"; };
  if (std::none_of(configuration.stages.begin(), configuration.stages.end(), reports)) {
    StageEntry entry;
    entry.definition = find_stage("report");
    if (entry.definition == nullptr) throw UsageError("report: this build has no stage 'report'");
    entry.name = "report";
    entry.parameters = entry.definition->make_parameters();
    configuration.stages.push_back(std::move(entry));
  }
  RunOptions options;
  options.out = arguments.get("--out");
  options.cache = arguments.get("--cache");
  ConsoleObserver observer(arguments.find("--quiet") != nullptr);
  const RunResult result = run(configuration, options, host.execution(), observer);
  for (const StageRecord& stage : result.stages)
    if (stage.stage == "report")
      for (const std::filesystem::path& file : stage.files) std::printf("%s\n", file.c_str());
  return 0;
}

}  // namespace

CommandDefinition report_command() {
  return {.name = "report",
          .purpose = "Runs a configuration, with the stage 'report' at its end where it has none. Prints the page.",
          .options = {config_option(),
                      set_option(),
                      {"--out", "folder of the results (without: CONFIG's name with -out)"},
                      cache_option(),
                      {.name = "--quiet,-q", .description = "warnings only", .flag = true}},
          .run = make_report,
          .example = "meshmser report configs/demo.yaml --out /tmp/demo"};
}

}  // namespace meshmser
