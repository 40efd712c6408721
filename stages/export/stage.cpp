#include "pipeline/stage/stage.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "stages/export/export_files.hpp"
#include "stages/export/plan_files.hpp"
#include "stages/export/render.hpp"
#include "stages/export/views.hpp"

namespace meshmser {
namespace {

struct ExportParameters {
  bool points = true;
  bool tree = true;
  bool pictures = true;
  std::vector<std::string> views;
  std::string title;
  std::string drawings = "fit";
};

/// All that may have been made, each possibly null.
struct Results {
  const PointCloud* points;
  const PointNormals* normals;
  std::vector<std::pair<std::string, const ScalarFields*>> scalars;
  const TriangleMesh* mesh;
  const LevelSetTrees* trees;
  const Segmentation* segmentation;
  const BorderSet* borders;
};

/// Writes files one by one into the scratch folder and remembers their names.
class Writer {
 public:
  Writer(const ExportParameters& p, const Results& r, RunContext& context) : p_(p), r_(r), context_(context) {
    files_.folder = context.scratch_folder();
  }

  FileSet write() {
    if (r_.mesh) write_mesh();
    if (r_.points && p_.points) file("points.ply", [&](const auto& path) { write_points(path); });
    if (r_.segmentation) write_regions();
    if (r_.trees && p_.tree)
      file("tree.csv", [&](const auto& path) { write_tree_csv(path, *r_.trees, r_.segmentation); });
    if (r_.mesh && r_.borders) write_borders();
    if (r_.mesh && p_.pictures && r_.mesh->num_triangles() > 0) draw();
    return std::move(files_);
  }

 private:
  template <class Write>
  void file(const std::string& name, Write&& write_to) {
    context_.execution().report(name, static_cast<std::int64_t>(files_.names.size()), 0);
    write_to(files_.folder / name);
    files_.names.push_back(name);
  }

  void write_mesh() {
    SegmentColumns columns;
    if (r_.segmentation) columns.labels = r_.segmentation->label_of_triangle;
    std::vector<double> quality;
    if (r_.trees) {
      columns.quality = r_.trees->values;
    } else if (const ScalarField* field = shown_field()) {
      quality = at_vertices(*field);
      columns.quality = quality;
    }
    file(r_.segmentation ? "segments.ply" : "mesh.ply",
         [&](const auto& path) { write_segments_ply(path, *r_.mesh, columns); });
  }

  /// Points whose normal the mesh turned: their normals and odd scalars are turned here too.
  std::vector<std::uint8_t> turned_points() const {
    std::vector<std::uint8_t> turned(r_.points->num_points(), 0);
    if (r_.mesh)
      for (std::size_t v = 0; v < r_.mesh->turned_of_vertex.size(); ++v)
        if (r_.mesh->turned_of_vertex[v] != 0) turned[static_cast<std::size_t>(r_.mesh->point_of_vertex[v])] = 1;
    return turned;
  }

  void write_points(const std::filesystem::path& path) const {
    const std::size_t n = r_.points->num_points();
    const std::vector<std::uint8_t> turned = turned_points();
    const bool any = std::find(turned.begin(), turned.end(), 1) != turned.end();
    PointColumns columns;
    PointNormals normals;
    if (r_.normals && r_.normals->normals.size() == n) {
      columns.normals = r_.normals;
      if (any) {
        normals.normals = r_.normals->normals;
        for (std::size_t i = 0; i < n; ++i)
          if (turned[i] != 0) normals.normals[i] *= -1;
        columns.normals = &normals;
      }
    }
    std::vector<ScalarField> fields;  // those with another sign
    fields.reserve(num_fields());
    for (const auto& [stage, all] : r_.scalars)
      for (const ScalarField& field : all->fields) {
        if (field.values.size() != n) continue;
        const ScalarField* shown = &field;
        if (any && field.parity == Parity::kOdd) {
          fields.push_back(field);
          for (std::size_t i = 0; i < n; ++i)
            if (turned[i] != 0) fields.back().values[i] *= -1;
          shown = &fields.back();
        }
        columns.scalars.emplace_back(name_among(stage, field.name), shown);
      }
    std::vector<std::int32_t> labels;
    if (r_.segmentation && r_.mesh) {
      labels = label_of_points(n, *r_.mesh, r_.segmentation->label_of_triangle);
      columns.labels = labels;
    }
    write_points_ply(path, *r_.points, columns);
  }

