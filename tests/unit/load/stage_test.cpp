#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>
#include <sstream>
#include <tuple>

#include "pipeline/stage/command.hpp"
#include "tests/support/temporary_files.hpp"

namespace meshmser {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A value as a configuration would hold it.
ConfigValue text(const std::string& value) {
  ConfigValue v;
  v.kind = ConfigValue::Kind::kScalar;
  v.text = value;
  return v;
}
ConfigValue list(const std::vector<ConfigValue>& items) {
  ConfigValue v;
  v.kind = ConfigValue::Kind::kList;
  v.items = items;
  return v;
}
ConfigValue map(const std::vector<std::pair<std::string, ConfigValue>>& entries) {
  ConfigValue v;
  v.kind = ConfigValue::Kind::kMap;
  v.entries = entries;
  v.key_locations.resize(entries.size());
  return v;
}
ConfigValue numbers(const std::vector<double>& values) {
  std::vector<ConfigValue> items;
  for (const double value : values) items.push_back(text(format_number(value)));
  return list(items);
}

class LoadStageTest : public ::testing::Test {
 protected:
  /// Binds, fails on diagnostics.
  std::shared_ptr<void> bind(const std::vector<std::pair<std::string, ConfigValue>>& entries) {
    BindContext context;
    context.units = "mm";
    context.base_directory = folder_.path().string();
    std::shared_ptr<void> parameters = stage_->make_parameters();
    std::vector<Diagnostic> problems;
    bind_map(map(entries), stage_->parameters, context, "stage 'load'", parameters.get(), problems);
    for (const Diagnostic& problem : problems) ADD_FAILURE() << problem.message;
    return parameters;
  }
  std::string problem_of(const std::vector<std::pair<std::string, ConfigValue>>& entries) {
    const auto problems = stage_->check(bind(entries).get());
    return problems.empty() ? "" : problems[0].first + ": " + problems[0].second;
  }
  Outputs run(const void* parameters) {
    RunContext context({}, folder_.path(), "load", "mm");
    Outputs outputs = stage_->run(parameters, {}, context);
    warnings_ = context.warnings();
    report_ = context.report_items();
    return outputs;
  }
  static std::vector<std::string> ports(const Outputs& outputs) {
    std::vector<std::string> names;
    for (const auto& [port, artifact] : outputs.items()) names.push_back(port);
    std::sort(names.begin(), names.end());
    return names;
  }

