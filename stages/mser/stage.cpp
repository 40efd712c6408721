#include "pipeline/stage/stage.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "pipeline/artifacts/scalar_fields.hpp"
#include "stages/common/adjacency.hpp"
#include "stages/mser/mser_parameters.hpp"

namespace meshmser {

template <>
struct EnumNames<Select> {
  static constexpr std::pair<Select, const char*> values[] = {{Select::kMser, "mser"},
                                                              {Select::kPersistence, "persistence"},
                                                              {Select::kStableBranch, "stable_branch"},
                                                              {Select::kLength, "length"},
                                                              {Select::kLevel, "level"},
                                                              {Select::kMeaningful, "meaningful"}};
};
template <>
struct EnumNames<Against> {
  static constexpr std::pair<Against, const char*> values[] = {{Against::kChildren, "children"},
                                                               {Against::kMainChild, "main_child"}};
};
template <>
struct EnumNames<Nested> {
  static constexpr std::pair<Nested, const char*> values[] = {{Nested::kKeep, "keep"},
                                                              {Nested::kOutermost, "outermost"},
                                                              {Nested::kInnermost, "innermost"},
                                                              {Nested::kMostStable, "most_stable"}};
};
template <>
struct EnumNames<Grow> {
  static constexpr std::pair<Grow, const char*> values[] = {
      {Grow::kNone, "none"}, {Grow::kAbsorb, "absorb"}, {Grow::kWatershed, "watershed"}, {Grow::kLevel, "level"}};
};
template <>
struct EnumNames<FloodBy> {
  static constexpr std::pair<FloodBy, const char*> values[] = {
      {FloodBy::kStrength, "strength"}, {FloodBy::kFacets, "facets"}, {FloodBy::kLikeness, "likeness"}};
};
template <>
struct EnumNames<Border> {
  static constexpr std::pair<Border, const char*> values[] = {{Border::kFlood, "flood"}, {Border::kSides, "sides"}};
};
template <>
struct EnumNames<Merge> {
  static constexpr std::pair<Merge, const char*> values[] = {
      {Merge::kNone, "none"}, {Merge::kSaliency, "saliency"}, {Merge::kTurning, "turning"}};
};

namespace {

/// A scalar of an earlier stage by its name, as `crease` or `fine.crease`; of several the last.
struct FoundScalar {
  std::string name;
  const ScalarField* field = nullptr;
};

FoundScalar find_scalar(const Inputs& inputs, const std::string& name) {
  FoundScalar found;
  for (const auto& [stage, scalars] : inputs.all<ScalarFields>("scalars"))
    for (const ScalarField& field : scalars->fields)
      if (name == field.name || name == stage + "." + field.name) found = {field.name, &field};
  return found;
}

/// Values at the vertices of a mesh of a scalar at the points of its cloud, without their sign.
std::vector<double> magnitudes_at_vertices(const TriangleMesh& mesh, const ScalarField& field) {
  std::vector<double> values;
  values.reserve(mesh.num_vertices());
  for (const std::int32_t point : mesh.point_of_vertex)
    values.push_back(std::abs(field.values.at(static_cast<std::size_t>(point))));
  return values;
}

/// The strength asked for by name: a scalar of an earlier stage or a property of the mesh; empty for `auto`.
std::vector<double> named_strength(const MserParameters& parameters, const TriangleMesh& mesh, const Inputs& inputs) {
  if (parameters.strength == "auto") return {};
  if (const FoundScalar found = find_scalar(inputs, parameters.strength); found.field != nullptr)
    return magnitudes_at_vertices(mesh, *found.field);
  for (const Property& property : mesh.properties)
    if (property.name == parameters.strength) {
      std::vector<double> values = property.values;
      for (double& value : values) value = std::abs(value);
      return values;
    }
  throw StageError("mser: no earlier stage and no property of the mesh gives the strength '" + parameters.strength +
                   "'; name a scalar of a curvature stage (crease, mean_curvature ...) or leave it at auto");
}

/// The greatest principal curvature that a value of a scalar stands for on a cylinder; 0: the scalar tells none.
double bending_per_value(const std::string& scalar) {
  const auto ends_with = [&](const std::string& end) {
    return scalar.size() >= end.size() && scalar.compare(scalar.size() - end.size(), end.size(), end) == 0;
  };
  if (ends_with("crease")) return 1 / std::numbers::sqrt2;
  if (ends_with("max_abs_curvature")) return 1;
  if (ends_with("mean_curvature")) return 2;
  return 0;
}

/// The curvature that explains turning: from `crease` of an earlier stage, else from the tree's own scalar.
std::vector<double> bending(const LevelSetTrees& trees, const TriangleMesh& mesh, const Inputs& inputs) {
  std::vector<double> values;
  double factor = bending_per_value("crease");
  const std::size_t dot = trees.scalar.find('.');
  FoundScalar found;
  if (dot != std::string::npos) found = find_scalar(inputs, trees.scalar.substr(0, dot) + ".crease");
  if (found.field == nullptr) found = find_scalar(inputs, "crease");
  if (found.field != nullptr) {
    values = magnitudes_at_vertices(mesh, *found.field);
  } else {
    factor = bending_per_value(trees.scalar);
    if (factor == 0) return {};
    values = trees.values;
  }
  for (double& value : values) value = factor * std::abs(value);
  return values;
}

bool wants_bending(const MserParameters& p) {
  return p.merge == Merge::kTurning || (p.grow == Grow::kWatershed && p.flood_by == FloodBy::kFacets);
}

double resolve(const Amount& amount, const LevelSetTrees& trees, const std::string& parameter) {
  if (amount.unit == Amount::Unit::kNoise && !std::isfinite(trees.noise))
    throw StageError("mser." + parameter + " is given in units of noise, but the noise of the scalar '" + trees.scalar +
                     "' is not known; give " + parameter + " in the scalar's own unit, or the noise to the tree stage");
  return amount.resolve(trees.noise);
}

}  // namespace

SegmentParameters resolve(const MserParameters& given, const TriangleMesh& mesh, const LevelSetTrees& trees,
                          const Execution& execution) {
  Scale scale;
  scale.spacing = mesh.spacing;
  for (const double area : triangle_areas(mesh.positions, mesh.triangles, execution)) scale.area += area;
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& position : mesh.positions) box.extend(position);
  if (!box.isEmpty()) scale.diagonal = box.diagonal().norm();

