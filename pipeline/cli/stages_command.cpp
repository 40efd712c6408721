#include <cstdio>

#include "pipeline/cli/commands.hpp"
#include "pipeline/config/describe.hpp"

namespace meshmser {
namespace {

const StageDefinition& stage_named(const std::string& name) {
  if (const StageDefinition* stage = find_stage(name)) return *stage;
  std::vector<std::string> names;
  std::string list;
  for (const StageDefinition* stage : stages_in_order()) {
    names.emplace_back(stage->info.name);
    list += (list.empty() ? "" : ", ") + names.back();
  }
  const std::string nearest = nearest_name(name, names);
  throw UsageError("stages: unknown stage '" + name + "'" +
                   (nearest.empty() ? "; stages are " + list : ", did you mean '" + nearest + "'?"));
}

int tell_stages(const CommandArguments& arguments, CommandHost&) {
  const std::string name = arguments.get("STAGE");
  const bool json = arguments.find("--json") != nullptr, markdown = arguments.find("--markdown") != nullptr;
  const bool reference = arguments.find("--reference") != nullptr;
  if (json + markdown + reference > 1)
    throw UsageError("stages: --json, --markdown and --reference exclude each other");
  if (reference && !name.empty()) throw UsageError("stages: --reference holds every stage, leave '" + name + "' out");
  std::string text;
  if (reference) {
    text = reference_configuration("../data/demo/tablet.ply");
  } else if (!name.empty()) {
    const StageDefinition& stage = stage_named(name);
    text = json ? stage_json(stage) : markdown ? parameter_table(stage) : describe_stage(stage);
  } else if (json) {
    text = stages_json();
  } else if (markdown) {
    text = stage_table();
  } else {
    for (const StageDefinition* stage : stages_in_order()) {
      const std::string stage_name(stage->info.name);
      text += stage_name + std::string(stage_name.size() < 11 ? 11 - stage_name.size() : 1, ' ') +
              std::string(stage->info.purpose) + "\n";
    }
  }
  std::fputs(text.c_str(), stdout);
  return 0;
}

}  // namespace

CommandDefinition stages_command() {
  return {.name = "stages",
          .purpose = "Lists the stages, or tells one stage's inputs, outputs and parameters.",
          .options = {{"STAGE", "a stage; without: all, a line each"},
                      {.name = "--json", .description = "for programs", .flag = true},
                      {.name = "--markdown", .description = "as the table of a README", .flag = true},
                      {.name = "--reference",
                       .description = "a commented configuration with every key at its default",
                       .flag = true}},
          .run = tell_stages,
          .example = "meshmser stages curvature"};
}

}  // namespace meshmser
