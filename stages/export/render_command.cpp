/// `meshmser render`: pictures of a mesh file, or of what a configuration makes.

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>

#include "pipeline/artifacts/scalar_fields.hpp"
#include "pipeline/formats/geometry_file.hpp"
#include "pipeline/stage/command.hpp"
#include "stages/export/render.hpp"

namespace meshmser {
namespace {

template <class T>
Shared<T> take(CommandHost& host, const std::string& config, const std::vector<std::string>& set) {
  const std::optional<Artifact> artifact = host.artifact(config, set, artifact_index<T>());
  return artifact ? std::get<Shared<T>>(*artifact) : nullptr;
}

double number_of(const CommandArguments& arguments, const std::string& option, double otherwise) {
  const std::string text = arguments.get(option);
  if (text.empty()) return otherwise;
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    throw UsageError(fmt::format("render: {} {}: expected a number", option, text));
  return value;
}

/// `1200x900`, pixels a view.
void set_size(const std::string& text, RenderOptions& options) {
  const std::size_t cross = text.find('x');
  int width = 0, height = 0;
  const char* end = text.data() + text.size();
  const bool good = cross != std::string::npos &&
                    std::from_chars(text.data(), text.data() + cross, width).ptr == text.data() + cross &&
                    std::from_chars(text.data() + cross + 1, end, height).ptr == end;
  if (!good || width < 1 || height < 1 || width > 8192 || height > 8192)
    throw UsageError(
        fmt::format("render: --size {}: expected WIDTHxHEIGHT in pixels, at most 8192 each, as in 1200x900", text));
  options.panel_width = width;
  options.panel_height = height;
}

const Property* find_property(const std::vector<Property>& properties, const std::string& name) {
  for (const Property& property : properties)
    if (property.name == name) return &property;
  return nullptr;
}

/// The faces of a file as they are; polygons are cut in fans.
TriangleMesh read_mesh(const std::filesystem::path& path) {
  const Geometry geometry = read_geometry_file(path).front();
  if (geometry.num_faces() == 0)
    throw InputError(path.string() +
                     ": no faces, only points; give a mesh, or a configuration that makes one of the points");
  TriangleMesh mesh;
  mesh.positions = geometry.positions;
  mesh.properties = geometry.properties;
  for (std::size_t face = 0; face < geometry.num_faces(); ++face) {
    const auto first = static_cast<std::size_t>(geometry.first_corner_of_face[face]);
    const auto end = static_cast<std::size_t>(geometry.first_corner_of_face[face + 1]);
    for (std::size_t corner = first + 2; corner < end; ++corner)
      mesh.triangles.push_back({geometry.corners[first], geometry.corners[corner - 1], geometry.corners[corner]});
  }
  const Property *x = find_property(mesh.properties, "nx"), *y = find_property(mesh.properties, "ny"),
                 *z = find_property(mesh.properties, "nz");
  if (x != nullptr && y != nullptr && z != nullptr)
    for (std::size_t v = 0; v < mesh.num_vertices(); ++v)
      mesh.normals.emplace_back(x->values[v], y->values[v], z->values[v]);
  return mesh;
}

Image picture_of_file(const std::filesystem::path& path, const std::string& show, const RenderOptions& options,
                      const Execution& execution) {
  const TriangleMesh mesh = read_mesh(path);
  if (show.empty() || show == "shape") return render_shape(mesh, {}, options, execution);
  if (const Property* property = find_property(mesh.properties, show))
    return render_scalar(mesh, property->values, show, "", {}, {}, options, execution);
  std::vector<std::string> names = {"shape"};
  for (const Property& property : mesh.properties) names.push_back(property.name);
  throw UsageError(fmt::format("render: {} has no vertex property '{}'; --show knows: {}", path.string(), show,
                               fmt::join(names, ", ")));
}

/// A scalar of the points, at the mesh's vertices; turned where the mesh turned the normal.
std::vector<double> values_at_vertices(const ScalarField& field, const TriangleMesh& mesh) {
  std::vector<double> values(mesh.num_vertices(), std::nan(""));
  for (std::size_t v = 0; v < std::min(values.size(), mesh.point_of_vertex.size()); ++v) {
    values[v] = field.values[static_cast<std::size_t>(mesh.point_of_vertex[v])];
    if (field.parity == Parity::kOdd && v < mesh.turned_of_vertex.size() && mesh.turned_of_vertex[v])
      values[v] = -values[v];
  }
  return values;
}

Image picture_of_config(const std::string& config, const std::vector<std::string>& set, std::string show,
                        const RenderOptions& options, CommandHost& host) {
  const Shared<TriangleMesh> mesh = take<TriangleMesh>(host, config, set);
  if (mesh == nullptr)
    throw UsageError(
        fmt::format("render: no stage of {} makes a mesh; add the stage 'mesh', or load a file with faces", config));
  const Execution& execution = host.execution();
  if (show == "shape") return render_shape(*mesh, {}, options, execution);
  if (show.empty() || show == "labels" || show == "regions") {
    if (const auto segmentation = take<Segmentation>(host, config, set)) {
      const auto borders = take<BorderSet>(host, config, set);
      const bool regions = show == "regions";
      BorderLines lines;
      if (borders) lines = BorderLines::of_loops(*mesh, regions ? borders->regions : borders->labels);
      return render_labels(*mesh, regions ? segmentation->region_of_triangle : segmentation->label_of_triangle, lines,
                           options, execution);
    }
    if (!show.empty())
      throw UsageError(fmt::format("render: no stage of {} makes {}; add the stages 'tree' and 'mser'", config, show));
  }
  if (show.empty() || show == "scalar") {
    if (const auto trees = take<LevelSetTrees>(host, config, set))
      return render_scalar(*mesh, trees->values, trees->scalar, unit_for_people(trees->unit, options.unit), {}, {},
                           options, execution);
    if (show == "scalar")
      throw UsageError(
          fmt::format("render: no stage of {} makes a tree; add it, or name a scalar with --show", config));
  }
  std::vector<std::string> names = {"labels", "regions", "scalar", "shape"};
  if (const Property* property = find_property(mesh->properties, show))
    return render_scalar(*mesh, property->values, show, "", {}, {}, options, execution);
  for (const Property& property : mesh->properties) names.push_back(property.name);
  if (const auto fields = take<ScalarFields>(host, config, set)) {
    for (const ScalarField& field : fields->fields) {
      names.push_back(field.name);
      if (field.name == (show.empty() ? "mean_curvature" : show))
        return render_scalar(*mesh, values_at_vertices(field, *mesh), field.name,
                             unit_for_people(field.unit, options.unit), {}, {}, options, execution);
    }
  }
  if (show.empty()) return render_shape(*mesh, {}, options, execution);
  throw UsageError(fmt::format("render: {} makes no '{}'; --show knows: {}", config, show, fmt::join(names, ", ")));
}

int run_render(const CommandArguments& arguments, CommandHost& host) {
  const std::string input = arguments.get("MESH"), output = arguments.get("OUT.png");
  const std::string extension = std::filesystem::path(input).extension().string();
  const bool is_config = extension == ".yaml" || extension == ".yml";
  RenderOptions options;
  if (const auto* views = arguments.find("--view")) options.views = *views;
  for (const std::string& view : options.views) check_view_name(view);
  if (!arguments.get("--size").empty()) set_size(arguments.get("--size"), options);
  options.light_azimuth = number_of(arguments, "--light", options.light_azimuth);
  options.light_elevation = number_of(arguments, "--light-elevation", options.light_elevation);
  options.unit = arguments.get("--unit", is_config ? host.units(input) : "");
  if (options.unit == "unit") options.unit.clear();
  options.title = arguments.get("--title", std::filesystem::path(input).filename().string());
  const std::vector<std::string>* set = arguments.find("--set");
  if (set != nullptr && !is_config)
    throw UsageError("render: --set is for configurations; " + input + " is a mesh file");
  const Image image = is_config ? picture_of_config(input, set != nullptr ? *set : std::vector<std::string>(),
                                                    arguments.get("--show"), options, host)
                                : picture_of_file(input, arguments.get("--show"), options, host.execution());
  write_png(output, image);
  fmt::print("{}\n", output);
  return static_cast<int>(ExitCode::kOk);
}

CommandDefinition definition() {
  return {"render",
          "Draws a mesh file, or the mesh, labels and borders that a configuration makes, as PNG.",
          {{"MESH", "a mesh file, or a configuration (.yaml)", true},
           {"OUT.png", "the picture to write", true},
           {"--view",
            fmt::format("{} (best without: what shows the shape); may be repeated", fmt::join(view_names(), ", ")),
            false, true},
           {"--show", "labels, regions, scalar, shape, or a scalar or vertex property by name"},
           {"--size", "WIDTHxHEIGHT of each view in pixels (900x700)"},
           {"--light", "degrees from which the raking light comes, counter-clockwise from the right (135)"},
           {"--light-elevation", "degrees of the raking light above the picture's plane (28)"},
           {"--unit", "unit at the scale bar (of a configuration: its own)"},
           {"--title", "line above the views (the file's name)"},
           set_option(),
           cache_option()},
          run_render,
          "meshmser render configs/demo.yaml --view best demo.png"};
}

MESHMSER_COMMAND(render, definition());

}  // namespace
}  // namespace meshmser
