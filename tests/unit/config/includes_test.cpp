/// Who may include whom: the rooms of the house know only what they must.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <string>
#include <vector>

namespace meshmser {
namespace {

const std::filesystem::path kSource = MESHMSER_SOURCE_DIR;

struct Include {
  std::string file;     ///< that includes, from the root of the source
  std::string target;   ///< what is included
  bool quoted = false;  ///< one of ours
};

std::vector<Include> includes_under(const std::string& folder) {
  const std::regex directive(R"re(^\s*#\s*include\s*(["<])([^">]+)[">])re");
  std::vector<Include> found;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(kSource / folder)) {
    const auto extension = entry.path().extension();
    if (extension != ".hpp" && extension != ".cpp") continue;
    std::ifstream file(entry.path());
    std::smatch match;
    for (std::string line; std::getline(file, line);)
      if (std::regex_search(line, match, directive))
        found.push_back({std::filesystem::relative(entry.path(), kSource).string(), match[2], match[1] == "\""});
  }
  return found;
}

bool begins_with_any(const std::string& text, const std::vector<std::string>& beginnings) {
  return std::any_of(beginnings.begin(), beginnings.end(), [&](const auto& b) { return text.starts_with(b); });
}

void expect_only(const std::string& folder, std::vector<std::string> allowed) {
  allowed.push_back(folder + "/");
  allowed.push_back("pipeline/execution/");
  int seen = 0;
  for (const Include& include : includes_under(folder)) {
    ++seen;
    const bool good = !include.quoted || begins_with_any(include.target, allowed);
    EXPECT_TRUE(good) << include.file << " includes " << include.target;
  }
  EXPECT_GT(seen, 0) << folder;
}

TEST(Includes, RoomsOfThePipelineKnowOnlyWhatTheyMust) {
  expect_only("pipeline/artifacts", {});
  expect_only("pipeline/execution", {});
  expect_only("pipeline/formats", {"pipeline/artifacts/"});
  expect_only("pipeline/stage", {"pipeline/artifacts/"});
  expect_only("pipeline/config", {"pipeline/artifacts/", "pipeline/formats/", "pipeline/stage/"});
  expect_only("pipeline/cache", {"pipeline/artifacts/", "pipeline/formats/", "pipeline/stage/"});
  expect_only("pipeline/run", {"pipeline/"});
  expect_only("pipeline/cli", {"pipeline/"});
}

TEST(Includes, StagesKnowNoOtherStage) {
  for (const auto& entry : std::filesystem::directory_iterator(kSource / "stages")) {
    if (!entry.is_directory()) continue;
    const std::string stage = entry.path().filename();
    for (const Include& include : includes_under("stages/" + stage)) {
      if (!include.quoted) continue;
      std::vector<std::string> allowed = {"pipeline/artifacts/", "pipeline/execution/", "stages/common/",
                                          "stages/" + stage + "/"};
      const std::string name = std::filesystem::path(include.file).filename();
      // The adapter: the stage, its commands, and the parameters both declare from.
      const bool adapter = name == "stage.cpp" || name.ends_with("_command.cpp") || name == stage + "_parameters.hpp";
      if (adapter) allowed.push_back("pipeline/stage/");
      if (stage != "common") allowed.push_back("pipeline/formats/");  // load reads files, export writes them
      EXPECT_TRUE(begins_with_any(include.target, allowed)) << include.file << " includes " << include.target;
    }
  }
}

TEST(Includes, YamlStandsInConfigOnly) {
  for (const char* folder : {"pipeline", "stages"})
    for (const Include& include : includes_under(folder)) {
      const bool good = !include.target.starts_with("yaml-cpp") || include.file == "pipeline/config/yaml.cpp";
      EXPECT_TRUE(good) << include.file << " includes " << include.target;
    }
}

TEST(Includes, HeavyLibrariesStandInNoHeader) {
  for (const char* folder : {"pipeline", "stages", "data"})
    for (const Include& include : includes_under(folder)) {
      const bool heavy = begins_with_any(include.target, {"CGAL/", "pcl/", "flann/", "embree", "yaml-cpp/", "CLI/"});
      EXPECT_TRUE(!heavy || include.file.ends_with(".cpp")) << include.file << " includes " << include.target;
    }
}

}  // namespace
}  // namespace meshmser
