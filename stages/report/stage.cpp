#include "pipeline/stage/stage.hpp"

#include "stages/report/report.hpp"

namespace meshmser {
namespace {

struct ReportParameters {
  std::string title;
  std::int64_t max_triangles = 1000000;
};

struct ReportStage {
  static constexpr StageInfo info{"report", 8, "Writes report.html: one page, opened from disk, that shows the run."};
  using Parameters = ReportParameters;

  static void declare(StageSchema& schema) {
    schema.parameter("title", &Parameters::title, "Heading of the page; empty: the scans' names.");
    schema.parameter("max_triangles", &Parameters::max_triangles, range(1000, 2000000), "triangles",
                     "A larger mesh is simplified to so many, for display only.");
    schema.input<PointCloud>("points", Need::kOptional);
    schema.input<PointNormals>("normals", Need::kOptional);
    schema.input<SmoothedPoints>("smoothed", Need::kOptional);
    schema.input<ScalarFields>("scalars", Need::kAll);
    schema.input<TriangleMesh>("mesh", Need::kOptional);
    schema.input<LevelSetTrees>("trees", Need::kOptional);
    schema.input<Segmentation>("segmentation", Need::kOptional);
    schema.input<BorderSet>("borders", Need::kOptional);
    schema.output<FileSet>("files");
  }

  static Outputs run(const Parameters& p, const Inputs& inputs, RunContext& context) {
    ReportContents contents;
    contents.points = inputs.find<PointCloud>("points");
    contents.normals = inputs.find<PointNormals>("normals");
    contents.smoothed = inputs.find<SmoothedPoints>("smoothed");
    contents.scalars = inputs.all<ScalarFields>("scalars");
    contents.mesh = inputs.find<TriangleMesh>("mesh");
    contents.trees = inputs.find<LevelSetTrees>("trees");
    contents.segmentation = inputs.find<Segmentation>("segmentation");
    contents.borders = inputs.find<BorderSet>("borders");
    ReportOptions options;
    options.title = p.title;
    options.units = context.units();
    options.max_triangles = static_cast<std::size_t>(p.max_triangles);
    FileSet files;
    files.folder = context.scratch_folder();
    files.names = {"report.html"};
    const ReportSummary summary =
        write_report(files.folder / files.names.front(), contents, options, context.execution());
    context.report("num_triangles_drawn", summary.num_triangles);
    context.report("num_bytes", summary.num_bytes);
    Outputs outputs;
    outputs.set("files", std::move(files));
    return outputs;
  }
};
MESHMSER_STAGE(ReportStage);

}  // namespace
}  // namespace meshmser
