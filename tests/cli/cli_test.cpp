/// The program from outside: exit codes, what goes to stdout and to stderr, help, interruption.

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "tests/support/run_program.hpp"

namespace meshmser {
namespace {

const std::string kSource = MESHMSER_SOURCE_DIR;

class Program : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("meshmser-cli-" + std::to_string(getpid()) + "-" +
                                                        testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  Finished run(const std::vector<std::string>& arguments) const { return run_program(arguments, folder_.string()); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return name;
  }
  // A mesh with its own scalar: the fastest whole run.
  std::string hills() const {
    return write("hills.yaml", "version: 1\nstages:\n  - load: {path: " + kSource +
                                   "/data/hills/hills.ply}\n  - tree: {scalar: quality}\n"
                                   "  - mser: {min_area: 1 %area, min_persistence: 0.1}\n"
                                   "  - borders: {}\n  - export: {pictures: false}\n");
  }

  std::filesystem::path folder_;
};

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> command_names(const std::string& help) {
  std::vector<std::string> names;
  bool listing = false;
  for (const std::string& line : lines_of(help)) {
    if (line == "Subcommands:") listing = true;
    if (listing && line.starts_with("  ") && line.size() > 2 && line[2] != ' ')
      names.push_back(line.substr(2, line.find(' ', 2) - 2));
    if (line.empty() && !names.empty()) break;
  }
  return names;
}

TEST_F(Program, HelpIsEverywhereAndEndsWithAnExample) {
  const Finished help = run({"--help"});
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_EQ(help.err, "");
  const std::vector<std::string> commands = command_names(help.out);
  const std::set<std::string> names(commands.begin(), commands.end());
  for (const char* name :
       {"run", "validate", "explain", "show", "stages", "schema", "cache", "completion", "init", "render", "why"})
    EXPECT_TRUE(names.contains(name)) << name;
  for (const std::string& name : commands) {
    const Finished text = run({name, "--help"});
    EXPECT_EQ(text.exit_code, 0) << name;
    EXPECT_EQ(text.err, "") << name;
    ASSERT_FALSE(lines_of(text.out).empty()) << name;
    EXPECT_TRUE(lines_of(text.out).back().starts_with("Example: ")) << name << ": " << lines_of(text.out).back();
  }
}

TEST_F(Program, VersionIsOneLine) {
  const Finished version = run({"--version"});
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_TRUE(version.out.starts_with("meshmser ")) << version.out;
  EXPECT_EQ(lines_of(version.out).size(), 1u);
}

TEST_F(Program, UsageErrorsAreTwoAndSayWhatIsMeant) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"rn"}, "meshmser: unknown command 'rn', did you mean 'run'?\n"},
      {{"run"}, "meshmser: CONFIG is required; see 'meshmser run --help'\n"},
      {{"run", "--forse"}, "meshmser: run: unknown option '--forse', did you mean '--force'?\n"},
      {{"run", "x.yaml", "--threads", "0"}, "meshmser: --threads: '0' is not a whole number from 1 to 1024\n"},
      {{"stages", "curvatur"}, "meshmser: stages: unknown stage 'curvatur', did you mean 'curvature'?\n"},
      {{"completion", "powershell"}, "meshmser: completion: 'powershell' is not one of bash, zsh\n"},
      {{"cache", "delete"}, "meshmser: cache: 'delete' is not one of ls, verify, gc, clear\n"},
      {{"cache", "gc", "--cache", "c", "--older", "many"},
       "meshmser: cache: --older 'many' is not a number with one of the units d, h, w, min\n"},
  };
  for (const auto& [arguments, message] : cases) {
    const Finished finished = run(arguments);
    EXPECT_EQ(finished.exit_code, 2) << message;
    EXPECT_EQ(finished.err, message);
    EXPECT_EQ(finished.out, "");
  }
  EXPECT_EQ(run({}).exit_code, 2);
  EXPECT_EQ(run({"run", hills(), "--until", "meshh"}).exit_code, 2);
}