  std::size_t num_fields() const {
    std::size_t count = 0;
    for (const auto& [stage, all] : r_.scalars) count += all->fields.size();
    return count;
  }

  /// The field's name, with its stage's in front where two stages make a field of that name.
  std::string name_among(const std::string& stage, const std::string& field) const {
    const auto makers = std::count_if(r_.scalars.begin(), r_.scalars.end(),
                                      [&](const auto& s) { return s.second->find(field) != nullptr; });
    return makers > 1 ? stage + "." + field : field;
  }

  void write_regions() {
    const Eigen::Vector3d origin = r_.mesh ? r_.mesh->origin : r_.points ? r_.points->origin : Eigen::Vector3d::Zero();
    file("regions.csv", [&](const auto& path) { write_regions_csv(path, *r_.segmentation, origin); });
    file("labels.csv", [&](const auto& path) { write_labels_csv(path, *r_.segmentation); });
  }

  void write_borders() {
    file("borders.obj", [&](const auto& path) { write_borders_obj(path, *r_.mesh, r_.borders->regions); });
    file("borders.csv", [&](const auto& path) { write_borders_csv(path, *r_.mesh, r_.borders->regions); });
    file("label_borders.csv", [&](const auto& path) { write_borders_csv(path, *r_.mesh, r_.borders->labels); });
    if (p_.drawings != "none" && r_.borders->labels.num_loops() > 0) {
      const DrawingAxes axes = drawing_axes();
      file("label_borders.svg",
           [&](const auto& path) { write_borders_svg(path, *r_.mesh, r_.borders->labels, axes, context_.units()); });
      file("label_borders.dxf",
           [&](const auto& path) { write_borders_dxf(path, *r_.mesh, r_.borders->labels, axes, context_.units()); });
    }
    for (const auto& [name, curves] : {std::pair("borders_interpolated.obj", &r_.borders->interpolated),
                                       std::pair("borders_smooth.obj", &r_.borders->smooth)})
      if (curves->first_point_of_curve.size() > 1)
        file(name, [&, shown = curves](const auto& path) {
          write_curves_obj(path, r_.mesh->origin, *shown, r_.borders->regions.owner_of_loop);
        });
  }

  DrawingAxes drawing_axes() const {
    if (p_.drawings == "fit") return best_fitting_plane(*r_.mesh, r_.borders->labels);
    const View view = view_of_name(p_.drawings, *r_.mesh);
    return {view.direction.cross(view.up), view.up};
  }

  /// Mean curvature, else the first field there is; of the last stage that makes one.
  const ScalarField* shown_field() const {
    for (auto made = r_.scalars.rbegin(); made != r_.scalars.rend(); ++made) {
      if (const ScalarField* field = made->second->find("mean_curvature")) return field;
      if (!made->second->fields.empty()) return &made->second->fields.front();
    }
    return nullptr;
  }

  std::vector<double> at_vertices(const ScalarField& field) const {
    const TriangleMesh& mesh = *r_.mesh;
    std::vector<double> values(mesh.num_vertices(), std::numeric_limits<double>::quiet_NaN());
    for (std::size_t v = 0; v < values.size(); ++v) {
      const auto point = static_cast<std::size_t>(mesh.point_of_vertex[v]);
      if (point < field.values.size()) values[v] = field.values[point];
      if (field.parity == Parity::kOdd && !mesh.turned_of_vertex.empty() && mesh.turned_of_vertex[v] != 0)
        values[v] = -values[v];
    }
    return values;
  }

