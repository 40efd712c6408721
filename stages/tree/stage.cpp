#include "pipeline/stage/stage.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "stages/tree/level_set_trees.hpp"

namespace meshmser {

template <>
struct EnumNames<ScalarTransform> {
  static constexpr std::pair<ScalarTransform, const char*> values[] = {{ScalarTransform::kIdentity, "identity"},
                                                                       {ScalarTransform::kNegate, "negate"},
                                                                       {ScalarTransform::kAbs, "abs"},
                                                                       {ScalarTransform::kNegateAbs, "negate_abs"}};
};
template <>
struct EnumNames<NanPolicy> {
  static constexpr std::pair<NanPolicy, const char*> values[] = {
      {NanPolicy::kAuto, "auto"}, {NanPolicy::kError, "error"}, {NanPolicy::kExclude, "exclude"}};
};
template <>
struct EnumNames<LevelRule> {
  static constexpr std::pair<LevelRule, const char*> values[] = {{LevelRule::kLinear, "linear"},
                                                                 {LevelRule::kStep, "step"},
                                                                 {LevelRule::kList, "list"},
                                                                 {LevelRule::kEqualArea, "equal_area"},
                                                                 {LevelRule::kEveryValue, "every_value"},
                                                                 {LevelRule::kNoise, "noise"}};
};
template <>
struct EnumNames<PolarityChoice> {
  static constexpr std::pair<PolarityChoice, const char*> values[] = {{PolarityChoice::kUpper, "upper"},
                                                                      {PolarityChoice::kLower, "lower"},
                                                                      {PolarityChoice::kBoth, "both"},
                                                                      {PolarityChoice::kShapes, "shapes"}};
};

namespace {

struct TreeParameters {
  std::string scalar = "mean_curvature";
  ScalarTransform transform = ScalarTransform::kIdentity;
  std::optional<AutoOr<Length>> detrend;
  std::optional<double> detrend_clip;
  std::optional<AutoOr<Length>> exclude_rim;
  std::optional<AutoOr<Length>> fallen_rim;
  Length min_rim = spacings(40);
  NanPolicy nan = NanPolicy::kAuto;
  std::int32_t levels = 64;
  LevelRule level_rule = LevelRule::kLinear;
  std::array<Share, 2> range{Share{0.02}, Share{0.98}};
  std::optional<std::array<Share, 2>> strength_range;
  std::optional<std::array<double, 2>> value_range;
  std::optional<double> level_step;
  std::vector<double> level_list;
  double level_constant = 4;
  std::optional<double> noise;
  double delta_value = 0;
  PolarityChoice polarity = PolarityChoice::kBoth;
  std::optional<std::array<double, 3>> root;
};

Scale scale_of(const TriangleMesh& mesh) {
  Scale scale;
  scale.spacing = mesh.spacing;
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& position : mesh.positions) box.extend(position);
  if (!box.isEmpty()) scale.diagonal = box.diagonal().norm();
  return scale;
}

// Of the curvature's radius, which is three eighths of a line's width: twice the width, and three quarters of it.
constexpr double kDetrendRadii = 16.0 / 3, kRimRadii = 2;

/// A length outright, or so many radii of the scalar.
double resolve(const AutoOr<Length>& given, const char* name, double radii, const VertexScalar& scalar,
               const Scale& scale) {
  if (!given.automatic) return given.value.resolve(scale);
  if (!(scalar.radius > 0))
    throw StageError(std::string("tree.") + name +
                     ": auto is a multiple of the radius of a curvature stage, but the scalar '" + scalar.name +
                     "' comes from none; give a length");
  return radii * scalar.radius;
}

LevelSetTreesParameters resolve(const TreeParameters& given, const VertexScalar& scalar, const Scale& scale) {
  LevelSetTreesParameters p;
  p.transform = given.transform;
  if (given.detrend) p.detrend = resolve(*given.detrend, "detrend", kDetrendRadii, scalar, scale);
  p.detrend_clip = given.detrend_clip.value_or(0);
  if (given.exclude_rim) p.exclude_rim = resolve(*given.exclude_rim, "exclude_rim", kRimRadii, scalar, scale);
  p.fallen_rim = given.fallen_rim.has_value();
  if (given.fallen_rim && !given.fallen_rim->automatic) p.fallen_depth = given.fallen_rim->value.resolve(scale);
  p.min_rim = given.min_rim.resolve(scale);
  p.nan = given.nan;
  p.levels.rule = given.level_rule;
  p.levels.count = given.levels;
  p.levels.low_quantile = given.range[0].value;
  p.levels.high_quantile = given.range[1].value;
  if (given.value_range) {
    p.levels.low_value = (*given.value_range)[0];
    p.levels.high_value = (*given.value_range)[1];
  }
  if (given.strength_range) {
    p.levels.low_strength = (*given.strength_range)[0].value;
    p.levels.high_strength = (*given.strength_range)[1].value;
  }
  p.levels.step = given.level_step.value_or(0);
  p.levels.list = given.level_list;
  p.levels.noise_constant = given.level_constant;
  if (given.noise) p.levels.noise = *given.noise;
  p.levels.delta_value = given.delta_value;
  p.polarity = given.polarity;
  return p;
}

}  // namespace