TEST_F(Program, ConfigurationErrorsAreThreeWithEveryMessage) {
  write("bad.yaml", "version: 1\nstages:\n  - load: {pth: a.ply}\n  - orientt: {}\n");
  for (const char* command : {"run", "validate", "explain"}) {
    const Finished finished = run({command, "bad.yaml"});
    EXPECT_EQ(finished.exit_code, 3) << command;
    EXPECT_EQ(finished.out, "") << command;
    EXPECT_EQ(finished.err,
              "bad.yaml:3:12: unknown key 'pth' in stage 'load', did you mean 'path'?\n"
              "    - load: {pth: a.ply}\n"
              "             ^\n"
              "bad.yaml:4:5: unknown stage 'orientt', did you mean 'orient'?\n"
              "    - orientt: {}\n"
              "      ^\n");
  }
  const Finished set = run({"validate", hills(), "--set", "tree.levels=1"});
  EXPECT_EQ(set.exit_code, 3);
  EXPECT_EQ(set.err, "--set tree.levels=1: '1' is out of range, expected from 2 to 1000000\n");
}

TEST_F(Program, UnreadableInputIsFour) {
  write("c.yaml", "version: 1\nstages:\n  - load: {path: not-there.ply}\n  - orient: {}\n");
  const Finished finished = run({"run", "c.yaml"});
  EXPECT_EQ(finished.exit_code, 4);
  EXPECT_NE(finished.err.find("not-there.ply"), std::string::npos) << finished.err;
  write("broken.ply",
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
        "end_header\n0 0 0\n1 one 1\n");
  const Finished broken = run({"run", "c.yaml", "--set", "load.path=broken.ply"});
  EXPECT_EQ(broken.exit_code, 4);
  EXPECT_NE(broken.err.find("broken.ply:9"), std::string::npos) << broken.err;
}

TEST_F(Program, AStageThatCannotDoItsWorkIsFive) {
  const Finished finished = run({"run", hills(), "--set", "tree.scalar=temperature"});
  EXPECT_EQ(finished.exit_code, 5);
  EXPECT_NE(finished.err.find("temperature"), std::string::npos) << finished.err;
}

TEST_F(Program, ACacheThatCannotBeWrittenIsSix) {
  const Finished finished = run({"run", hills(), "--cache", "/dev/null/cache"});
  EXPECT_EQ(finished.exit_code, 6) << finished.err;
}

TEST_F(Program, ResultsThatCannotBeWrittenAreNoSuccess) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  const std::string command = std::string(MESHMSER_PROGRAM) + " stages > /dev/full 2> /dev/null";
  EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 6);
}

TEST_F(Program, RunPrintsItsFilesAndTheSecondRunMakesNothing) {
  const Finished first = run({"run", hills(), "--out", "out"});
  ASSERT_EQ(first.exit_code, 0) << first.err;
  const std::vector<std::string> files = lines_of(first.out);
  EXPECT_GE(files.size(), 5u);
  for (const std::string& file : files) EXPECT_TRUE(std::filesystem::exists(folder_ / file)) << file;
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out" / "run.json"));

  const Finished plan = run({"run", hills(), "--out", "out", "-n"});
  EXPECT_EQ(plan.exit_code, 0);
  ASSERT_EQ(lines_of(plan.out).size(), 5u) << plan.out;
  for (const std::string& line : lines_of(plan.out)) EXPECT_NE(line.find(" cached"), std::string::npos) << line;

  const Finished changed = run({"run", hills(), "-n", "--set", "mser.min_area=2 %area"});
  const std::vector<std::string> lines = lines_of(changed.out);
  ASSERT_EQ(lines.size(), 5u);
  EXPECT_NE(lines[1].find("cached"), std::string::npos) << lines[1];
  EXPECT_NE(lines[2].find("would run"), std::string::npos) << lines[2];
  EXPECT_NE(lines[2].find("min_area"), std::string::npos) << lines[2];
  const Finished why = run({"explain", hills(), "mser", "--set", "mser.min_area=2 %area"});
  EXPECT_EQ(lines_of(why.out).size(), 1u);
  EXPECT_NE(why.out.find("mser.min_area"), std::string::npos) << why.out;

  const Finished again = run({"run", hills(), "--out", "out", "--quiet"});
  EXPECT_EQ(again.exit_code, 0);
  EXPECT_EQ(again.out, first.out);
}

TEST_F(Program, ForceTakesAStageOrNothing) {
  ASSERT_EQ(run({"run", hills(), "--quiet"}).exit_code, 0);
  const std::vector<std::string> plan = lines_of(run({"run", "--force", "tree", hills(), "-n"}).out);
  ASSERT_EQ(plan.size(), 5u);
  EXPECT_NE(plan[0].find("cached"), std::string::npos) << plan[0];
  EXPECT_NE(plan[1].find("forced"), std::string::npos) << plan[1];
  for (const std::vector<std::string>& arguments : {std::vector<std::string>{"run", hills(), "-n", "--force"},
                                                    {"run", "-n", "--force", hills()},
                                                    {"run", "--force", "-n", hills()}}) {
    const std::vector<std::string> lines = lines_of(run(arguments).out);
    ASSERT_EQ(lines.size(), 5u);
    for (const std::string& line : lines) EXPECT_NE(line.find("forced"), std::string::npos) << line;
  }
}

