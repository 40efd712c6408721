#include <fmt/format.h>

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/stage/stage.hpp"
#include "stages/common/bounding_box.hpp"
#include "stages/orient/orient.hpp"

namespace meshmser {

template <>
struct EnumNames<NormalChoice> {
  static constexpr std::pair<NormalChoice, const char*> values[] = {{NormalChoice::kEstimated, "estimated"},
                                                                    {NormalChoice::kGiven, "given"}};
};
template <>
struct EnumNames<SignChoice> {
  static constexpr std::pair<SignChoice, const char*> values[] = {{SignChoice::kAuto, "auto"},
                                                                  {SignChoice::kGiven, "given"},
                                                                  {SignChoice::kScanner, "scanner"},
                                                                  {SignChoice::kViewpoint, "viewpoint"},
                                                                  {SignChoice::kVolume, "volume"}};
};

/// `none`, `all`, or a list of components.
struct Flip {
  bool all = false;
  std::vector<int> components;
};
template <>
struct ParameterType<Flip> {
  static ParameterShape shape() {
    ParameterShape list = ParameterType<std::vector<int>>::shape();
    list.words = {"none", "all"};
    return list;
  }
  static void bind(const ConfigValue& value, const BindContext& context, Range bounds, Flip& target,
                   std::vector<Diagnostic>& problems) {
    target = {};
    if (detail::is_word(value, "none")) return;
    target.all = detail::is_word(value, "all");
    if (!target.all) ParameterType<std::vector<int>>::bind(value, context, bounds, target.components, problems);
  }
  static std::string format(const Flip& value) {
    if (value.all) return "all";
    return value.components.empty() ? "none" : ParameterType<std::vector<int>>::format(value.components);
  }
  static Flip randomize(Range bounds, std::mt19937_64& random) {
    if (random() % 2 == 0) return {random() % 2 == 0, {}};
    return {false, ParameterType<std::vector<int>>::randomize(bounds, random)};
  }
};

namespace {

struct OrientParameters {
  int neighbors = 12;
  Length max_gap = spacings(8);
  NormalChoice normals = NormalChoice::kEstimated;
  SignChoice sign = SignChoice::kAuto;
  std::optional<std::array<double, 3>> viewpoint;
  Flip flip;
};

const char* name_of(SignSource source) {
  switch (source) {
    case SignSource::kGiven:
      return "given normals";
    case SignSource::kScanner:
      return "scanner position";
    case SignSource::kViewpoint:
      return "viewpoint";
    case SignSource::kEnclosedVolume:
      return "enclosed volume";
    case SignSource::kGuess:
      return "guess";
  }
  return "";
}

// Only so many components are told one by one.
constexpr std::size_t kToldComponents = 8;

void tell(const Orientation& made, RunContext& context) {
  const auto& components = made.normals.components;
  const OrientReport& r = made.report;
  context.report("num_components", static_cast<std::int64_t>(components.size()));
  context.report("num_unoriented", r.num_unoriented);
  const double share = r.num_edges > 0 ? static_cast<double>(r.num_disagreeing) / static_cast<double>(r.num_edges) : 0;
  context.report("share_disagreeing_neighbors", share);
  for (std::size_t c = 0; c < std::min(components.size(), kToldComponents); ++c)
    context.report(fmt::format("component_{}", c + 1),
                   fmt::format("{} points, sign by {}, confidence {:.2f}{}", components[c].num_points,
                               name_of(components[c].source), components[c].confidence,
                               components[c].flipped_by_user ? ", flipped" : ""));

  std::size_t guessed = 0;
  std::int64_t guessed_points = 0;
  std::string list;
  for (std::size_t c = 0; c < components.size(); ++c) {
    if (components[c].source != SignSource::kGuess || components[c].flipped_by_user) continue;
    if (guessed < kToldComponents) {
      const Eigen::Vector3d& center = r.centers[c];
      list += fmt::format("{}component {} ({} points around {:.4g}, {:.4g}, {:.4g})", guessed > 0 ? ", " : "", c + 1,
                          components[c].num_points, center.x(), center.y(), center.z());
    }
    ++guessed;
    guessed_points += components[c].num_points;
  }
  if (guessed > kToldComponents) list += fmt::format(" and {} more", guessed - kToldComponents);
  context.report("num_guessed_points", guessed_points);
  if (guessed > 0)
    context.warn("which side is outside is a guess on " + list +
                 ": open sheets enclose no volume; orient.viewpoint or orient.flip decides it");
  if (r.num_unoriented > 0)
    context.warn(
        fmt::format("{} no normal, because the neighbours within orient.max_gap define no plane there; no part in "
                    "curvature and mesh",
                    r.num_unoriented == 1 ? "1 point has" : std::to_string(r.num_unoriented) + " points have"));
  if (share > 0.02)
    context.warn(
        fmt::format("{:.1f} % of the neighbours disagree about the side of the surface: noise may be too "
                    "large for the regression (raise orient.neighbors), or sheets lie closer than 3 spacings",
                    100 * share));
}

struct OrientStage {
  static constexpr StageInfo info{"orient", 1,
                                  "Gives every point a normal, signs consistent and outward [Hoppe 1992]."};
  using Parameters = OrientParameters;

  static void declare(StageSchema& schema) {
    schema.parameter("neighbors", &Parameters::neighbors, range(3, 200), "points",
                     "Neighbours in the regression and in the propagation graph.");
    schema.parameter("max_gap", &Parameters::max_gap, more_than(0), "",
                     "Points farther apart are no neighbours: wider gaps separate components.");
    schema.parameter("normals", &Parameters::normals,
                     "estimated: from the regression; given: the file's nx, ny, nz as they are.");
    schema.parameter("sign", &Parameters::sign,
                     "What decides the sides: auto takes the viewpoint where one is set, else the scanner's position "
                     "where known, else the enclosed volume, else a guess away from the cloud's centroid.");
    schema.parameter("viewpoint", &Parameters::viewpoint,
                     "A point x, y, z in the frame of the raw scan; each component is turned toward it.");
    schema.parameter("flip", &Parameters::flip, range(1, 2147483647), "components",
                     "Turns over all components, or those listed (1 is the largest).");
    schema.input<PointCloud>("points");
    schema.output<PointNormals>("normals");
  }

  static std::vector<ParameterProblem> check(const Parameters& p) {
    if (p.sign == SignChoice::kViewpoint && !p.viewpoint)
      return {{"sign", "sign: viewpoint needs 'viewpoint', as in viewpoint: [0, 0, 500]"}};
    return {};
  }

  static Outputs run(const Parameters& p, const Inputs& inputs, RunContext& context) {
    const auto& cloud = inputs.get<PointCloud>("points");
    OrientOptions options;
    options.neighbors = p.neighbors;
    options.max_gap = p.max_gap.resolve({cloud.spacing, bounding_diagonal(cloud.positions), 0});
    options.normals = p.normals;
    options.sign = p.sign;
    if (p.viewpoint) options.viewpoint = Eigen::Vector3d((*p.viewpoint)[0], (*p.viewpoint)[1], (*p.viewpoint)[2]);
    options.flip_all = p.flip.all;
    options.flip = p.flip.components;
    Orientation made = orient(cloud, options, context.execution());
    tell(made, context);
    Outputs outputs;
    outputs.set("normals", std::move(made.normals));
    return outputs;
  }
};
MESHMSER_STAGE(OrientStage);

}  // namespace
}  // namespace meshmser
