/// The adapters of tree, mser and borders, one after the other, as the pipeline calls them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/stage/stage.hpp"
#include "tests/support/border_checker.hpp"

namespace meshmser {
namespace {

using ::testing::HasSubstr;
using Settings = std::vector<std::pair<std::string, ConfigValue>>;

ConfigValue scalar(const std::string& text) {
  ConfigValue value;
  value.kind = ConfigValue::Kind::kScalar;
  value.text = text;
  return value;
}

/// The outputs of a stage with some parameters set as a configuration would.
Outputs run(const std::string& name, const Settings& settings, const Inputs& inputs, RunContext& context) {
  const StageDefinition* stage = find_stage(name);
  if (stage == nullptr) throw std::logic_error("no stage " + name);
  const std::shared_ptr<void> parameters = stage->make_parameters();
  for (const auto& [key, value] : settings)
    for (const Parameter& parameter : stage->parameters)
      if (parameter.name == key) {
        std::vector<Diagnostic> problems;
        parameter.bind(value, {}, parameters.get(), problems);
        for (const Diagnostic& problem : problems) ADD_FAILURE() << key << ": " << problem.message;
      }
  return stage->run(parameters.get(), inputs, context);
}

template <class T>
Shared<T> output(const Outputs& outputs) {
  return std::get<Shared<T>>(outputs.items().at(0).second);
}

/// A 40 x 40 sheet with a smooth hill in one half and a smooth pit in the other.
TriangleMesh hill_and_pit() {
  TriangleMesh mesh;
  mesh.spacing = 1;
  Property quality{"quality", ValueType::kFloat64, {}};
  for (std::int32_t y = 0; y <= 40; ++y)
    for (std::int32_t x = 0; x <= 40; ++x) {
      mesh.positions.emplace_back(x, y, 0);
      quality.values.push_back(std::tanh(5 - std::hypot(x - 11, y - 20)) - std::tanh(5 - std::hypot(x - 29, y - 20)));
    }
  for (std::int32_t y = 0; y < 40; ++y)
    for (std::int32_t x = 0; x < 40; ++x) {
      const std::int32_t a = y * 41 + x;
      mesh.triangles.push_back({a, a + 1, a + 42});
      mesh.triangles.push_back({a, a + 42, a + 41});
    }
  mesh.properties.push_back(quality);
  return mesh;
}

class TreeMserBorders : public ::testing::Test {
 protected:
  void run_all(const Settings& tree_settings, const Settings& borders_settings) {
    inputs_.add({"mesh", "load", Artifact(std::make_shared<const TriangleMesh>(mesh_))});
    trees_ = output<LevelSetTrees>(run("tree", tree_settings, inputs_, context_));
    inputs_.add({"trees", "tree", Artifact(trees_)});
    segmentation_ = output<Segmentation>(run("mser", {}, inputs_, context_));
    inputs_.add({"segmentation", "mser", Artifact(segmentation_)});
    borders_ = output<BorderSet>(run("borders", borders_settings, inputs_, context_));
  }

  /// "" or what the border checker says of a region's loops.
  std::string what_is_wrong_with_borders(const ComponentTree& tree, std::size_t region) const {
    const std::int32_t top = segmentation_->regions[region].node;
    std::vector<std::uint8_t> inside;
    for (const std::int32_t node : tree.node_of_triangle)
      inside.push_back(node <= top && node >= tree.first_node_of_subtree[static_cast<std::size_t>(top)]);
    return testing::check_border_loops(mesh_.positions, mesh_.triangles, trees_->excluded_of_triangle, inside,
                                       borders_->regions, static_cast<std::int32_t>(region) + 1);
  }

