/// `meshmser tree`, `cut`, `reconstruct`: a tree as a file for other programs, its components at a level, its scalar;
/// each of the tree as it is or simplified.

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "pipeline/artifacts/scalar_fields.hpp"
#include "pipeline/formats/output_file.hpp"
#include "pipeline/formats/ply.hpp"
#include "pipeline/stage/command.hpp"
#include "stages/common/tree_nodes.hpp"
#include "stages/tree/edit_tree.hpp"

namespace meshmser {
namespace {

template <class T>
Shared<T> take(CommandHost& host, const CommandArguments& arguments, const char* command, const char* what) {
  const std::string config = arguments.get("CONFIG");
  const auto* set = arguments.find("--set");
  const std::optional<Artifact> artifact =
      host.artifact(config, set ? *set : std::vector<std::string>(), artifact_index<T>());
  if (!artifact) throw UsageError(fmt::format("{}: no stage of {} makes {}", command, config, what));
  return std::get<Shared<T>>(*artifact);
}

double number_of(const CommandArguments& arguments, const char* command, const std::string& option, double least) {
  const std::string text = arguments.get(option);
  double value = 0;
  const auto [after, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || after != text.data() + text.size() || !std::isfinite(value) || value < least)
    throw UsageError(fmt::format("{}: {} {}: expected a number{}", command, option, text,
                                 std::isfinite(least) ? fmt::format(", at least {}", least) : ""));
  return value;
}

std::string out_path(const CommandArguments& arguments, const char* command, const std::string& ending) {
  std::string path = arguments.get("OUT");
  if (!path.ends_with(ending))
    throw UsageError(fmt::format("{}: {}: the name of what is written must end in {}", command, path, ending));
  return path;
}

/// The tree asked for, simplified as asked for.
ComponentTree wanted_tree(const LevelSetTrees& trees, const CommandArguments& arguments, const char* command) {
  const std::string polarity = arguments.get("--polarity");
  const auto found = std::find_if(trees.trees.begin(), trees.trees.end(), [&](const ComponentTree& tree) {
    return polarity.empty() || polarity == name_of(tree.polarity);
  });
  if (found == trees.trees.end())
    throw UsageError(fmt::format("{}: the configuration makes no {}; see tree.polarity", command,
                                 polarity == "shapes" ? "tree of shapes" : polarity + " tree"));
  ComponentTree tree = *found;
  if (arguments.find("--min-area"))
    tree = simplify_tree(tree, nodes_of_area(tree, number_of(arguments, command, "--min-area", 0)));
  if (arguments.find("--min-persistence"))
    tree = simplify_tree(tree, nodes_of_persistence(tree, number_of(arguments, command, "--min-persistence", 0)));
  return tree;
}

class JsonFile {
 public:
  explicit JsonFile(const std::string& path) : file_(path) { file_.text("{"); }
  void text(const std::string& key, const std::string& value) {
    begin(key);
    file_.text(nlohmann::json(value).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  }
  void number(const std::string& key, std::int64_t value) {
    begin(key);
    file_.number(value);
  }
  template <class Value>
  void list(const std::string& key, std::size_t count, Value value_of) {
    begin(key);
    file_.text("[");
    for (std::size_t i = 0; i < count; ++i) {
      if (i > 0) file_.text(i % 32 == 0 ? ",\n" : ",");
      const auto value = value_of(i);
      if constexpr (std::is_integral_v<decltype(value)>)
        file_.number(std::int64_t{value});
      else if (std::isfinite(value))
        file_.number(double{value});
      else
        file_.text("null");
    }
    file_.text("]");
  }
  void finish() {
    file_.text("\n}\n");
    file_.finish();
  }

 private:
  void begin(const std::string& key) {
    file_.text(std::exchange(first_, false) ? "\n\"" : ",\n\"");
    file_.text(key);
    file_.text("\": ");
  }
  OutputFile file_;
  bool first_ = true;
};

int run_tree(const CommandArguments& arguments, CommandHost& host) {
  const std::string path = out_path(arguments, "tree", ".json");
  const auto trees = take<LevelSetTrees>(host, arguments, "tree", "a tree");
  const ComponentTree tree = wanted_tree(*trees, arguments, "tree");
  JsonFile file(path);
  file.text("format", "meshmser tree");
  file.number("version", 1);
  file.text("polarity", name_of(tree.polarity));
  file.text("scalar", trees->scalar);
  file.text("unit", unit_for_people(trees->unit, host.units(arguments.get("CONFIG"))));
  file.list("levels", tree.levels.size(),
            [&](std::size_t k) { return tree.value_of_level(static_cast<std::int32_t>(k) + 1); });
  file.list("parent", tree.num_nodes(), [&](std::size_t n) { return tree.parent_of_node[n]; });
  file.list("level", tree.num_nodes(), [&](std::size_t n) { return tree.hi_of_node[n]; });
  file.list("area", tree.num_nodes(), [&](std::size_t n) { return area_of_node(tree, static_cast<std::int32_t>(n)); });
  file.list("node_of_triangle", tree.node_of_triangle.size(), [&](std::size_t t) { return tree.node_of_triangle[t]; });
  if (tree.polarity == Polarity::kShapes) {
    const auto node = [](std::size_t n) { return static_cast<std::int32_t>(n); };
    file.list("value", tree.num_nodes(), [&](std::size_t n) { return tree.value(node(n)); });
    file.list("sign", tree.num_nodes(), [&](std::size_t n) { return static_cast<int>(tree.sign(node(n))); });
  }
  file.finish();
  fmt::print("{} nodes of the {}: {}\n", tree.num_nodes(),
             tree.polarity == Polarity::kShapes ? "tree of shapes" : fmt::format("{} tree", name_of(tree.polarity)),
             path);
  return static_cast<int>(ExitCode::kOk);
}

/// The mesh as a PLY file with one value a vertex (or none) and one a face.
void write_mesh(const std::string& path, const TriangleMesh& mesh, const std::vector<double>* of_vertex,
                const PlyPropertySpec& face_property, const auto& value_of_triangle) {
  std::vector<PlyPropertySpec> columns = {{"x"}, {"y"}, {"z"}};
  if (of_vertex != nullptr) columns.push_back({"quality"});
  PlyWriter writer(path, static_cast<std::int64_t>(mesh.num_vertices()), columns,
                   static_cast<std::int64_t>(mesh.num_triangles()), {face_property});
  for (std::size_t v = 0; v < mesh.num_vertices(); ++v) {
    const Eigen::Vector3d place = mesh.positions[v] + mesh.origin;
    std::vector<double> row = {place.x(), place.y(), place.z()};
    if (of_vertex != nullptr) row.push_back((*of_vertex)[v]);
    writer.add_vertex(row);
  }
  for (std::size_t t = 0; t < mesh.num_triangles(); ++t) {
    const auto value = static_cast<double>(value_of_triangle[t]);
    writer.add_triangle(mesh.triangles[t], {&value, 1});
  }
  writer.finish();
}

int run_cut(const CommandArguments& arguments, CommandHost& host) {
  const std::string path = out_path(arguments, "cut", ".ply");
  const double value = number_of(arguments, "cut", "--at", -std::numeric_limits<double>::infinity());
  const auto trees = take<LevelSetTrees>(host, arguments, "cut", "a tree");
  const auto mesh = take<TriangleMesh>(host, arguments, "cut", "a mesh");
  const ComponentTree tree = wanted_tree(*trees, arguments, "cut");
  const std::int32_t level = level_of_value(tree, value);
  if (level == 0)
    throw UsageError(fmt::format("cut: --at {}: every level is {} it", arguments.get("--at"),
                                 tree.polarity == Polarity::kLower ? "below" : "above"));
  const TreeCut cut = cut_tree(tree, level);
  write_mesh(path, *mesh, nullptr, {"component", ValueType::kInt32}, cut.component_of_triangle);
  fmt::print(stderr, "level {} of {}, {:.9g}\n", level, tree.levels.size(), tree.value_of_level(level));
  fmt::print("component  area\n");
  for (std::size_t i = 0; i < cut.nodes.size(); ++i)
    fmt::print("{:>9}  {:.6g}\n", i + 1, area_of_node(tree, cut.nodes[i]));
  return static_cast<int>(ExitCode::kOk);
}

int run_reconstruct(const CommandArguments& arguments, CommandHost& host) {
  const std::string path = out_path(arguments, "reconstruct", ".ply");
  const auto trees = take<LevelSetTrees>(host, arguments, "reconstruct", "a tree");
  const auto mesh = take<TriangleMesh>(host, arguments, "reconstruct", "a mesh");
  const ComponentTree tree = wanted_tree(*trees, arguments, "reconstruct");
  const std::vector<double> of_triangle = reconstruct_triangle_values(tree);
  const std::vector<double> of_vertex =
      reconstruct_vertex_values(tree, of_triangle, mesh->triangles, mesh->num_vertices());
  write_mesh(path, *mesh, &of_vertex, {"quality"}, of_triangle);
  fmt::print("{} of {} nodes kept: {}\n", tree.num_nodes(),
             std::find_if(trees->trees.begin(), trees->trees.end(),
                          [&](const ComponentTree& of) { return of.polarity == tree.polarity; })
                 ->num_nodes(),
             path);
  return static_cast<int>(ExitCode::kOk);
}

CommandDefinition with_tree_options(CommandDefinition command) {
  const std::vector<CommandOption> more = {
      {.name = "--polarity", .description = "which tree; without: the first", .choices = {"upper", "lower", "shapes"}},
      {"--min-area", "razes every component smaller than this, in coordinate units squared, first"},
      {"--min-persistence", "removes every maximum that lasts less than this, in units of the scalar, first"},
      set_option(),
      cache_option()};
  command.options.insert(command.options.end(), more.begin(), more.end());
  return command;
}

const CommandOption kConfig{"CONFIG", "a configuration (.yaml) with the stage tree", true};

MESHMSER_COMMAND(tree, with_tree_options({"tree",
                                          "Writes a tree of the level sets as JSON: parents, levels, areas, triangles.",
                                          {kConfig, {"OUT", "the file, .json", true}},
                                          run_tree,
                                          "meshmser tree configs/mesh.yaml tree.json --min-area 0.5"}));
MESHMSER_COMMAND(
    cut,
    with_tree_options(
        {"cut",
         "Writes the mesh with the components of one level set, numbered by area.",
         {kConfig,
          {"OUT", "the file, .ply, with `component` of each face", true},
          {"--at", "value of the scalar; the level at or next below it is taken, of a lower tree at or next above it",
           true}},
         run_cut,
         "meshmser cut configs/mesh.yaml components.ply --at 0.5"}));
MESHMSER_COMMAND(reconstruct,
                 with_tree_options({"reconstruct",
                                    "Writes the mesh with the scalar as the tree has it, simplified where asked for.",
                                    {kConfig, {"OUT", "the file, .ply, with `quality` of each vertex and face", true}},
                                    run_reconstruct,
                                    "meshmser reconstruct configs/mesh.yaml smooth.ply --min-persistence 0.2"}));

}  // namespace
}  // namespace meshmser
