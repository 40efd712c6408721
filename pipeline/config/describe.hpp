#pragma once
/// What the stages' declarations say, as help, table, JSON, JSON Schema and reference configuration.

#include <string>
#include <vector>

#include "pipeline/stage/stage.hpp"

namespace meshmser {

/// All stages, each after the stages that can make its inputs; ties by name.
std::vector<const StageDefinition*> stages_in_order();

/// What values a parameter takes, in a few words: "length, more than 0", "whole number from 3 to 200 (points)".
std::string expected_values(const Parameter& parameter);

/// Purpose, inputs, outputs and every parameter of a stage, for a terminal.
std::string describe_stage(const StageDefinition& stage);

/// The parameters as a Markdown table, a line a parameter, with a newline at the end.
std::string parameter_table(const StageDefinition& stage);

/// All stages with their purposes as a Markdown table, each linked to its README.
std::string stage_table();

/// The same for programs, indented JSON with a newline at the end: one stage, or the list of all in stages_in_order.
std::string stage_json(const StageDefinition& stage);
std::string stages_json();

/// JSON Schema (2020-12) of a configuration, for editors. It accepts whatever the program accepts; quantities are
/// checked by pattern.
std::string json_schema();

/// A commented configuration of every stage with every key at its default, the scan being `path`.
std::string reference_configuration(const std::string& path);

}  // namespace meshmser