struct TreeStage {
  static constexpr StageInfo info{"tree", 4,
                                  "Builds the tree of the level sets of a scalar on the mesh [Digne et al. 2010]."};
  using Parameters = TreeParameters;

  static void declare(StageSchema& s) {
    using P = Parameters;
    s.input<TriangleMesh>("mesh");
    s.input<ScalarFields>("scalars", Need::kAll);
    s.input<PointCloud>("cloud", Need::kOptional);
    s.output<LevelSetTrees>("trees");
    s.parameter("scalar", &P::scalar,
                "What is levelled: a scalar of a curvature stage (mean_curvature, crease, height, or fine.crease of a "
                "stage named fine), or a property of the mesh or of the points.");
    s.parameter("transform", &P::transform, "Applied to the scalar after detrending.");
    s.parameter(
        "detrend", &P::detrend, more_than(0), "",
        "Radius of the ball whose mean is subtracted from the scalar first; auto: 16/3 of the curvature's radius.");
    s.parameter("detrend_clip", &P::detrend_clip, more_than(0), "",
                "Values that differ from the mean around by more than so many median deviations are clipped for it, so "
                "that neither lines nor a sharp edge tilt it: it is then the level of the ground.");
    s.parameter(
        "exclude_rim", &P::exclude_rim, more_than(0), "",
        "Triangles nearer than this to a long rim are left out, since curvature is biased there; auto: twice the "
        "curvature's radius.");
    s.parameter("fallen_rim", &P::fallen_rim, more_than(0), "",
                "What lies deeper than this below the surface inside, and is joined to a long rim, counts as rim: a "
                "broken edge, a plate's side; auto: deeper than relief inside reaches.");
    s.parameter("min_rim", &P::min_rim, at_least(0), "", "Rims up to this length leave nothing out.");
    s.parameter("nan", &P::nan,
                "What a value that is not finite does: an error, or its triangles are left out; auto: left out where "
                "a stage measured the scalar, an error where a file gave it.");
    s.parameter("levels", &P::levels, range(2, 1e6), "levels", "How many, the lowest at minus infinity.");
    s.parameter("level_rule", &P::level_rule,
                "Equal steps over the range (linear), steps of level_step, the list level_list, equal shares of area, "
                "every distinct value, or steps that grow with the scalar from its noise (noise).");
    s.parameter(
        "range", &P::range, range(0, 1), "",
        "Quantiles of the scalar between which levels are laid; for the lower tree, of the scalar with its sign "
        "turned.");
    s.parameter("strength_range", &P::strength_range, range(0, 10), "",
                "Shares of the strength of lines between which levels are laid, in place of quantiles: the value at "
                "which half of the sum of S^2 over S > 0 lies above, whatever share of the surface the lines take.");
    s.parameter("value_range", &P::value_range, Range{}, "scalar",
                "Values of the scalar between which levels are laid, in place of quantiles.");
    s.parameter("level_step", &P::level_step, more_than(0), "scalar", "Step of the rule step.");
    s.parameter("level_list", &P::level_list, Range{}, "scalar",
                "Levels of the rule list, in any order; triangles below the lowest are in no region.");
    s.parameter("level_constant", &P::level_constant, more_than(0), "noise",
                "Where the rule noise turns from equal to growing steps.");
    s.parameter("noise", &P::noise, more_than(0), "scalar",
                "Standard deviation of the scalar's noise, where the stage that made it does not know it.");
    s.parameter("delta_value", &P::delta_value, at_least(0), "scalar",
                "Adds a level this far on both sides of each level.");
    s.parameter(
        "polarity", &P::polarity,
        "Trees of high regions (upper), of low ones (lower), or both; or one tree of high and low regions within "
        "each other, holes in them filled (shapes), on surfaces without handles.");
    s.parameter("root", &P::root, Range{}, "coordinates",
                "For shapes: a place outside all regions, the vertex nearest to x, y, z; none: what lies beyond the "
                "longest rim, on a closed surface the middle.");
  }