  SegmentParameters p;
  p.select = given.select;
  p.delta = given.delta;
  p.delta_value = given.delta_value.value_or(0);
  p.against = given.against;
  p.min_length = given.min_length.value_or(Length{}).resolve(scale);
  p.level = given.level.value_or(0);
  p.max_false_alarms = given.max_false_alarms;
  p.independent = given.independent.resolve(scale);
  p.min_area = given.min_area.resolve(scale);
  if (given.max_area) p.max_area = given.max_area->resolve(scale);
  if (given.max_variation) p.max_variation = *given.max_variation;
  if (!given.min_persistence.automatic)
    p.min_persistence = resolve(given.min_persistence.value, trees, "min_persistence");
  else
    p.min_persistence = std::isfinite(trees.noise) ? 6 * trees.noise : 0;
  p.min_contrast = given.min_contrast.automatic ? (given.select == Select::kMser && std::isfinite(trees.noise) ? 3 : 0)
                                                : given.min_contrast.value;
  p.band = given.band.resolve(scale);
  p.min_diversity = given.min_diversity.value;
  p.nested = given.nested;
  p.keep_largest = given.keep_largest.value_or(0);
  p.grow = given.grow;
  p.absorb_area = given.absorb.resolve(scale);
  p.flood_by = given.flood_by;
  p.flood_width = given.flood_width.resolve(scale);
  p.border = given.border;
  p.side_radius = given.side_radius.resolve(scale);
  p.spacing = mesh.spacing;
  p.merge = given.merge;
  if (given.merge == Merge::kSaliency) p.saliency = resolve(given.saliency, trees, "saliency");
  p.turning = given.turning.degrees * std::numbers::pi / 180;
  p.turning_radius = given.turning_radius.resolve(scale);
  return p;
}

