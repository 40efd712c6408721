#include <cmath>
#include <nlohmann/json.hpp>

#include "pipeline/config/describe.hpp"

namespace meshmser {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kNumberPattern = R"(^[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)? *)";
constexpr const char* kLengthUnits = "km|m|dm|cm|mm|um|nm|in|ft|unit";

Json quantity(const std::string& units) {
  std::string pattern = kNumberPattern;
  pattern.append("(").append(units).append(")$");
  return {{"type", "string"}, {"pattern", pattern}};
}

Json bounded(const char* type, const Range& bounds) {
  Json schema = {{"type", type}};
  if (std::isfinite(bounds.least)) schema[bounds.least_excluded ? "exclusiveMinimum" : "minimum"] = bounds.least;
  if (std::isfinite(bounds.greatest)) schema["maximum"] = bounds.greatest;
  return schema;
}

Json any_of(Json first, Json second) {
  return {{"anyOf", Json::array({std::move(first), std::move(second)})}};
}

Json map_schema(const std::vector<Parameter>& parameters);

Json shape_schema(const ParameterShape& shape, const Range& bounds) {
  switch (shape.kind) {
    case ParameterKind::kInteger:
      return bounded("integer", bounds);
    case ParameterKind::kNumber:
      return bounded("number", bounds);
    case ParameterKind::kBoolean:
      return {{"type", "boolean"}};
    case ParameterKind::kText:
    case ParameterKind::kPath:
      return {{"type", Json::array({"string", "number", "boolean"})}};
    case ParameterKind::kChoice:
      return {{"enum", shape.choices}};
    case ParameterKind::kLength:
      return quantity(std::string(kLengthUnits) + "|spacing|%diag");
    case ParameterKind::kArea:
      return quantity(std::string("(").append(kLengthUnits).append("|spacing)2|%area"));
    case ParameterKind::kAmount:
      return any_of(bounded("number", bounds), quantity("noise"));
    case ParameterKind::kAngle:
      return quantity("deg");
    case ParameterKind::kShare:
      return any_of(bounded("number", bounds), quantity("%"));
    case ParameterKind::kList: {
      Json schema = {{"type", "array"}, {"items", shape_schema(*shape.element, bounds)}};
      if (shape.size) schema["minItems"] = schema["maxItems"] = *shape.size;
      return schema;
    }
    case ParameterKind::kMap:
      return map_schema(*shape.fields);
  }
  return {};
}

Json parameter_schema(const Parameter& parameter) {
  Json schema = shape_schema(parameter.shape, parameter.range);
  if (!parameter.shape.words.empty()) schema = any_of({{"enum", parameter.shape.words}}, std::move(schema));
  schema["description"] = parameter.description + " Default: " + parameter.default_text;
  return schema;
}

Json map_schema(const std::vector<Parameter>& parameters) {
  Json properties = Json::object();
  for (const Parameter& parameter : parameters) properties[parameter.name] = parameter_schema(parameter);
  return {{"type", "object"}, {"properties", properties}, {"additionalProperties", false}};
}

Json stage_schema(const StageDefinition& stage) {
  Json schema = map_schema(stage.parameters);
  schema["type"] = Json::array({"object", "null"});
  schema["description"] = stage.info.purpose;
  Json name = {{"type", "string"}, {"pattern", "^[A-Za-z][A-Za-z0-9_-]*$"}};
  Json inputs = Json::object();
  for (const InputPort& port : stage.inputs)
    inputs[port.name] = port.need == Need::kAll ? any_of(name, {{"type", "array"}, {"items", name}}) : name;
  schema["properties"]["inputs"] = {{"type", "object"},
                                    {"properties", inputs},
                                    {"additionalProperties", false},
                                    {"description", "Which earlier stage gives an input, where not the nearest one."}};
  name["description"] = "A name by which later stages refer to this one; default: the stage's own.";
  schema["properties"]["name"] = name;
  return schema;
}

const char* kind_name(ParameterKind kind) {
  static constexpr const char* kNames[] = {"integer", "number", "boolean", "text", "choice", "length", "area",
                                           "amount",  "angle",  "share",   "path", "list",   "map"};
  return kNames[static_cast<int>(kind)];
}

const char* need_name(Need need) {
  return need == Need::kRequired ? "required" : need == Need::kOptional ? "optional" : "all";
}

Json parameter_json(const Parameter& parameter) {
  Json json = {{"name", parameter.name},
               {"type", kind_name(parameter.shape.kind)},
               {"default", parameter.default_text},
               {"values", expected_values(parameter)},
               {"unit", parameter.unit},
               {"meaning", parameter.description},
               {"affects_result", parameter.affects_result}};
  if (std::isfinite(parameter.range.least))
    json[parameter.range.least_excluded ? "more_than" : "least"] = parameter.range.least;
  if (std::isfinite(parameter.range.greatest)) json["greatest"] = parameter.range.greatest;
  if (!parameter.shape.choices.empty()) json["choices"] = parameter.shape.choices;
  if (!parameter.shape.words.empty()) json["words"] = parameter.shape.words;
  return json;
}

Json definition_json(const StageDefinition& stage) {
  Json json = {{"name", stage.info.name}, {"version", stage.info.version}, {"purpose", stage.info.purpose},
               {"inputs", Json::array()}, {"outputs", Json::array()},      {"parameters", Json::array()}};
  for (const InputPort& port : stage.inputs)
    json["inputs"].push_back({{"name", port.name}, {"type", artifact_name(port.type)}, {"need", need_name(port.need)}});
  for (const OutputPort& port : stage.outputs)
    json["outputs"].push_back({{"name", port.name}, {"type", artifact_name(port.type)}});
  for (const Parameter& parameter : stage.parameters) json["parameters"].push_back(parameter_json(parameter));
  return json;
}

}  // namespace

std::string stage_json(const StageDefinition& stage) {
  return definition_json(stage).dump(2) + "\n";
}

std::string stages_json() {
  Json list = Json::array();
  for (const StageDefinition* stage : stages_in_order()) list.push_back(definition_json(*stage));
  return list.dump(2) + "\n";
}

std::string json_schema() {
  Json definitions = Json::object(), properties = Json::object();
  for (const StageDefinition* stage : stages_in_order()) {
    const std::string name(stage->info.name);
    definitions[name] = stage_schema(*stage);
    properties[name] = {{"$ref", "#/$defs/" + name}};
  }
  const Json units = {"mm", "um", "nm", "cm", "dm", "m", "km", "in", "ft", "unit"};
  const Json stage = {{"type", "object"},
                      {"properties", properties},
                      {"additionalProperties", false},
                      {"minProperties", 1},
                      {"maxProperties", 1}};
  const Json schema = {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                       {"title", "meshmser configuration"},
                       {"type", "object"},
                       {"required", {"version", "stages"}},
                       {"additionalProperties", false},
                       {"properties",
                        {{"version", {{"const", 1}}},
                         {"units", {{"enum", units}, {"description", "Unit of the coordinates."}}},
                         {"stages", {{"type", "array"}, {"minItems", 1}, {"items", stage}}}}},
                       {"$defs", definitions}};
  return schema.dump(2) + "\n";
}

}  // namespace meshmser
