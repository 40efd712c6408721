#include "pipeline/config/describe.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

namespace meshmser {
namespace {

std::string joined(const std::vector<std::string>& words, std::string_view between) {
  std::string text;
  for (const std::string& word : words) {
    if (!text.empty()) text += between;
    text += word;
  }
  return text;
}

std::string bounds_text(const Range& bounds) {
  const bool below = std::isinf(bounds.least), above = std::isinf(bounds.greatest);
  if (below && above) return "";
  if (above) return (bounds.least_excluded ? "more than " : "at least ") + format_number(bounds.least);
  if (below) return "at most " + format_number(bounds.greatest);
  return (bounds.least_excluded ? "more than " + format_number(bounds.least) + " to "
                                : "from " + format_number(bounds.least) + " to ") +
         format_number(bounds.greatest);
}

std::string type_text(const ParameterShape& shape, bool plural) {
  const std::string s = plural ? "s" : "";
  switch (shape.kind) {
    case ParameterKind::kInteger:
      return "whole number" + s;
    case ParameterKind::kNumber:
      return "number" + s;
    case ParameterKind::kBoolean:
      return "true or false";
    case ParameterKind::kText:
      return "text" + s;
    case ParameterKind::kChoice:
      return joined(shape.choices, ", ");
    case ParameterKind::kLength:
      return "length" + s;
    case ParameterKind::kArea:
      return "area" + s;
    case ParameterKind::kAmount:
      return "amount" + s;
    case ParameterKind::kAngle:
      return "angle" + s;
    case ParameterKind::kShare:
      return "share" + s;
    case ParameterKind::kPath:
      return "path" + s;
    case ParameterKind::kList:
      return "list of " + (shape.size ? std::to_string(*shape.size) + " " : std::string()) +
             type_text(*shape.element, true);
    case ParameterKind::kMap: {
      std::vector<std::string> names;
      for (const Parameter& field : *shape.fields) names.push_back(field.name);
      return "map" + s + " {" + joined(names, ", ") + "}";
    }
  }
  return "";
}

std::string need_text(Need need) {
  return need == Need::kRequired ? "" : need == Need::kOptional ? ", optional" : ", of all earlier stages";
}

// Lines of at most `width` columns, each after `indent` but the first.
std::string wrapped(const std::string& text, std::size_t width, const std::string& indent) {
  std::string out;
  std::size_t column = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    if (column > 0 && column + 1 + word.size() > width) {
      out += "\n" + indent;
      column = 0;
    } else if (column > 0) {
      out += ' ';
      ++column;
    }
    out += word;
    column += word.size();
    begin = end + 1;
  }
  return out;
}

std::string table_cell(const std::string& text) {
  std::string cell;
  for (const char c : text) {
    if (c == '|') cell += '\\';
    cell += c;
  }
  return cell;
}

}  // namespace

std::vector<const StageDefinition*> stages_in_order() {
  std::vector<const StageDefinition*> waiting = all_stages(), ordered;
  const auto feeds = [](const StageDefinition& maker, const StageDefinition& taker) {
    if (&maker == &taker) return false;
    for (const InputPort& input : taker.inputs)
      for (const OutputPort& output : maker.outputs)
        if (input.type == output.type) return true;
    return false;
  };
  while (!waiting.empty()) {
    auto next = std::find_if(waiting.begin(), waiting.end(), [&](const StageDefinition* stage) {
      return std::none_of(waiting.begin(), waiting.end(),
                          [&](const StageDefinition* other) { return feeds(*other, *stage); });
    });
    if (next == waiting.end()) next = waiting.begin();  // stages that feed one another: by name
    ordered.push_back(*next);
    waiting.erase(next);
  }
  return ordered;
}

std::string expected_values(const Parameter& parameter) {
  std::string text = type_text(parameter.shape, false);
  if (const std::string bounds = bounds_text(parameter.range); !bounds.empty())
    text += (parameter.shape.kind == ParameterKind::kInteger || parameter.shape.kind == ParameterKind::kNumber ? " "
                                                                                                               : ", ") +
            bounds;
  if (!parameter.shape.words.empty()) text += ", or " + joined(parameter.shape.words, " or ");
  if (!parameter.unit.empty()) text += " (" + parameter.unit + ")";
  return text;
}

std::string describe_stage(const StageDefinition& stage) {
  std::string text(stage.info.name);
  text += ": " + std::string(stage.info.purpose) + "\n";
  if (!stage.inputs.empty()) {
    text += "\ntakes\n";
    for (const InputPort& port : stage.inputs)
      text += "  " + port.name + " (" + std::string(artifact_name(port.type)) + need_text(port.need) + ")\n";
  }
  if (!stage.outputs.empty()) {
    text += "\nmakes\n";
    for (const OutputPort& port : stage.outputs)
      text += "  " + port.name + " (" + std::string(artifact_name(port.type)) + ")\n";
  }
  text += stage.parameters.empty() ? "\nno parameters\n" : "\nparameters\n";
  for (const Parameter& parameter : stage.parameters) {
    text += "  " + parameter.name + ": " + parameter.default_text + "\n";
    text += "      " + wrapped(expected_values(parameter), 90, "      ") + "\n";
    text += "      " + wrapped(parameter.description, 90, "      ") + "\n";
  }
  return text;
}

std::string parameter_table(const StageDefinition& stage) {
  std::string text = "| parameter | default | values | meaning |\n|---|---|---|---|\n";
  for (const Parameter& parameter : stage.parameters)
    text += "| `" + parameter.name + "` | `" + table_cell(parameter.default_text) + "` | " +
            table_cell(expected_values(parameter)) + " | " + table_cell(parameter.description) + " |\n";
  return text;
}

std::string stage_table() {
  std::string text = "| stage | purpose |\n|---|---|\n";
  for (const StageDefinition* stage : stages_in_order()) {
    const std::string name(stage->info.name);
    text +=
        "| [`" + name + "`](stages/" + name + "/README.md) | " + table_cell(std::string(stage->info.purpose)) + " |\n";
  }
  return text;
}

std::string reference_configuration(const std::string& path) {
  std::string text =
      "# Every key of every stage at its default. Made by `meshmser stages --reference`; a configuration needs only "
      "the\n"
      "# keys that shall differ. Lengths: 0.4 mm, 3 spacing, 0.5 %diag; areas: 1 mm2, 200 spacing2, 0.1 %area.\n"
      "version: 1\n"
      "units: mm  # of the coordinates: mm, um, nm, cm, dm, m, km, in, ft, or unit (none)\n"
      "stages:\n";
  for (const StageDefinition* stage : stages_in_order()) {
    text += "\n  # " + wrapped(std::string(stage->info.purpose), 114, "  # ") + "\n";
    text += "  - " + std::string(stage->info.name) + ":" + (stage->parameters.empty() ? " {}\n" : "\n");
    for (const Parameter& parameter : stage->parameters) {
      text += "      # " + wrapped(parameter.description, 110, "      # ") + "\n";
      text += "      # " + wrapped(expected_values(parameter), 110, "      # ") + "\n";
      const bool is_scan = parameter.shape.kind == ParameterKind::kPath && parameter.default_text == "none";
      text += "      " + parameter.name + ": " + (is_scan ? path : parameter.default_text) + "\n";
    }
  }
  return text;
}

}  // namespace meshmser