  TriangleMesh mesh_ = hill_and_pit();
  Inputs inputs_;
  RunContext context_{Execution{}, "", "test", "mm"};
  Shared<LevelSetTrees> trees_;
  Shared<Segmentation> segmentation_;
  Shared<BorderSet> borders_;
};

TEST_F(TreeMserBorders, HillAndPitAreEnclosed) {
  run_all({{"scalar", scalar("quality")}}, {{"interpolate", scalar("true")}, {"smooth", scalar("0.2 spacing")}});
  ASSERT_GE(segmentation_->regions.size(), 2u);
  bool upper = false, lower = false;
  for (std::size_t r = 0; r < segmentation_->regions.size(); ++r) {
    const Region& region = segmentation_->regions[r];
    (region.polarity == Polarity::kUpper ? upper : lower) = true;
    const ComponentTree& tree = trees_->trees[region.polarity == Polarity::kUpper ? 0 : 1];
    EXPECT_EQ(what_is_wrong_with_borders(tree, r), "");
  }
  EXPECT_TRUE(upper);
  EXPECT_TRUE(lower);
  EXPECT_GE(borders_->labels.num_loops(), 2u);
  EXPECT_EQ(borders_->interpolated.first_point_of_curve.size(), borders_->regions.num_loops() + 1);
  EXPECT_EQ(borders_->smooth.points.size(), borders_->interpolated.points.size());
  EXPECT_DOUBLE_EQ(borders_->smooth_tolerance, 0.2);
}

TEST_F(TreeMserBorders, CurvesAreMadeOnlyWhereAskedFor) {
  run_all({{"scalar", scalar("quality")}, {"polarity", scalar("upper")}}, {});
  EXPECT_EQ(trees_->trees.size(), 1u);
  for (const Region& region : segmentation_->regions) EXPECT_EQ(region.polarity, Polarity::kUpper);
  EXPECT_GE(borders_->regions.num_loops(), 1u);
  EXPECT_TRUE(borders_->interpolated.points.empty());
  EXPECT_TRUE(borders_->smooth.points.empty());
}

TEST_F(TreeMserBorders, ShapesAreEnclosedFromEitherSide) {
  run_all({{"scalar", scalar("quality")}, {"polarity", scalar("shapes")}}, {{"interpolate", scalar("true")}});
  ASSERT_EQ(trees_->trees.size(), 1u);
  const ComponentTree& tree = trees_->trees[0];
  bool upper = false, lower = false;
  for (std::size_t r = 0; r < segmentation_->regions.size(); ++r) {
    const Region& region = segmentation_->regions[r];
    (region.polarity == Polarity::kUpper ? upper : lower) = true;
    EXPECT_EQ(region.polarity, tree.side(region.node));
    EXPECT_EQ(region.value, tree.value(region.node));
    EXPECT_EQ(region.polarity == Polarity::kUpper, region.contrast > 0);
    if (region.polarity == Polarity::kUpper) {
      EXPECT_GE(region.scalar_min, region.value);
    } else {
      EXPECT_LT(region.scalar_max, region.value);
    }
    EXPECT_EQ(what_is_wrong_with_borders(tree, r), "");
  }
  EXPECT_TRUE(upper);
  EXPECT_TRUE(lower);
  EXPECT_EQ(borders_->interpolated.first_point_of_curve.size(), borders_->regions.num_loops() + 1);
}

TEST_F(TreeMserBorders, EverySelectionOfShapesWorksOrIsRefused) {
  Inputs inputs;
  inputs.add({"mesh", "load", Artifact(std::make_shared<const TriangleMesh>(mesh_))});
  const Settings shapes = {{"scalar", scalar("quality")}, {"polarity", scalar("shapes")}};
  inputs.add({"trees", "tree", Artifact(output<LevelSetTrees>(run("tree", shapes, inputs, context_)))});
  const auto refused = [&](const Settings& settings) -> std::string {
    try {
      run("mser", settings, inputs, context_);
    } catch (const StageError& error) {
      return error.what();
    }
    return "";
  };
  const auto num_regions = [&](const Settings& settings) {
    return output<Segmentation>(run("mser", settings, inputs, context_))->regions.size();
  };
  for (const char* select : {"persistence", "stable_branch"})
    EXPECT_EQ(num_regions({{"select", scalar(select)}, {"min_persistence", scalar("0.3")}}), 2u) << "hill and pit";
  EXPECT_EQ(refused({{"delta_value", scalar("0.1")}}),
            "mser.delta_value: a tree of shapes counts level lines, whatever their step; give mser.delta, a number of "
            "them");
  EXPECT_EQ(num_regions({{"select", scalar("mser")}}), 2u);
  // The hill above the level and the pit below it; all around the pit reaches the rim.
  EXPECT_EQ(num_regions({{"select", scalar("level")}, {"level", scalar("0.5")}}), 1u);
  EXPECT_EQ(num_regions({{"select", scalar("level")}, {"level", scalar("-0.5")}}), 1u);
  EXPECT_GE(num_regions({{"select", scalar("length")}, {"min_length", scalar("30 spacing")}}), 2u);
  EXPECT_EQ(num_regions({{"select", scalar("meaningful")}, {"independent", scalar("4 spacing")}}), 2u);
  for (const char* grow : {"none", "absorb", "watershed", "level"})
    EXPECT_EQ(num_regions({{"grow", scalar(grow)}}), 2u) << grow;
  EXPECT_EQ(num_regions({{"min_contrast", scalar("1")}}), 2u);
  EXPECT_EQ(num_regions({{"min_persistence", scalar("1.5")}}), 2u);
  EXPECT_EQ(num_regions({{"min_persistence", scalar("2.1")}}), 0u);
}

TEST_F(TreeMserBorders, AllExcludedIsWarnedOfAndGivesNothing) {
  run_all({{"scalar", scalar("quality")}, {"exclude_rim", scalar("100 spacing")}}, {});
  EXPECT_TRUE(segmentation_->regions.empty());
  EXPECT_EQ(borders_->regions.num_loops(), 0u);
  ASSERT_FALSE(context_.warnings().empty());
  EXPECT_THAT(context_.warnings()[0], HasSubstr("every triangle is left out"));
}

TEST_F(TreeMserBorders, UnknownScalarNamesWhatThereIs) {
  try {
    run_all({{"scalar", scalar("qualiti")}}, {});
    FAIL();
  } catch (const StageError& error) {
    EXPECT_STREQ(error.what(), "there is no scalar 'qualiti'; there is only quality");
  }
}

ConfigValue list(const std::vector<std::string>& items) {
  ConfigValue value;
  value.kind = ConfigValue::Kind::kList;
  for (const std::string& item : items) value.items.push_back(scalar(item));
  return value;
}

// Every way to lay levels that a configuration can ask for.
TEST_F(TreeMserBorders, LevelsAreLaidAsAskedFor) {
  const auto levels_with = [&](Settings settings) {
    settings.emplace_back("scalar", scalar("quality"));
    Inputs inputs;
    inputs.add({"mesh", "load", Artifact(std::make_shared<const TriangleMesh>(mesh_))});
    const auto trees = output<LevelSetTrees>(run("tree", settings, inputs, context_));
    EXPECT_EQ(trees->trees.size(), 2u);
    return trees->trees.at(0).levels;
  };
  const auto near = [](const std::vector<double>& expected) {
    return ::testing::Pointwise(::testing::DoubleNear(1e-9), expected);
  };
  const double below_all = -std::numeric_limits<double>::infinity();
  std::vector<double> values = mesh_.properties[0].values;
  std::sort(values.begin(), values.end());
  const auto quantile = [&](double share) {
    const double place = share * static_cast<double>(values.size() - 1);
    const auto low = static_cast<std::size_t>(place);
    return std::lerp(values[low], values[std::min(low + 1, values.size() - 1)], place - static_cast<double>(low));
  };

  const std::vector<double> by_count = levels_with({{"levels", scalar("5")}});
  const double low = quantile(0.02), high = quantile(0.98);
  EXPECT_THAT(by_count, near({below_all, low + (high - low) / 4, (low + high) / 2, high - (high - low) / 4, high}));
  EXPECT_THAT(levels_with({{"levels", scalar("3")}, {"range", list({"10 %", "90 %"})}}),
              near({below_all, (quantile(0.1) + quantile(0.9)) / 2, quantile(0.9)}));
  EXPECT_THAT(levels_with({{"levels", scalar("3")}, {"value_range", list({"-1", "0.5"})}}),
              near({below_all, -0.25, 0.5}));
  EXPECT_THAT(
      levels_with(
          {{"level_rule", scalar("step")}, {"level_step", scalar("0.5")}, {"value_range", list({"-1", "0.2"})}}),
      near({below_all, -1, -0.5, 0}));
  EXPECT_THAT(levels_with({{"level_rule", scalar("list")}, {"level_list", list({"0.5", "-0.5", "1"})}}),
              near({-0.5, 0.5, 1}));
  EXPECT_THAT(
      levels_with(
          {{"level_rule", scalar("list")}, {"level_list", list({"-0.5", "0.5"})}, {"delta_value", scalar("0.25")}}),
      near({-0.75, -0.5, -0.25, 0.25, 0.5, 0.75}));
  EXPECT_EQ(levels_with({{"level_rule", scalar("noise")}, {"levels", scalar("32")}, {"noise", scalar("0.01")}}).size(),
            32u);

  values.erase(std::unique(values.begin(), values.end()), values.end());
  const std::vector<double> every_value = levels_with({{"level_rule", scalar("every_value")}});
  EXPECT_EQ(every_value, values);

  // Equal shares of area: every vertex inside stands for one square, those at the rim for less.
  const std::vector<double> by_area =
      levels_with({{"level_rule", scalar("equal_area")}, {"levels", scalar("5")}, {"range", list({"0 %", "100 %"})}});
  ASSERT_EQ(by_area.size(), 5u);
  const auto area_at_least = [&](double level) {
    double area = 0;
    for (std::size_t v = 0; v < mesh_.num_vertices(); ++v) {
      const auto side = [](double x) { return x == 0 || x == 40 ? 0.5 : 1; };
      if (mesh_.properties[0].values[v] >= level) area += side(mesh_.positions[v].x()) * side(mesh_.positions[v].y());
    }
    return area;
  };
  for (int k = 1; k <= 3; ++k) EXPECT_NEAR(area_at_least(by_area[static_cast<std::size_t>(k)]), 400 * (4 - k), 60) << k;
}

// Delta in units of the scalar through both stages: with equal steps it is the delta of as many steps.
TEST_F(TreeMserBorders, DeltaInUnitsOfTheScalarIsDeltaInSteps) {
  const auto segmentation_with = [&](const Settings& tree_settings, const Settings& mser_settings) {
    Inputs inputs;
    inputs.add({"mesh", "load", Artifact(std::make_shared<const TriangleMesh>(mesh_))});
    inputs.add({"trees", "tree", Artifact(output<LevelSetTrees>(run("tree", tree_settings, inputs, context_)))});
    return output<Segmentation>(run("mser", mser_settings, inputs, context_));
  };
  const Settings eighths = {{"scalar", scalar("quality")},
                            {"level_rule", scalar("list")},
                            {"level_list", list({"-0.75", "-0.5", "-0.25", "0", "0.25", "0.5", "0.75"})}};
  const Settings fine = {{"min_area", scalar("0 spacing2")}, {"min_diversity", scalar("0")}};
  Settings steps = fine, value = fine;
  steps.emplace_back("delta", scalar("2"));
  value.emplace_back("delta_value", scalar("0.5"));
  const auto by_steps = segmentation_with(eighths, steps), by_value = segmentation_with(eighths, value);
  ASSERT_GE(by_steps->regions.size(), 2u);
  ASSERT_EQ(by_steps->regions.size(), by_value->regions.size());
  for (std::size_t r = 0; r < by_steps->regions.size(); ++r) {
    EXPECT_EQ(by_steps->regions[r].node, by_value->regions[r].node);
    EXPECT_EQ(by_steps->regions[r].stability, by_value->regions[r].stability);
  }
  EXPECT_EQ(by_steps->region_of_triangle, by_value->region_of_triangle);

  // Two levels alone tell nothing of the change around them; the levels that delta inserts do.
  Settings two = {{"scalar", scalar("quality")}, {"level_rule", scalar("list")}, {"level_list", list({"-0.5", "0.5"})}};
  two.emplace_back("delta_value", scalar("0.25"));
  value.back().second = scalar("0.25");
  const auto inserted = segmentation_with(two, value);
  ASSERT_GE(inserted->regions.size(), 2u);
  for (const Region& region : inserted->regions) {
    EXPECT_GT(region.stability, 0);
    EXPECT_LT(region.stability, 2);
  }
}

TEST(TreeStage, ParametersThatContradictAreNamed) {
  const StageDefinition* tree = find_stage("tree");
  ASSERT_NE(tree, nullptr);
  auto problems_with = [&](const Settings& settings) {
    const std::shared_ptr<void> parameters = tree->make_parameters();
    std::vector<Diagnostic> problems;
    for (const auto& [key, value] : settings)
      for (const Parameter& parameter : tree->parameters)
        if (parameter.name == key) parameter.bind(value, {}, parameters.get(), problems);
    EXPECT_TRUE(problems.empty());
    std::string text;
    for (const auto& [parameter, message] : tree->check(parameters.get())) text += parameter + ": " + message + "\n";
    return text;
  };
  EXPECT_EQ(problems_with({}), "");
  EXPECT_EQ(problems_with({{"level_rule", scalar("step")}}), "level_rule: the rule step needs level_step\n");
  EXPECT_EQ(problems_with({{"level_rule", scalar("list")}}), "level_rule: the rule list needs level_list\n");
  ConfigValue range;
  range.kind = ConfigValue::Kind::kList;
  range.items = {scalar("98 %"), scalar("2 %")};
  EXPECT_EQ(problems_with({{"range", range}}), "range: the first quantile must be less than the second\n");
  range.items = {scalar("3"), scalar("-1")};
  EXPECT_EQ(problems_with({{"value_range", range}}), "value_range: the first value must be less than the second\n");
  range.items = {scalar("1"), scalar("2"), scalar("3")};
  EXPECT_EQ(problems_with({{"root", range}}),
            "root: only polarity: shapes has a root to choose; leave root out, or take shapes\n");
  EXPECT_EQ(problems_with({{"root", range}, {"polarity", scalar("shapes")}}), "");
}

}  // namespace
}  // namespace meshmser
