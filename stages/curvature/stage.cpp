#include <fmt/format.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/stage/stage.hpp"
#include "stages/common/bounding_box.hpp"
#include "stages/curvature/curvature.hpp"
#include "stages/curvature/line_scale.hpp"

namespace meshmser {

template <>
struct EnumNames<CurvatureMethod> {
  static constexpr std::pair<CurvatureMethod, const char*> values[] = {{CurvatureMethod::kScaleSpace, "scale_space"},
                                                                       {CurvatureMethod::kQuadric, "quadric"}};
};

template <>
struct EnumNames<RimTreatment> {
  static constexpr std::pair<RimTreatment, const char*> values[] = {{RimTreatment::kMark, "mark"},
                                                                    {RimTreatment::kExclude, "exclude"}};
};

namespace {

struct CurvatureParameters {
  Length radius = spacings(4);
  int steps = 4;
  CurvatureMethod method = CurvatureMethod::kScaleSpace;
  std::optional<AutoOr<Length>> line_width;
  std::optional<Length> height_radius;
  int height_steps = 4;
  RimTreatment rims = RimTreatment::kMark;
};

void tell(const Curvature& made, const PointCloud& cloud, RunContext& context) {
  const CurvatureReport& r = made.report;
  context.report("radius", made.scalars.radius, context.units());
  context.report("noise", r.noise, context.units());
  if (cloud.spacing > 0) context.report("noise_in_spacings", r.noise / cloud.spacing);
  for (const ScalarField& field : made.scalars.fields)
    if (field.name == "mean_curvature" || field.name == "height")
      context.report("sigma_" + field.name, field.noise,
                     field.unit == "unit" ? context.units() : "1/" + context.units());
  context.report("num_isolated", r.num_isolated);
  context.report("num_unoriented", r.num_unoriented);
  context.report("num_without_quadric", r.num_without_quadric);
  context.report("num_at_rims", r.num_at_rims);
  const auto n = static_cast<std::int64_t>(cloud.num_points());
  if (100 * r.num_isolated > n)
    context.warn(
        fmt::format("{} of {} points have too few neighbours within curvature.radius ({:.4g} {}) for a plane: "
                    "their curvature is undefined; raise the radius",
                    r.num_isolated, n, made.scalars.radius, context.units()));
}

struct CurvatureStage {
  static constexpr StageInfo info{"curvature", 3,
                                  "Smooths the points by projection on regression planes and measures the curvature "
                                  "at every raw point [Digne et al. 2011]."};
  using Parameters = CurvatureParameters;

  static void declare(StageSchema& schema) {
    schema.parameter("radius", &Parameters::radius, more_than(0), "",
                     "Of the regression neighbourhood; features closer together than twice the radius merge.");
    schema.parameter("steps", &Parameters::steps, range(1, 100), "steps",
                     "Of smoothing; the last one measures the curvature.");
    schema.parameter("method", &Parameters::method,
                     "scale_space: H from the last step's displacement; quadric: from a quadric fitted to the raw "
                     "points within the radius, for comparison.");
    schema.parameter(
        "line_width", &Parameters::line_width, more_than(0), "",
        "Width of the lines looked for; sets radius to 0.375 of it and steps to 4; auto measures it on the "
        "scan's relief.");
    schema.parameter("height_radius", &Parameters::height_radius, more_than(0), "",
                     "Adds the scalar height above a surface smoothed with this radius; costly when large.");
    schema.parameter("height_steps", &Parameters::height_steps, range(1, 100), "steps", "Of that smoothing.");
    schema.parameter("rims", &Parameters::rims,
                     "Points within half a radius of a rim of the cloud, where curvature is biased: mark: the scalar "
                     "rim_distance tells them; exclude: their curvature is undefined as well.");
    schema.input<PointCloud>("points");
    schema.input<PointNormals>("normals");
    schema.output<SmoothedPoints>("smoothed");
    schema.output<ScalarFields>("scalars");
  }

  static Outputs run(const Parameters& p, const Inputs& inputs, RunContext& context) {
    const auto& cloud = inputs.get<PointCloud>("points");
    const Scale scale{cloud.spacing, bounding_diagonal(cloud.positions), 0};
    CurvatureOptions options;
    options.radius = p.radius.resolve(scale);
    options.steps = p.steps;
    const auto& normals = inputs.get<PointNormals>("normals");
    double line_width = 0;
    if (p.line_width) {
      constexpr int kStepsForLines = 4;
      options.steps = kStepsForLines;
      options.radius =
          p.line_width->automatic
              ? measure_line_scale(cloud.positions, normals.normals, cloud.spacing, context.execution()).radius
              : kRadiusOfLineWidth * p.line_width->value.resolve(scale);
      line_width = options.radius / kRadiusOfLineWidth;
      context.report("line_width", line_width, context.units());
    }
    options.method = p.method;
    if (p.height_radius) options.height_radius = p.height_radius->resolve(scale);
    options.height_steps = p.height_steps;
    options.rims = p.rims;
    Curvature made = measure_curvature(cloud, normals, options, context.execution());
    made.scalars.line_width = line_width;
    tell(made, cloud, context);
    Outputs outputs;
    outputs.set("smoothed", std::move(made.smoothed));
    outputs.set("scalars", std::move(made.scalars));
    return outputs;
  }
};
MESHMSER_STAGE(CurvatureStage);

}  // namespace
}  // namespace meshmser
