/// Whole runs: every configuration of the folder, the same bytes for any number of threads, what is run again.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "tests/support/run_program.hpp"

namespace meshmser {
namespace {

const std::filesystem::path kSource = MESHMSER_SOURCE_DIR;

std::string read(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, separator);) parts.push_back(part);
  return parts;
}

class EndToEnd : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("meshmser-e2e-" + std::to_string(getpid()) + "-" +
                                                        testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  // Runs a configuration of the folder into `out`, with a cache of its own, without pictures.
  Finished run(const std::string& config, const std::string& out, std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments = {"run",   (kSource / "configs" / config).string(),
                                          "--out", (folder_ / out).string(),
                                          "--set", "export.pictures=false"};
    if (std::find(more.begin(), more.end(), "--cache") == more.end())
      more.insert(more.end(), {"--cache", (folder_ / (out + "-cache")).string()});
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments, folder_.string());
  }

  // Rows of a table without its header.
  std::size_t num_rows(const std::string& file) const {
    const auto lines = split(read(folder_ / file), '\n');
    return lines.empty() ? 0 : lines.size() - 1;
  }

  // Contents of a folder's files but run.json and the page that bears it: they hold times.
  std::map<std::string, std::string> contents(const std::string& out) const {
    std::map<std::string, std::string> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / out))
      if (entry.path().filename() != "run.json" && entry.path().extension() != ".html")
        files[entry.path().filename()] = read(entry.path());
    return files;
  }

  std::filesystem::path folder_;
};

// The tablet bears 25 glyphs, two of them cut by holes; thin strokes may part from a glyph.
TEST_F(EndToEnd, DemoFindsTheGlyphs) {
  const Finished finished = run("demo.yaml", "out");
  ASSERT_EQ(finished.exit_code, 0) << finished.err;
  const std::size_t regions = num_rows("out/regions.csv");
  EXPECT_GE(regions, 23u);
  EXPECT_LE(regions, 32u);
  // Every loop of borders.csv is closed: each edge begins where the one before it ends, the first where the last ends.
  std::map<std::string, std::vector<std::vector<std::string>>> loops;
  const auto lines = split(read(folder_ / "out/borders.csv"), '\n');
  ASSERT_GT(lines.size(), 100u);
  EXPECT_TRUE(lines[0].starts_with("region,loop,edge,x0,y0,z0,x1,y1,z1,kind,neighbour")) << lines[0];
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const auto cells = split(lines[i], ',');
    ASSERT_GE(cells.size(), 10u) << lines[i];
    loops[cells[0] + "/" + cells[1]].push_back(cells);
  }
  EXPECT_GE(loops.size(), regions);
  for (const auto& [name, edges] : loops)
    for (std::size_t k = 0; k < edges.size(); ++k) {
      const auto& next = edges[(k + 1) % edges.size()];
      const bool joined = edges[k][6] == next[3] && edges[k][7] == next[4] && edges[k][8] == next[5];
      ASSERT_TRUE(joined) << "loop " << name << " is open after its edge " << k;
    }
}

TEST_F(EndToEnd, AMeshWithItsOwnScalarNeedsNoPoints) {
  const Finished finished = run("mesh.yaml", "out");
  ASSERT_EQ(finished.exit_code, 0) << finished.err;
  EXPECT_EQ(num_rows("out/regions.csv"), 5u);  // as many as hills
}

TEST_F(EndToEnd, ValuesForAnotherRuleAreToldOfAndLevelsHaveTheScalarsOwnSign) {
  const Finished finished = run("mesh.yaml", "out",
                                {"--set", "tree.polarity=lower", "--set", "tree.level_rule=list", "--set",
                                 "tree.level_list=[0.5, 0.25]", "--set", "tree.level_step=2", "--set", "mser.level=3"});
  ASSERT_EQ(finished.exit_code, 0) << finished.err;
  EXPECT_NE(finished.err.find("tree: level_step is given but changes nothing: only level_rule: step uses it"),
            std::string::npos)
      << finished.err;
  EXPECT_NE(finished.err.find("mser: level is given but changes nothing"), std::string::npos) << finished.err;
  EXPECT_EQ(finished.err.find("level_list"), std::string::npos) << finished.err;
  const std::string report = read(folder_ / "out/run.json");
  for (const std::string figure : {"\"least_level_lower\"", "\"greatest_level_lower\""}) {
    const std::size_t at = report.find(figure);
    ASSERT_NE(at, std::string::npos);
    const std::string value = report.substr(at, 80);
    EXPECT_NE(value.find(figure.find("least") == 1 ? "0.25" : "0.5"), std::string::npos) << value;
    EXPECT_EQ(value.find('-'), std::string::npos) << value;
  }
}

TEST_F(EndToEnd, EveryConfigurationRuns) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kSource / "configs")) {
    const std::string name = entry.path().filename();
    if (entry.path().extension() != ".yaml" || name == "demo.yaml" || name == "mesh.yaml") continue;
    const Finished finished = run(name, name + "-out", {"--cache", (folder_ / "cache").string()});
    EXPECT_EQ(finished.exit_code, 0) << name << "\n" << finished.err;
    EXPECT_GE(num_rows(name + "-out/regions.csv"), 1u) << name;
    ++count;
  }
  EXPECT_GE(count, 4);
}

TEST_F(EndToEnd, AnyNumberOfThreadsGivesTheSameBytes) {
  for (const char* threads : {"1", "2", "7"}) {
    const Finished finished = run("demo.yaml", threads, {"--threads", threads});
    ASSERT_EQ(finished.exit_code, 0) << finished.err;
  }
  const auto one = contents("1"), two = contents("2"), seven = contents("7");
  ASSERT_GE(one.size(), 7u);
  ASSERT_EQ(one.size(), two.size());
  for (const auto& [name, bytes] : one) {
    EXPECT_TRUE(two.at(name) == bytes) << name << " differs with 2 threads";
    EXPECT_TRUE(seven.at(name) == bytes) << name << " differs with 7 threads";
  }
}

TEST_F(EndToEnd, OnlyWhatChangedRunsAgain) {
  ASSERT_EQ(run("demo.yaml", "out").exit_code, 0);
  const auto outcome = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"-n"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    std::string running;
    for (const std::string& line : split(run("demo.yaml", "out", arguments).out, '\n'))
      if (line.find(" cached") == std::string::npos) running += line.substr(0, line.find(' ')) + " ";
    return running;
  };
  EXPECT_EQ(outcome({}), "");
  EXPECT_EQ(outcome({"--threads", "1"}), "");
  EXPECT_TRUE(outcome({"--set", "mser.min_area=2 mm2"}).starts_with("mser borders export "));
  EXPECT_TRUE(outcome({"--set", "orient.neighbors=20"}).starts_with("orient curvature mesh tree mser "));
  const Finished again = run("demo.yaml", "out");
  EXPECT_EQ(again.exit_code, 0);
  EXPECT_LT(again.seconds, 3) << again.err;
}

}  // namespace
}  // namespace meshmser