struct MserStage {
  static constexpr StageInfo info{
      "mser", 10, "Selects the stable regions of the level sets and labels the triangles [Digne et al. 2010]."};
  using Parameters = MserParameters;

  static void declare(StageSchema& s) {
    using P = Parameters;
    s.input<TriangleMesh>("mesh");
    s.input<LevelSetTrees>("trees");
    s.input<ScalarFields>("scalars", Need::kAll);
    s.output<Segmentation>("segmentation");
    s.parameter("select", &P::select,
                "What makes a region: a local minimum of change over levels (mser), the largest part with one "
                "significant maximum (persistence), the least change within such a part (stable_branch), every level "
                "line of at least min_length (length), the parts above or below one level (level), or the level lines "
                "steeper than chance allows "
                "(meaningful).");
    s.parameter("delta", &P::delta, range(1, 1e6), "levels", "Level steps up and down over which change is measured.");
    s.parameter("delta_value", &P::delta_value, more_than(0), "scalar",
                "Change is measured over so much of the scalar up and down, in place of delta; the same value of "
                "tree.delta_value lays levels there.");
    s.parameter("against", &P::against,
                "Whether a region must change less than all its children in the tree, or than the largest only.");
    s.parameter("min_length", &P::min_length, more_than(0), "", "Of a level line, for select: length.");
    s.parameter(
        "level", &P::level, Range{}, "scalar",
        "For select: level; the nearest level of the tree below it counts, of a lower tree the nearest above it.");
    s.parameter("max_false_alarms", &P::max_false_alarms, more_than(0), "lines",
                "For select: meaningful; so many lines as long and steep as one selected may be expected by chance.");
    s.parameter("independent", &P::independent, more_than(0), "",
                "For select: meaningful; from this distance along a line gradients count as independent.");
    s.parameter("min_area", &P::min_area, at_least(0), "",
                "Smaller regions are left out; with persistence and stable_branch smaller parts are not significant.");
    s.parameter("max_area", &P::max_area, more_than(0), "", "Larger regions are left out.");
    s.parameter("max_variation", &P::max_variation, at_least(0), "",
                "Regions that change by more than this share of their area are left out.");
    s.parameter("min_persistence", &P::min_persistence, at_least(0), "",
                "Regions whose highest maximum rises less than this above its surroundings are left out; auto: 6 noise "
                "where the noise is known, else 0.");
    s.parameter("min_contrast", &P::min_contrast, at_least(0), "noise",
                "Regions across whose border the scalar steps by less than this are left out; auto: 3 for select: mser "
                "where the noise is known, else 0.");
    s.parameter("band", &P::band, more_than(0), "", "Width on each side of a border over which contrast is measured.");
    s.parameter("min_diversity", &P::min_diversity, range(0, 1), "",
                "Of two nested regions whose areas differ by less than this share the less stable is left out.");
    s.parameter("nested", &P::nested, "What remains of regions within regions.");
    s.parameter("keep_largest", &P::keep_largest, at_least(1), "regions", "So many of the largest regions remain.");
    s.parameter(
        "grow", &P::grow,
        "Afterwards: all that is left is flooded from the labels, so that they meet on the crests (watershed), "
        "and small patches join a neighbour (watershed, absorb); level: triangles that the region's level line cuts "
        "join it where their mean reaches the level, and small patches a neighbour.");
    s.parameter("absorb", &P::absorb, at_least(0), "",
                "Patches smaller than this join the neighbour with the longest common border, unless grow is none.");
    s.parameter(
        "flood_by", &P::flood_by,
        "Order of the watershed: across the weakest edges first (strength), across those of least curvature and "
        "turn from the label's own normal first (facets), or most like the label's mean first (likeness).");
    s.parameter("flood_width", &P::flood_width, more_than(0), "",
                "For facets: the width over which an edge's curvature counts as turn.");
    s.parameter("strength", &P::strength,
                "Scalar along whose crests labels meet and are parted: auto is that of the tree, without its sign; or "
                "a name, as crease or fine.crease.");
    s.parameter("border", &P::border,
                "Where labels part: where the floods met (flood), or where the planes of both sides meet (sides).");
    s.parameter("side_radius", &P::side_radius, more_than(0), "",
                "For border: sides; how far from the border planes are fitted.");
    s.parameter("merge", &P::merge,
                "Joins neighbouring labels where the scalar hardly rises at their border (saliency) or the surface "
                "hardly turns (turning).");
    s.parameter("saliency", &P::saliency, at_least(0), "",
                "A border whose mean strength exceeds both sides' by less than this is none.");
    s.parameter("turning", &P::turning, range(0, 180), "",
                "A border across which the surface turns by less than this, beyond the sides' own bending, is none.");
    s.parameter("turning_radius", &P::turning_radius, more_than(0), "",
                "How far from the border the sides are compared.");
  }