TEST_F(Program, ShowTellsWhatAStageMade) {
  ASSERT_EQ(run({"run", hills(), "--quiet"}).exit_code, 0);
  const Finished shown = run({"show", hills(), "mser"});
  EXPECT_EQ(shown.exit_code, 0) << shown.err;
  EXPECT_NE(shown.out.find("num_regions"), std::string::npos) << shown.out;
  EXPECT_EQ(run({"show", hills(), "mserr"}).exit_code, 2);
}

TEST_F(Program, ReportMakesThePageOfAConfigurationWithoutOne) {
  const std::string config = hills();
  const Finished made = run({"report", config, "--out", "page", "-q"});
  EXPECT_EQ(made.exit_code, 0) << made.err;
  EXPECT_EQ(made.out, "page/report.html\n");
  std::ifstream file(folder_ / "page/report.html");
  const std::string page((std::istreambuf_iterator<char>(file)), {});
  // What the stage appends, then what the run appends: run.json with the report's own record.
  EXPECT_NE(page.find("<script type=\"application/json\" id=\"header\">{\"title\":"), std::string::npos);
  const std::size_t record = page.rfind("<script type=\"application/json\" id=\"run\">{");
  ASSERT_NE(record, std::string::npos);
  EXPECT_NE(page.find("\"stage\": \"report\"", record), std::string::npos);
  // A second time the page on disk differs from the cache's by that record, and holds it once only.
  EXPECT_EQ(run({"report", config, "--out", "page", "-q"}).exit_code, 0);
  std::ifstream again(folder_ / "page/report.html");
  const std::string second((std::istreambuf_iterator<char>(again)), {});
  EXPECT_EQ(second.find("id=\"run\">{"), second.rfind("id=\"run\">{"));
}

TEST_F(Program, CacheIsListedVerifiedAndCleared) {
  ASSERT_EQ(run({"run", hills(), "--quiet", "--cache", "c"}).exit_code, 0);
  EXPECT_EQ(lines_of(run({"cache", "ls", "--cache", "c"}).out).size(), 6u);  // five entries and their sum
  EXPECT_EQ(run({"cache", "verify", "--cache", "c"}).out, "5 entries, 0 damaged\n");
  EXPECT_EQ(run({"cache", "gc", "--cache", "c", "--max-size", "0 MB"}).exit_code, 0);
  EXPECT_EQ(lines_of(run({"cache", "ls", "--cache", "c"}).out).size(), 1u);
  ASSERT_EQ(run({"run", hills(), "--quiet", "--cache", "c"}).exit_code, 0);
  EXPECT_EQ(run({"cache", "clear", "--cache", "c"}).exit_code, 0);
  EXPECT_EQ(lines_of(run({"cache", "ls", "--cache", "c"}).out).size(), 1u);
}

TEST_F(Program, InitWritesAConfigurationThatIsValid) {
  const Finished init = run({"init", kSource + "/data/demo/tablet.ply"});
  ASSERT_EQ(init.exit_code, 0) << init.err;
  EXPECT_EQ(init.out, "tablet.yaml\n");
  const Finished valid = run({"validate", "tablet.yaml"});
  EXPECT_EQ(valid.exit_code, 0) << valid.err;
  // What is there is not overwritten.
  EXPECT_EQ(run({"init", kSource + "/data/demo/tablet.ply"}).exit_code, 2);
  ASSERT_EQ(run({"init", kSource + "/data/hills/hills.ply", "--out", "mesh.yaml"}).exit_code, 0);
  const Finished mesh = run({"run", "mesh.yaml", "--quiet", "--out", "out"});
  EXPECT_EQ(mesh.exit_code, 0) << mesh.err;
}

