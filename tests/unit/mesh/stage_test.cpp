/// The mesh stage as the pipeline calls it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "pipeline/stage/stage.hpp"
#include "tests/unit/mesh/scattered_shapes.hpp"

namespace meshmser {
namespace {

using Settings = std::vector<std::pair<std::string, std::string>>;

struct StageRun {
  Shared<TriangleMesh> mesh;
  std::vector<std::string> warnings;
  std::vector<ReportItem> report;

  std::int64_t count(const std::string& name) const {
    const auto found = std::find_if(report.begin(), report.end(), [&](const auto& item) { return item.name == name; });
    if (found == report.end()) throw std::logic_error("no report " + name);
    return std::get<std::int64_t>(found->value);
  }
};

StageRun run_stage(const ScatteredShape& shape, const Settings& settings = {},
                   const SmoothedPoints* smoothed = nullptr) {
  const StageDefinition* stage = find_stage("mesh");
  if (stage == nullptr) throw std::logic_error("the mesh stage is not registered");
  const std::shared_ptr<void> parameters = stage->make_parameters();
  for (const auto& [key, text] : settings) {
    ConfigValue value;
    value.kind = ConfigValue::Kind::kScalar;
    value.text = text;
    bool known = false;
    for (const Parameter& parameter : stage->parameters) {
      if (parameter.name != key) continue;
      known = true;
      std::vector<Diagnostic> problems;
      parameter.bind(value, {"mm", ""}, parameters.get(), problems);
      for (const Diagnostic& problem : problems) ADD_FAILURE() << key << ": " << problem.message;
    }
    if (!known) ADD_FAILURE() << "no parameter " << key;
  }
  Inputs inputs;
  inputs.add({"points", "load", Artifact(std::make_shared<const PointCloud>(shape.cloud))});
  inputs.add({"normals", "orient", Artifact(std::make_shared<const PointNormals>(shape.normals))});
  if (smoothed != nullptr)
    inputs.add({"smoothed", "curvature", Artifact(std::make_shared<const SmoothedPoints>(*smoothed))});
  RunContext context(Execution{}, "", "mesh", "mm");
  const Outputs outputs = stage->run(parameters.get(), inputs, context);
  return {std::get<Shared<TriangleMesh>>(outputs.items().at(0).second), context.warnings(), context.report_items()};
}

TEST(MeshStage, MakesASoundMeshByEitherMethod) {
  const ScatteredShape shape = scattered_sphere(10);
  for (const char* method : {"local_delaunay", "advancing_front"}) {
    SCOPED_TRACE(method);
    const StageRun run = run_stage(shape, {{"method", method}});
    EXPECT_EQ(run.count("euler_number"), 2);
    EXPECT_EQ(run.count("num_border_loops"), 0);
    EXPECT_EQ(run.count("num_triangles"), static_cast<std::int64_t>(run.mesh->num_triangles()));
    EXPECT_THAT(run.warnings, testing::IsEmpty());
    EXPECT_EQ(run.mesh->spacing, 1);
  }
}

TEST(MeshStage, LengthsMayBeInSpacingsOrInTheCoordinatesUnit) {
  ScatteredShape shape = scattered_plane(30, 0.3, [](double x, double y) { return std::hypot(x - 15, y - 15) > 4; });
  EXPECT_EQ(run_stage(shape).count("num_border_loops"), 2);
  EXPECT_EQ(run_stage(shape, {{"max_edge", "12 spacing"}, {"close_loops", "0"}}).count("num_border_loops"), 1);
  for (Eigen::Vector3d& p : shape.cloud.positions) p *= 0.1;
  shape.cloud.spacing = 0.1;
  EXPECT_EQ(run_stage(shape, {{"max_edge", "0.5 mm"}}).count("num_border_loops"), 2);
  EXPECT_EQ(run_stage(shape, {{"max_edge", "1.2 mm"}, {"close_loops", "0"}}).count("num_border_loops"), 1);
}

TEST(MeshStage, TellsWhatIsDoubtful) {
  // An open sheet whose sides are a guess: the orient stage has warned of that.
  ScatteredShape sheet = scattered_plane(30, 0.3);
  sheet.finish(SignSource::kGuess);
  const StageRun guessed = run_stage(sheet);
  EXPECT_THAT(guessed.warnings, testing::IsEmpty());
  EXPECT_EQ(guessed.count("num_components_by_guess"), 1);
  EXPECT_EQ(guessed.count("num_vertices_by_guess"), guessed.count("num_vertices"));

  // A patch of turned normals.
  ScatteredShape patched = scattered_sphere(10);
  for (std::size_t p = 0; p < patched.cloud.num_points(); ++p)
    if (patched.cloud.positions[p].x() > 9) patched.normals.normals[p] *= -1;
  const StageRun turned = run_stage(patched, {{"method", "advancing_front"}});
  EXPECT_THAT(turned.warnings, testing::ElementsAre(testing::HasSubstr("the mesh turns the normals of")));
  EXPECT_EQ(turned.count("num_turned_vertices"),
            std::count(turned.mesh->turned_of_vertex.begin(), turned.mesh->turned_of_vertex.end(), 1));

  // Points far from all others.
  ScatteredShape lonely = scattered_plane(30, 0.3);
  for (int i = 0; i < 20; ++i) lonely.add({20.0 * i, 0, 100}, {0, 0, 1});
  EXPECT_THAT(run_stage(lonely).warnings,
              testing::ElementsAre(testing::HasSubstr("20 points (2.17 %) are in no triangle")));

  // Raw points apart that smoothing brought together.
  ScatteredShape passes = scattered_plane(30, 0.3);
  SmoothedPoints smoothed;
  smoothed.positions = passes.cloud.positions;
  for (std::size_t p = 0; p < passes.cloud.num_points(); p += 40) passes.cloud.positions[p].z() += 7;
  EXPECT_THAT(run_stage(passes, {}, &smoothed).warnings,
              testing::Contains(testing::HasSubstr("passes may be misregistered")));
}

}  // namespace
}  // namespace meshmser