  void draw() {
    std::vector<Picture> pictures;
    std::vector<std::string> names;
    if (r_.segmentation) {
      pictures.push_back(
          picture_of_labels(*r_.mesh, r_.segmentation->label_of_triangle,
                            r_.borders ? BorderLines::of_loops(*r_.mesh, r_.borders->labels) : BorderLines()));
      names.emplace_back("regions.png");
    }
    std::vector<double> values;
    if (const ScalarField* field = shown_field()) {
      values = at_vertices(*field);
      pictures.push_back(
          picture_of_scalar(*r_.mesh, values, field->name, unit_for_people(field->unit, context_.units()), {}));
      names.emplace_back("curvature.png");
    } else if (r_.trees) {
      pictures.push_back(picture_of_scalar(*r_.mesh, r_.trees->values, r_.trees->scalar,
                                           unit_for_people(r_.trees->unit, context_.units()), {}));
      names.emplace_back("scalar.png");
    }
    if (pictures.empty()) {
      pictures.push_back(picture_of_shape(*r_.mesh, {}));
      names.emplace_back("mesh.png");
    }
    RenderOptions options;
    options.views = p_.views;
    options.unit = context_.units() == "unit" ? "" : context_.units();
    options.title = p_.title;
    const std::vector<Image> images = render(*r_.mesh, pictures, options, context_.execution());
    for (std::size_t i = 0; i < images.size(); ++i)
      file(names[i], [&](const auto& path) { write_png(path, images[i]); });
  }

  const ExportParameters& p_;
  const Results& r_;
  RunContext& context_;
  FileSet files_;
};

struct ExportStage {
  static constexpr StageInfo info{"export", 3,
                                  "Writes points, mesh, regions, borders and pictures as files for other programs."};
  using Parameters = ExportParameters;

  static void declare(StageSchema& schema) {
    schema.parameter(
        "points", &Parameters::points,
        "Writes points.ply: every raw point in raw order with normal, scalars, label and its own properties.");
    schema.parameter("tree", &Parameters::tree, "Writes tree.csv: every node of the level-set trees.");
    schema.parameter("pictures", &Parameters::pictures, "Draws regions.png and curvature.png.");
    schema.parameter(
        "views", &Parameters::views,
        fmt::format("Views of the pictures: {}; empty: what shows the shape.", fmt::join(view_names(), ", ")));
    schema.parameter("title", &Parameters::title, "A line above the pictures.");
    schema.parameter("drawings", &Parameters::drawings,
                     "Plane of label_borders.svg and .dxf, to scale: fit (through the borders), one of the views, or "
                     "none.");
    schema.input<PointCloud>("points", Need::kOptional);
    schema.input<PointNormals>("normals", Need::kOptional);
    schema.input<ScalarFields>("scalars", Need::kAll);
    schema.input<TriangleMesh>("mesh", Need::kOptional);
    schema.input<LevelSetTrees>("trees", Need::kOptional);
    schema.input<Segmentation>("segmentation", Need::kOptional);
    schema.input<BorderSet>("borders", Need::kOptional);
    schema.output<FileSet>("files");
  }

  static std::vector<ParameterProblem> check(const Parameters& p) {
    std::vector<ParameterProblem> problems;
    const std::vector<std::string>& known = view_names();
    for (const std::string& view : p.views)
      if (std::find(known.begin(), known.end(), view) == known.end())
        problems.emplace_back("views", fmt::format("unknown view '{}'; known are {}", view, fmt::join(known, ", ")));
    if (p.drawings != "fit" && p.drawings != "none" && std::find(known.begin(), known.end(), p.drawings) == known.end())
      problems.emplace_back(
          "drawings", fmt::format("unknown plane '{}'; known are fit, none, {}", p.drawings, fmt::join(known, ", ")));
    return problems;
  }

  static Outputs run(const Parameters& p, const Inputs& inputs, RunContext& context) {
    const Results results{inputs.find<PointCloud>("points"),   inputs.find<PointNormals>("normals"),
                          inputs.all<ScalarFields>("scalars"), inputs.find<TriangleMesh>("mesh"),
                          inputs.find<LevelSetTrees>("trees"), inputs.find<Segmentation>("segmentation"),
                          inputs.find<BorderSet>("borders")};
    FileSet files = Writer(p, results, context).write();
    if (files.names.empty())
      throw StageError("nothing to export: no earlier stage made points, a mesh or regions that are asked for");
    context.report("num_files", static_cast<std::int64_t>(files.names.size()));
    Outputs outputs;
    outputs.set("files", std::move(files));
    return outputs;
  }
};
MESHMSER_STAGE(ExportStage);

}  // namespace
}  // namespace meshmser