  TemporaryFolder folder_;
  const StageDefinition* stage_ = find_stage("load");
  std::vector<std::string> warnings_;
  std::vector<ReportItem> report_;
};

constexpr const char* kTriangle = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

TEST_F(LoadStageTest, MakesWhatTheFileHolds) {
  folder_.write("scan.xyz", "1 2 3\n4 5 6\n");
  folder_.write("mesh.off", kTriangle);
  folder_.write("mesh.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  folder_.write("bare.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n");
  folder_.write(
      "bare.ply",
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nelement face 0\n"
      "property list uchar int vertex_indices\nend_header\n1 2 3\n");
  for (const auto& [name, has_mesh] :
       {std::pair("scan.xyz", false), std::pair("mesh.off", true), std::pair("mesh.obj", true),
        std::pair("bare.obj", false), std::pair("bare.ply", false)}) {
    const auto parameters = bind({{"path", text(name)}});
    std::vector<std::string> announced = stage_->made_outputs(parameters.get());
    std::sort(announced.begin(), announced.end());
    EXPECT_EQ(announced.size(), has_mesh ? 3u : 1u) << name;
    EXPECT_EQ(ports(run(parameters.get())), announced) << name;
    EXPECT_THAT(stage_->files(parameters.get()), ElementsAre(folder_.path() / name));
  }
  const auto ignored = bind({{"path", text("mesh.off")}, {"faces", text("ignore")}});
  EXPECT_THAT(stage_->made_outputs(ignored.get()), ElementsAre("points"));
  EXPECT_THAT(ports(run(ignored.get())), ElementsAre("points"));
}

TEST_F(LoadStageTest, RepairIsAskedForAndReported) {
  // Three pages about the edge of the vertices 0 and 1; the third turns like the first.
  folder_.write("book.off", "OFF\n5 3 0\n0 0 0\n0 0 1\n1 0 0\n0 1 0\n-0.5 0 0\n3 0 1 2\n3 1 0 3\n3 0 1 4\n");
  try {
    run(bind({{"path", text("book.off")}}).get());
    FAIL() << "an edge of three triangles was taken";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("1 non-manifold edge: vertices 0 and 1 (faces 0 1 2)"));
  }
  const auto reported = [&](const std::string& name) {
    for (const ReportItem& item : report_)
      if (item.name == name) return std::get<std::int64_t>(item.value);
    return std::int64_t{0};
  };
  for (const auto& [repair, num_triangles, num_dropped] :
       {std::tuple("split", std::size_t{3}, 0), std::tuple("drop", std::size_t{2}, 1)}) {
    const Outputs outputs = run(bind({{"path", text("book.off")}, {"repair", text(repair)}}).get());
    for (const auto& [port, artifact] : outputs.items())
      if (port == "mesh") {
        EXPECT_EQ(std::get<Shared<TriangleMesh>>(artifact)->num_triangles(), num_triangles);
      }
    EXPECT_EQ(reported("num_non_manifold_edges"), 1) << repair;
    EXPECT_EQ(reported("num_dropped_triangles"), num_dropped) << repair;
    EXPECT_THAT(warnings_, Contains(HasSubstr("the mesh was repaired: 1 non-manifold"))) << repair;
  }
}

TEST_F(LoadStageTest, FilesHavePosesAndScanners) {
  folder_.write("a.xyz", "1 0 0\n");
  folder_.write("b.xyz", "1 0 0\n");
  const auto parameters =
      bind({{"files",
             list({map({{"path", text("a.xyz")}, {"pose", numbers({0, -1, 0, 5, 1, 0, 0, 6, 0, 0, 1, 7, 0, 0, 0, 1})}}),
                   map({{"path", text("b.xyz")},
                        {"pose", numbers({0, 0, 9, 0, 0, 0, 1})},
                        {"scanner", numbers({0, 0, 1})}})})}});
  EXPECT_TRUE(stage_->check(parameters.get()).empty());
  const Outputs outputs = run(parameters.get());
  const PointCloud& points = *std::get<Shared<PointCloud>>(outputs.items().back().second);
  ASSERT_EQ(points.num_points(), 2u);
  const std::size_t a = points.scan_of_point[0] == 0 ? 0 : 1;
  EXPECT_EQ(points.positions[a] + points.origin, Eigen::Vector3d(5, 7, 7));
  EXPECT_EQ(points.positions[1 - a] + points.origin, Eigen::Vector3d(1, 0, 9));
  EXPECT_EQ(*points.scans[1].scanner_position + points.origin, Eigen::Vector3d(0, 0, 10));
}

TEST_F(LoadStageTest, AConfStandsForItsFilesAndIsOneOfThem) {
  folder_.write("maps/a.xyz", "1 0 0\n2 0 0\n");
  folder_.write("maps/all.conf", "bmesh a.xyz 0 0 1 0 0 0 1\n");
  const auto parameters = bind({{"path", text("maps/all.conf")}});
  EXPECT_THAT(stage_->files(parameters.get()),
              ElementsAre(folder_.path() / "maps/all.conf", folder_.path() / "maps/a.xyz"));
  const Outputs outputs = run(parameters.get());
  EXPECT_EQ(std::get<Shared<PointCloud>>(outputs.items().back().second)->positions[0].z(), 1);
}

TEST_F(LoadStageTest, ContradictionsAreNamed) {
  EXPECT_THAT(problem_of({}), HasSubstr("path: no file to load"));
  EXPECT_THAT(problem_of({{"path", text("a.xyz")}, {"files", list({map({{"path", text("b.xyz")}})})}}),
              HasSubstr("files: both"));
  EXPECT_THAT(problem_of({{"files", list({map({{"path", text("b.xyz")}, {"pose", numbers({1, 2})}})})}}),
              HasSubstr("a pose has 2 numbers"));
  EXPECT_THAT(problem_of({{"files", list({map({{"path", text("b.xyz")}, {"pose", numbers({0, 0, 0, 0, 0, 0, 2})}})})}}),
              HasSubstr("length 2"));
  EXPECT_THAT(
      problem_of({{"files", list({map({{"path", text("b.xyz")},
                                       {"pose", numbers({-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1})}})})}}),
      HasSubstr("mirrors"));
  EXPECT_THAT(
      problem_of({{"files", list({map({{"path", text("b.xyz")},
                                       {"pose", numbers({2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1})}})})}}),
      HasSubstr("scales"));
  EXPECT_THAT(
      problem_of({{"files", list({map({{"path", text("b.xyz")},
                                       {"pose", numbers({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1})}})})}}),
      HasSubstr("last row"));
  EXPECT_THAT(problem_of({{"files", list({map({})})}}), HasSubstr("an entry has no 'path'"));
  EXPECT_THAT(problem_of({{"path", text("a.xyz")}, {"columns", list({text("x"), text("y")})}}),
              HasSubstr("columns: the columns do not name 'z'"));
  EXPECT_THAT(
      problem_of({{"path", text("a.xyz")}, {"crop", map({{"min", numbers({0, 2, 0})}, {"max", numbers({1, 1, 1})}})}}),
      HasSubstr("empty along y"));
}

TEST_F(LoadStageTest, CoarseFloatsAreAWarning) {
  std::string shifted = "x y z\n", near = "x y z\n";
  for (int i = 0; i < 20; ++i)
    for (int j = 0; j < 20; ++j) {
      shifted += std::to_string(4500000 + i) + " " + std::to_string(j) + " 0\n";
      near += std::to_string(i) + " " + std::to_string(j) + " 0\n";
    }
  folder_.write("far.xyz", shifted);
  folder_.write("near.xyz", near);
  run(bind({{"path", text("far.xyz")}}).get());
  EXPECT_THAT(warnings_, Contains(HasSubstr("single-precision floats in steps of 0.5 mm")));
  run(bind({{"path", text("near.xyz")}}).get());
  EXPECT_TRUE(warnings_.empty());
}

TEST_F(LoadStageTest, SkippedLinesAreAWarning) {
  folder_.write("a.xyz", "1 2 3\nx\n4 5 6\n");
  run(bind({{"path", text("a.xyz")}, {"skip_bad_lines", text("true")}}).get());
  EXPECT_THAT(warnings_, Contains(HasSubstr("1 lines were not points")));
}

TEST_F(LoadStageTest, MisregisteredPassesAreAWarningFromHalfASpacing) {
  // Two passes over a plate at spacing 1, 2 points a unit together: h = 1 / sqrt(2).
  const auto write = [&](const std::string& name, double shift, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> shake(-0.3, 0.3);
    std::string rows;
    for (int i = 0; i < 60; ++i)
      for (int j = 0; j < 60; ++j)
        rows += std::to_string(i + shake(random)) + " " + std::to_string(j + shake(random)) + " " +
                std::to_string(shift + 0.05 * shake(random)) + "\n";
    folder_.write(name, rows);
  };
  const auto both = bind({{"files", list({map({{"path", text("a.xyz")}}), map({{"path", text("b.xyz")}})})}});
  for (const double spacings : {0.0, 0.4, 0.6, 1.0}) {
    write("a.xyz", 0, 1);
    write("b.xyz", spacings * std::sqrt(0.5), 2);
    run(both.get());
    const auto told = std::find_if(report_.begin(), report_.end(),
                                   [](const ReportItem& item) { return item.name == "pass_distance"; });
    ASSERT_NE(told, report_.end());
    EXPECT_NEAR(std::get<double>(told->value), spacings, 0.07);
    if (spacings < 0.5)
      EXPECT_TRUE(warnings_.empty()) << spacings;
    else
      EXPECT_THAT(warnings_, Contains(HasSubstr("overlapping scans are misregistered: a.xyz and b.xyz lie ")))
          << spacings;
  }
}

class NoHost : public CommandHost {
 public:
  std::optional<Artifact> artifact(const std::string&, const std::vector<std::string>&, std::size_t) override {
    return {};
  }
  std::shared_ptr<const void> parameters(const std::string&, const std::vector<std::string>&,
                                         const std::string&) override {
    return {};
  }
  std::vector<std::filesystem::path> run(const RunRequest&) override { return {}; }
  std::string units(const std::string&) override { return "mm"; }
  const Execution& execution() const override { return execution_; }