TEST_F(Program, WhyTellsTheFateOfEveryNodeAroundAPlace) {
  const std::string config = hills();
  const Finished told = run({"why", config, "--triangle", "0"});
  EXPECT_EQ(told.exit_code, 0) << told.err;
  const std::vector<std::string> lines = lines_of(told.out);
  ASSERT_GT(lines.size(), 6u) << told.out;
  EXPECT_EQ(lines[0], "triangle 0");
  EXPECT_TRUE(lines[5].starts_with("upper tree, ")) << lines[5];
  const auto root_of = [](const std::string& out) {
    for (const std::string& line : lines_of(out))
      if (line.ends_with("a root: it has no level border")) return line;
    return std::string();
  };
  EXPECT_NE(root_of(told.out), "") << told.out;
  // The same triangle by its centroid.
  const std::size_t centroid = lines[1].find("centroid ");
  ASSERT_NE(centroid, std::string::npos) << lines[1];
  const Finished by_point = run({"why", config, "--point=" + lines[1].substr(centroid + 9)});
  EXPECT_EQ(by_point.exit_code, 0) << by_point.err;
  EXPECT_TRUE(by_point.out.starts_with("triangle 0, nearest to ")) << by_point.out;
  EXPECT_EQ(root_of(by_point.out), root_of(told.out));
  // And by one of its corners, which may stand in an earlier triangle.
  std::istringstream corners(lines[1].substr(lines[1].find("vertices ") + 9));
  std::string corner;
  corners >> corner;
  const Finished by_vertex = run({"why", config, "--vertex", corner});
  EXPECT_EQ(by_vertex.exit_code, 0) << by_vertex.err;
  EXPECT_TRUE(by_vertex.out.starts_with("triangle 0, the first at vertex " + corner)) << by_vertex.out;
  EXPECT_EQ(root_of(by_vertex.out), root_of(told.out));
  EXPECT_EQ(run({"why", config}).exit_code, 2);
  const std::string elsewhere = (folder_ / "elsewhere").string();
  EXPECT_EQ(run({"why", config, "--triangle", "0", "--cache", elsewhere}).exit_code, 0);
  EXPECT_TRUE(std::filesystem::is_directory(elsewhere)) << "the cache that was asked for";
  const Finished wrong = run({"why", config, "--point", "1,2"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_NE(wrong.err.find("three numbers x,y,z"), std::string::npos) << wrong.err;
  EXPECT_EQ(run({"why", config, "--vertex", "100000000"}).exit_code, 2);
}

TEST_F(Program, CompletionIsGoodShell) {
  write("bash", run({"completion", "bash"}).out);
  const std::string check = "bash -n " + (folder_ / "bash").string();
  EXPECT_EQ(std::system(check.c_str()), 0);
  const std::string complete = "bash -c 'source " + (folder_ / "bash").string() +
                               "; COMP_WORDS=(meshmser stages cur); COMP_CWORD=2; _meshmser; echo ${COMPREPLY[@]}' > " +
                               (folder_ / "words").string();
  ASSERT_EQ(std::system(complete.c_str()), 0);
  std::ifstream words(folder_ / "words");
  std::string line;
  std::getline(words, line);
  EXPECT_EQ(line, "curvature");
}

TEST_F(Program, InterruptionIsQuickSaysWhatIsCachedAndLosesNothing) {
  const std::string config = write("tablet.yaml", "version: 1\nunits: mm\nstages:\n  - load: {path: " + kSource +
                                                      "/data/demo/tablet.ply}\n  - orient: {}\n  - curvature: {}\n"
                                                      "  - mesh: {}\n  - tree: {}\n  - mser: {}\n  - borders: {}\n"
                                                      "  - export: {}\n");
  const std::vector<std::string> arguments = {"run", config, "--out", "out", "--cache", "c"};
  const Finished cut = run_program(arguments, folder_.string(), "[8/8]");
  EXPECT_EQ(cut.exit_code, 130) << cut.err;
  EXPECT_NE(cut.err.find("in the cache: load, orient, curvature, mesh, tree, mser, borders"), std::string::npos)
      << cut.err;
  const std::vector<std::string> plan = lines_of(run({"run", config, "--out", "out", "--cache", "c", "-n"}).out);
  ASSERT_EQ(plan.size(), 8u);
  for (std::size_t i = 0; i < 7; ++i) EXPECT_NE(plan[i].find("cached"), std::string::npos) << plan[i];
  EXPECT_NE(plan[7].find("run"), std::string::npos) << plan[7];
  const Finished again = run_program(arguments, folder_.string());
  EXPECT_EQ(again.exit_code, 0) << again.err;
}

}  // namespace
}  // namespace meshmser