  /// Scalars are wanted only where a parameter asks for them, so that others cannot make this stage run again.
  static std::vector<std::string> choose(const Parameters& p, std::string_view,
                                         const std::vector<std::string>& available) {
    if (p.strength == "auto" && !wants_bending(p)) return {};
    const std::size_t dot = p.strength.find('.');
    if (dot == std::string::npos || wants_bending(p)) return available;
    std::vector<std::string> wanted;
    for (const std::string& stage : available)
      if (stage == p.strength.substr(0, dot)) wanted.push_back(stage);
    return wanted;
  }

  static std::vector<ParameterProblem> check(const Parameters& p) {
    std::vector<ParameterProblem> problems;
    if (p.select == Select::kLength && !p.min_length)
      problems.emplace_back("min_length", "select: length needs min_length, as 20 mm or 200 spacing");
    if (p.select == Select::kLevel && !p.level)
      problems.emplace_back("level", "select: level needs level, a value of the scalar");
    return problems;
  }

  static Outputs run(const Parameters& parameters, const Inputs& inputs, RunContext& context) {
    const Select select = parameters.select;
    context.warn_if_idle(parameters.min_length && select != Select::kLength, "min_length", "select: length");
    context.warn_if_idle(parameters.level && select != Select::kLevel, "level", "select: level");
    context.warn_if_idle(parameters.delta_value && select != Select::kMser && select != Select::kStableBranch,
                         "delta_value", "select: mser and stable_branch");
    const auto& mesh = inputs.get<TriangleMesh>("mesh");
    const auto& trees = inputs.get<LevelSetTrees>("trees");
    std::vector<std::int32_t> twins = twin_half_edges(mesh.triangles, mesh.num_vertices(), context.execution());
    if (!trees.excluded_of_triangle.empty()) cut_out_triangles(twins, trees.excluded_of_triangle);
    const SegmentParameters resolved = resolve(parameters, mesh, trees, context.execution());
    const std::vector<double> strength = named_strength(parameters, mesh, inputs);
    std::vector<double> curvature;
    if (wants_bending(parameters)) curvature = bending(trees, mesh, inputs);
    Segmentation segmentation =
        segment({{mesh.positions, mesh.triangles, twins}, trees, strength, curvature, mesh.normals}, resolved,
                context.execution(), true);

    context.report("num_regions", static_cast<std::int64_t>(segmentation.regions.size()));
    context.report("num_labels", static_cast<std::int64_t>(segmentation.region_of_label.size()) - 1);
    for (const FilterCount& count : segmentation.filters)
      context.report("removed_by_" + count.filter, count.removed, "of " + std::to_string(count.seen));
    if (resolved.min_persistence > 0) context.report("min_persistence", resolved.min_persistence, trees.unit);
    const auto background = static_cast<std::int64_t>(
        std::count(segmentation.label_of_triangle.begin(), segmentation.label_of_triangle.end(), 0));
    context.report("num_background_triangles", background);
    if (wants_bending(parameters) && curvature.empty())
      context.warn("mser knows no curvature for the scalar '" + trees.scalar +
                   "', so curved faces may stay split; compute `crease` with a curvature stage");
    Outputs outputs;
    outputs.set("segmentation", std::move(segmentation));
    return outputs;
  }
};

namespace {
MESHMSER_STAGE(MserStage);
}  // namespace

}  // namespace meshmser