 private:
  Execution execution_;
};

std::string init(const std::filesystem::path& scan, const std::filesystem::path& config) {
  for (const CommandDefinition* command : all_commands())
    if (command->name == "init") {
      NoHost host;
      ::testing::internal::CaptureStdout();
      try {
        command->run({{{"SCAN", {scan.string()}}, {"--out", {config.string()}}}}, host);
      } catch (const Error&) {
        ::testing::internal::GetCapturedStdout();
        throw;
      }
      EXPECT_EQ(::testing::internal::GetCapturedStdout(), config.string() + "\n");
    }
  std::stringstream text;
  text << std::ifstream(config).rdbuf();
  return text.str();
}

TEST(Init, WritesAConfigurationThatFits) {
  TemporaryFolder folder;
  std::string points;
  for (int i = 0; i < 30; ++i)
    for (int j = 0; j < 30; ++j) points += std::to_string(i) + " " + std::to_string(j) + " 0\n";
  const std::string of_scan = init(folder.write("data/a scan.xyz", points), folder.path() / "scan.yaml");
  EXPECT_THAT(of_scan, HasSubstr("units: mm "));
  EXPECT_THAT(of_scan, HasSubstr("# 900 points, "));
  EXPECT_THAT(of_scan, HasSubstr("- load:      {path: 'data/a scan.xyz'}\n"));
  for (const char* stage : {"- orient:", "- curvature:", "- mesh:", "- tree:", "- mser:", "- borders:", "- export:"})
    EXPECT_THAT(of_scan, HasSubstr(stage));
  const std::string of_mesh = init(folder.write("mesh.off", kTriangle), folder.path() / "mesh.yaml");
  EXPECT_THAT(of_mesh, ::testing::Not(HasSubstr("- orient:")));
  EXPECT_THAT(of_mesh, HasSubstr("- curvature:"));
  EXPECT_THROW(init(folder.path() / "mesh.off", folder.path() / "mesh.yaml"), UsageError);
}

}  // namespace
}  // namespace meshmser
