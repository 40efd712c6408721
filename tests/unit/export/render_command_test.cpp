#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>

#include "pipeline/stage/command.hpp"
#include "stages/export/image.hpp"

namespace meshmser {
namespace {

/// A configuration that makes what the test put here.
class FakeHost : public CommandHost {
 public:
  std::vector<Artifact> artifacts;
  std::vector<std::string> seen_set;
  std::optional<Artifact> artifact(const std::string&, const std::vector<std::string>& set, std::size_t type) override {
    seen_set = set;
    for (const Artifact& one : artifacts)
      if (one.index() == type) return one;
    return std::nullopt;
  }
  std::shared_ptr<const void> parameters(const std::string&, const std::vector<std::string>&,
                                         const std::string&) override {
    return nullptr;
  }
  std::vector<std::filesystem::path> run(const RunRequest&) override { return {}; }
  std::string units(const std::string&) override { return "mm"; }
  const Execution& execution() const override { return execution_; }

 private:
  Execution execution_;
};

class RenderCommand : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) /
              (std::string("render_command_") + testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
    mesh_.positions = {{0, 0, 0}, {10, 0, 0}, {10, 10, 0}, {0, 10, 0}};
    mesh_.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh_.point_of_vertex = {3, 2, 1, 0};
    mesh_.turned_of_vertex = {0, 0, 0, 0};
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  const CommandDefinition& command() {
    for (const CommandDefinition* one : all_commands())
      if (one->name == "render") return *one;
    throw std::logic_error("no command is called render");
  }
  /// The picture of a configuration that makes `host`'s artifacts.
  Image draw(const std::string& show, std::vector<std::pair<std::string, std::vector<std::string>>> more = {}) {
    CommandArguments arguments;
    arguments.values = std::move(more);
    arguments.values.push_back({"MESH", {"scan.yaml"}});
    arguments.values.push_back({"OUT.png", {picture().string()}});
    if (!show.empty()) arguments.values.push_back({"--show", {show}});
    testing::internal::CaptureStdout();
    EXPECT_EQ(command().run(arguments, host_), 0);
    EXPECT_EQ(testing::internal::GetCapturedStdout(), picture().string() + "\n");
    return read_png(picture());
  }
  std::string message(const std::string& show,
                      std::vector<std::pair<std::string, std::vector<std::string>>> more = {}) {
    try {
      draw(show, std::move(more));
    } catch (const Error& error) {
      testing::internal::GetCapturedStdout();
      return error.what();
    }
    return "no error";
  }
  template <class T>
  void make(T value) {
    host_.artifacts.emplace_back(std::make_shared<const T>(std::move(value)));
  }
  std::filesystem::path picture() const { return folder_ / "out.png"; }

  std::filesystem::path folder_;
  TriangleMesh mesh_;
  FakeHost host_;
};

TEST_F(RenderCommand, ShowsTheLabelsWhereThereAreSomeElseTheScalar) {
  make(mesh_);
  const Image shape = draw("");
  ScalarFields fields;
  fields.fields.push_back({"mean_curvature", "1/mm", Parity::kOdd, 0.1, {-1, -0.5, 0.5, 1}});
  make(fields);
  const Image curvature = draw("");
  EXPECT_NE(curvature.rgb, shape.rgb);
  EXPECT_EQ(draw("mean_curvature").rgb, curvature.rgb);
  LevelSetTrees trees;
  trees.scalar = "crease";
  trees.values = {1, 2, 3, 4};
  make(trees);
  const Image crease = draw("");
  EXPECT_NE(crease.rgb, curvature.rgb);
  Segmentation segmentation;
  segmentation.label_of_triangle = {1, 2};
  segmentation.region_of_triangle = {0, 1};
  make(segmentation);
  const Image labels = draw("");
  EXPECT_NE(labels.rgb, crease.rgb);
  EXPECT_EQ(draw("labels").rgb, labels.rgb);
  EXPECT_NE(draw("regions").rgb, labels.rgb);
  EXPECT_EQ(draw("scalar").rgb, crease.rgb);
  EXPECT_EQ(draw("shape").rgb, shape.rgb);
}

TEST_F(RenderCommand, OddScalarsTurnWithTheNormal) {
  ScalarFields fields;
  fields.fields.push_back({"mean_curvature", "1/mm", Parity::kOdd, 0.1, {-1, -0.5, 0.5, 1}});
  ScalarFields turned;
  turned.fields.push_back({"mean_curvature", "1/mm", Parity::kOdd, 0.1, {1, 0.5, -0.5, -1}});
  make(mesh_);
  make(fields);
  const Image right = draw("mean_curvature");
  host_.artifacts.clear();
  mesh_.turned_of_vertex = {1, 1, 1, 1};
  make(mesh_);
  make(turned);
  EXPECT_EQ(draw("mean_curvature").rgb, right.rgb);
}

TEST_F(RenderCommand, OptionsReachThePictureAndTheConfiguration) {
  make(mesh_);
  const Image image =
      draw("shape", {{"--view", {"top", "front", "iso"}}, {"--size", {"300x250"}}, {"--set", {"mesh.max_edge=3"}}});
  EXPECT_EQ(image.width, 600);
  EXPECT_EQ(image.height, 40 + 500 + 56);
  EXPECT_EQ(host_.seen_set, std::vector<std::string>{"mesh.max_edge=3"});
  EXPECT_NE(draw("shape", {{"--view", {"top"}}, {"--light-elevation", {"80"}}}).rgb,
            draw("shape", {{"--view", {"top"}}, {"--light-elevation", {"5"}}}).rgb);
}

TEST_F(RenderCommand, DrawsAMeshFileByItsProperties) {
  std::ofstream(folder_ / "m.ply")
      << "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
         "property float quality\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
         "0 0 0 -1\n9 0 0 0\n9 9 0 1\n0 9 0 0\n4 0 1 2 3\n";
  CommandArguments arguments;
  arguments.values = {{"MESH", {(folder_ / "m.ply").string()}}, {"OUT.png", {picture().string()}}};
  testing::internal::CaptureStdout();
  EXPECT_EQ(command().run(arguments, host_), 0);
  const Image shape = read_png(picture());
  arguments.values.push_back({"--show", {"quality"}});
  EXPECT_EQ(command().run(arguments, host_), 0);
  EXPECT_NE(read_png(picture()).rgb, shape.rgb);
  testing::internal::GetCapturedStdout();
  arguments.values.back() = {"--show", {"height"}};
  try {
    command().run(arguments, host_);
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find("has no vertex property 'height'; --show knows: shape, quality"),
              std::string::npos);
  }
}

TEST_F(RenderCommand, ErrorsSayWhatToDo) {
  EXPECT_EQ(message(""), "render: no stage of scan.yaml makes a mesh; add the stage 'mesh', or load a file with faces");
  make(mesh_);
  EXPECT_EQ(message("labels"), "render: no stage of scan.yaml makes labels; add the stages 'tree' and 'mser'");
  EXPECT_EQ(message("scalar"), "render: no stage of scan.yaml makes a tree; add it, or name a scalar with --show");
  EXPECT_EQ(message("height"), "render: scan.yaml makes no 'height'; --show knows: labels, regions, scalar, shape");
  EXPECT_EQ(message("shape", {{"--size", {"big"}}}),
            "render: --size big: expected WIDTHxHEIGHT in pixels, at most 8192 each, as in 1200x900");
  EXPECT_EQ(message("shape", {{"--view", {"top", "up"}}}).find("render: unknown view 'up'; known: front"), 0u);
  EXPECT_EQ(message("shape", {{"--light", {"left"}}}), "render: --light left: expected a number");
}

}  // namespace
}  // namespace meshmser