  /// A scalar named with its stage needs that stage alone.
  static std::vector<std::string> choose(const Parameters& p, std::string_view port,
                                         const std::vector<std::string>& available) {
    if (port != "scalars") return available;
    for (const std::string& stage : available)
      if (p.scalar.starts_with(stage + ".")) return {stage};
    return available;
  }

  static std::vector<ParameterProblem> check(const Parameters& p) {
    std::vector<ParameterProblem> problems;
    if (p.level_rule == LevelRule::kStep && !p.level_step)
      problems.emplace_back("level_rule", "the rule step needs level_step");
    if (p.level_rule == LevelRule::kList && p.level_list.empty())
      problems.emplace_back("level_rule", "the rule list needs level_list");
    if (!(p.range[0].value < p.range[1].value))
      problems.emplace_back("range", "the first quantile must be less than the second");
    if (p.value_range && !((*p.value_range)[0] < (*p.value_range)[1]))
      problems.emplace_back("value_range", "the first value must be less than the second");
    if (p.root && p.polarity != PolarityChoice::kShapes)
      problems.emplace_back("root", "only polarity: shapes has a root to choose; leave root out, or take shapes");
    return problems;
  }

  static Outputs run(const Parameters& parameters, const Inputs& inputs, RunContext& context) {
    const LevelRule rule = parameters.level_rule;
    const bool has_range = rule != LevelRule::kList && rule != LevelRule::kEveryValue;
    context.warn_if_idle(parameters.level_step && rule != LevelRule::kStep, "level_step", "level_rule: step");
    context.warn_if_idle(!parameters.level_list.empty() && rule != LevelRule::kList, "level_list", "level_rule: list");
    context.warn_if_idle(parameters.value_range && !has_range, "value_range", "a level_rule with a range");
    context.warn_if_idle(parameters.strength_range && !has_range, "strength_range", "a level_rule with a range");
    const auto& mesh = inputs.get<TriangleMesh>("mesh");
    std::vector<StageFields> fields;
    for (const auto& [stage, scalars] : inputs.all<ScalarFields>("scalars")) fields.push_back({stage, scalars});
    const VertexScalar scalar = find_vertex_scalar(parameters.scalar, fields, mesh, inputs.find<PointCloud>("cloud"));
    LevelSetTreesParameters resolved = resolve(parameters, scalar, scale_of(mesh));
    if (parameters.root)
      resolved.root =
          Eigen::Vector3d((*parameters.root)[0], (*parameters.root)[1], (*parameters.root)[2]) - mesh.origin;
    LevelSetTreesResult result = build_level_set_trees(mesh, scalar, resolved, context.execution());

    const Exclusion& exclusion = result.exclusion;
    const auto num_triangles = static_cast<std::int64_t>(mesh.num_triangles());
    context.report("num_triangles", num_triangles);
    context.report("num_excluded_nan", exclusion.num_nan);
    context.report("num_excluded_near_rim", exclusion.num_near_rim);
    if (parameters.fallen_rim) context.report("fallen_depth", result.fallen_depth, context.units());
    for (const ComponentTree& tree : result.trees.trees) {
      const std::string side = std::string("_") + name_of(tree.polarity);
      std::int64_t roots = 0;
      for (const std::int32_t parent : tree.parent_of_node) roots += parent < 0;
      context.report("num_levels" + side, static_cast<std::int64_t>(tree.levels.size()));
      context.report("num_nodes" + side, static_cast<std::int64_t>(tree.num_nodes()));
      context.report("num_roots" + side, roots);
      // In the scalar's own values: a lower tree counts them with their sign turned.
      const auto first =
          std::find_if(tree.levels.begin(), tree.levels.end(), [](double l) { return std::isfinite(l); });
      if (first == tree.levels.end()) continue;
      const bool lower = tree.polarity == Polarity::kLower;
      context.report("least_level" + side, lower ? -tree.levels.back() : *first, result.trees.unit);
      context.report("greatest_level" + side, lower ? -*first : tree.levels.back(), result.trees.unit);
    }
    if (result.root_vertex >= 0) context.report("root_vertex", std::int64_t{result.root_vertex});
    if (std::isfinite(result.trees.noise)) context.report("noise", result.trees.noise, result.trees.unit);
    if (num_triangles > 0 && exclusion.num_nan + exclusion.num_near_rim == num_triangles)
      context.warn("every triangle is left out (" + std::to_string(exclusion.num_nan) +
                   " touch a value that is not finite, " + std::to_string(exclusion.num_near_rim) +
                   " are near a rim): no region can be found; lessen exclude_rim or look at the scalar");
    Outputs outputs;
    outputs.set("trees", std::move(result.trees));
    return outputs;
  }
};

namespace {
MESHMSER_STAGE(TreeStage);
}  // namespace

}  // namespace meshmser
