/// What holds for every stage: folders, tables, reference, schema, parameters that read back as they are written.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "pipeline/config/configuration.hpp"
#include "pipeline/config/describe.hpp"
#include "pipeline/config/yaml.hpp"

namespace meshmser {
namespace {

const std::filesystem::path kSource = MESHMSER_SOURCE_DIR;

// The expected texts that are generated are written anew in place of being compared.
bool updating() {
  return std::getenv("MESHMSER_UPDATE_EXPECTED") != nullptr;
}

void write(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

std::string read(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file) << path;
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

TEST(Stages, FoldersEqualTheRegistry) {
  std::set<std::string> folders, registered;
  for (const auto& entry : std::filesystem::directory_iterator(kSource / "stages"))
    if (std::filesystem::exists(entry.path() / "stage.cpp")) folders.insert(entry.path().filename());
  for (const StageDefinition* stage : all_stages()) registered.emplace(stage->info.name);
  EXPECT_EQ(folders, registered);
  EXPECT_GE(folders.size(), 8u);
}

TEST(Stages, CommonIsTheOnlyOtherFolder) {
  for (const auto& entry : std::filesystem::directory_iterator(kSource / "stages"))
    if (entry.is_directory() && !std::filesystem::exists(entry.path() / "stage.cpp")) {
      EXPECT_EQ(entry.path().filename(), "common");
    }
}

TEST(Stages, ReadmesHoldTheGeneratedTable) {
  const std::string begin = "<!-- parameters -->", end = "<!-- /parameters -->";
  for (const StageDefinition* stage : all_stages()) {
    const std::filesystem::path path = kSource / "stages" / std::string(stage->info.name) / "README.md";
    const std::string text = read(path);
    const std::size_t first = text.find(begin), last = text.find(end);
    ASSERT_TRUE(first != std::string::npos && last != std::string::npos && first < last)
        << path << " lacks the marks of its parameter table";
    const std::string expected = text.substr(0, first) + begin + "\n" + parameter_table(*stage) + text.substr(last);
    EXPECT_EQ(text, expected) << path << ": write the table again with MESHMSER_UPDATE_EXPECTED=1 config_test";
    if (updating()) write(path, expected);
  }
}

TEST(Stages, ReferenceConfigurationIsTheGeneratedOneAndValid) {
  const std::filesystem::path path = kSource / "configs" / "reference.yaml";
  const std::string expected = reference_configuration("../data/demo/tablet.ply");
  EXPECT_EQ(read(path), expected) << "write it again: meshmser stages --reference > configs/reference.yaml";
  if (updating()) write(path, expected);
  const Configuration configuration = load_configuration(path);
  ASSERT_EQ(configuration.stages.size(), all_stages().size());
  // Every key stands at its default, but the path of the scan.
  for (const StageEntry& stage : configuration.stages)
    for (const Parameter& parameter : stage.definition->parameters)
      if (parameter.shape.kind != ParameterKind::kPath) {
        EXPECT_EQ(parameter.format(stage.parameters.get()), parameter.default_text)
            << stage.name << "." << parameter.name;
      }
}

TEST(Stages, EveryConfigurationOfTheFolderIsValid) {
  int count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(kSource / "configs")) {
    if (entry.path().extension() != ".yaml") continue;
    EXPECT_NO_THROW(load_configuration(entry.path())) << entry.path();
    ++count;
  }
  EXPECT_GE(count, 11);  // those to start from, and the figures'

}

TEST(Stages, TheyComeInTheOrderOfTheirPorts) {
  const std::vector<const StageDefinition*> stages = stages_in_order();
  std::size_t next = 0;
  for (const char* name : {"load", "orient", "curvature", "mesh", "tree", "mser", "borders", "export"}) {
    while (next < stages.size() && stages[next]->info.name != name) ++next;
    EXPECT_LT(next, stages.size()) << name << " stands too early";
  }
}

// Random valid parameters, written out and read back, are written out the same; in every unit and order of chance.
TEST(Parameters, ReadBackAsTheyAreWritten) {
  std::mt19937_64 random(7);
  for (const StageDefinition* stage : all_stages())
    for (int round = 0; round < 200; ++round) {
      const std::shared_ptr<void> given = stage->make_parameters(), bound = stage->make_parameters();
      std::string text = "{";
      for (const Parameter& parameter : stage->parameters) {
        parameter.randomize(given.get(), random);
        text += (text.size() > 1 ? ", " : "") + parameter.name + ": " + parameter.format(given.get());
      }
      text += "}";
      std::vector<Diagnostic> problems;
      const ConfigValue map = read_yaml(text, "random", problems);
      bind_map(map, stage->parameters, {"mm", ""}, "stage", bound.get(), problems);
      ASSERT_TRUE(problems.empty()) << stage->info.name << ": " << problems.front().message << "\n" << text;
      for (const Parameter& parameter : stage->parameters)
        ASSERT_EQ(parameter.format(bound.get()), parameter.format(given.get())) << parameter.name << "\n" << text;
    }
}

TEST(Parameters, EachIsDeclaredOnceWithASentence) {
  for (const StageDefinition* stage : all_stages()) {
    std::set<std::string> names = {"name", "inputs"};  // reserved
    for (const Parameter& parameter : stage->parameters) {
      EXPECT_TRUE(names.insert(parameter.name).second) << stage->info.name << "." << parameter.name;
      EXPECT_FALSE(parameter.description.empty()) << stage->info.name << "." << parameter.name;
      EXPECT_EQ(parameter.description.back(), '.') << stage->info.name << "." << parameter.name;
    }
  }
}

TEST(Descriptions, JsonHoldsEveryParameter) {
  const auto list = nlohmann::json::parse(stages_json());
  ASSERT_EQ(list.size(), all_stages().size());
  for (const auto& json : list) {
    const StageDefinition* stage = find_stage(json["name"].get<std::string>());
    ASSERT_NE(stage, nullptr);
    EXPECT_EQ(json["parameters"].size(), stage->parameters.size());
    EXPECT_EQ(nlohmann::json::parse(stage_json(*stage)), json);
  }
}

TEST(Descriptions, SchemaHoldsEveryKeyOfEveryStage) {
  const auto schema = nlohmann::json::parse(json_schema());
  for (const StageDefinition* stage : all_stages()) {
    const auto& properties = schema["$defs"][std::string(stage->info.name)]["properties"];
    EXPECT_EQ(properties.size(), stage->parameters.size() + 2) << stage->info.name;  // and name, inputs
    for (const Parameter& parameter : stage->parameters) EXPECT_TRUE(properties.contains(parameter.name));
  }
}

TEST(Descriptions, HelpOfAStageTellsItsParameters) {
  for (const StageDefinition* stage : all_stages()) {
    const std::string text = describe_stage(*stage);
    for (const Parameter& parameter : stage->parameters)
      EXPECT_NE(text.find("  " + parameter.name + ": " + parameter.default_text + "\n"), std::string::npos)
          << stage->info.name << "." << parameter.name;
  }
}

}  // namespace
}  // namespace meshmser
