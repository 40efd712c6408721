/// `meshmser why`: what became of every node of the trees that holds a triangle.

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include "pipeline/artifacts/scalar_fields.hpp"
#include "pipeline/stage/command.hpp"
#include "stages/common/adjacency.hpp"
#include "stages/mser/explain_triangle.hpp"
#include "stages/mser/mser_parameters.hpp"
#include "stages/mser/stability.hpp"

namespace meshmser {
namespace {

template <class T>
Shared<T> take(CommandHost& host, const CommandArguments& arguments, const std::string& what) {
  const std::string config = arguments.get("CONFIG");
  const auto* set = arguments.find("--set");
  const std::optional<Artifact> artifact =
      host.artifact(config, set ? *set : std::vector<std::string>(), artifact_index<T>());
  if (!artifact) throw UsageError(fmt::format("why: no stage of {} makes {}", config, what));
  return std::get<Shared<T>>(*artifact);
}

/// Three numbers with commas in between.
Eigen::Vector3d point_of(const std::string& text) {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  const char *at = text.data(), *end = text.data() + text.size();
  for (int k = 0; k < 3; ++k) {
    const auto [after, error] = std::from_chars(at, end, point[k]);
    const bool last = k == 2;
    if (error != std::errc() || !std::isfinite(point[k]) || (last ? after != end : after == end || *after != ','))
      throw UsageError(
          fmt::format("why: --point {}: expected three numbers x,y,z without spaces, as in 12.5,0,-3", text));
    at = last ? after : after + 1;
  }
  return point;
}

std::int32_t index_of(const std::string& option, const std::string& text, std::size_t count) {
  std::int32_t index = -1;
  const auto [after, error] = std::from_chars(text.data(), text.data() + text.size(), index);
  if (error != std::errc() || after != text.data() + text.size() || index < 0 ||
      static_cast<std::size_t>(index) >= count)
    throw UsageError(count == 0 ? fmt::format("why: {} {}: the mesh has none", option, text)
                                : fmt::format("why: {} {}: expected a whole number from 0 to {}, the last of the mesh",
                                              option, text, count - 1));
  return index;
}

/// The triangle meant, and in what words it was found.
struct Place {
  std::int32_t triangle = -1;
  std::string found;
};

Place place_of(const CommandArguments& arguments, const TriangleMesh& mesh, const LevelSetTrees& trees,
               const SurfaceView& surface) {
  const std::string point = arguments.get("--point"), vertex = arguments.get("--vertex"),
                    triangle = arguments.get("--triangle");
  if (!point.empty() + !vertex.empty() + !triangle.empty() != 1)
    throw UsageError("why: give one of --point x,y,z, --vertex N and --triangle N");
  if (!triangle.empty()) return {index_of("--triangle", triangle, mesh.num_triangles()), ""};
  if (!point.empty()) {
    const ClosestTriangle closest = closest_triangle(surface, point_of(point) - mesh.origin);
    if (closest.triangle < 0) throw UsageError("why: the mesh has no triangle");
    return {closest.triangle, fmt::format("nearest to {}, {:.4g} away", point, closest.distance)};
  }
  const std::int32_t v = index_of("--vertex", vertex, mesh.num_vertices());
  std::int32_t excluded = -1;
  for (std::size_t t = 0; t < mesh.num_triangles(); ++t) {
    const auto& corners = mesh.triangles[t];
    if (std::find(corners.begin(), corners.end(), v) == corners.end()) continue;
    const std::string found = fmt::format("the first at vertex {}", v);
    if (trees.excluded_of_triangle.empty() || trees.excluded_of_triangle[t] == 0)
      return {static_cast<std::int32_t>(t), found};
    if (excluded < 0) excluded = static_cast<std::int32_t>(t);
  }
  if (excluded < 0) throw UsageError(fmt::format("why: vertex {} has no triangle", v));
  return {excluded, fmt::format("the first at vertex {}, all of which are excluded", v)};
}

std::string number(double value) {
  return std::isfinite(value) ? fmt::format("{:.4g}", value) : value > 0 ? "inf" : "-inf";
}

/// What a filter asked of a node and what the node has.
std::string threshold(const std::string& filter, const ExplainedNode& node, const SegmentParameters& p) {
  if (filter == "min_area") return fmt::format("area {} < {}", number(node.area), number(p.min_area));
  if (filter == "max_area") return fmt::format("area {} > {}", number(node.area), number(p.max_area));
  if (filter == "max_variation") return fmt::format("q {} > {}", number(node.stability), number(p.max_variation));
  if (filter == "min_persistence")
    return fmt::format("persistence {} < {}", number(node.persistence), number(p.min_persistence));
  if (filter == "min_contrast")
    return fmt::format("contrast {}; at least {} times the noise is asked for", number(node.contrast),
                       number(p.min_contrast));
  if (filter == "keep_largest") return fmt::format("not among the {} largest", p.keep_largest);
  return "";
}

std::string words(const ExplainedNode& node, const RegionSelection& selection, const TreeSelection& known,
                  const ComponentTree& tree, const SegmentParameters& p) {
  using Kind = NodeFate::Kind;
  const NodeFate& fate = node.fate;
  const auto rival_q = [&] { return number(stability_of_node(tree, known.changes, fate.rival)); };
  const auto false_alarms = [&](std::int32_t of) {
    const double log_alarms = known.log_false_alarms[static_cast<std::size_t>(of)];
    return log_alarms > -5 ? number(std::pow(10, log_alarms)) : fmt::format("1e{:.0f}", log_alarms);
  };
  switch (fate.kind) {
    case Kind::kRegion:
      return fmt::format("REGION {}", node.region);
    case Kind::kRoot:
      return "a root: it has no level border";
    case Kind::kLessStable:
      return fmt::format("not selected: node {} has a lower q, {}", fate.rival, rival_q());
    case Kind::kSmallerOfPlateau:
      return fmt::format("not selected: node {} is larger, of the same q", fate.rival);
    case Kind::kNoMaximum:
      return fmt::format("not selected: no maximum in it lasts longer than {} in a part of at least {}",
                         number(p.min_persistence), number(p.min_area));
    case Kind::kSeveralMaxima:
      return "not selected: several significant maxima";
    case Kind::kSingleMaximum:
      return "not selected: no other significant maximum to be told from";
    case Kind::kSmallerOfMaximum:
      return fmt::format("not selected: node {} is larger, with the same significant maximum", fate.rival);
    case Kind::kNotOnBranch:
      return fmt::format("not selected: node {} on the way to the same maximum has q {}", fate.rival, rival_q());
    case Kind::kShortLine:
      return fmt::format("not selected: its level line is shorter than {}", number(p.min_length));
    case Kind::kOtherLevel:
      return fmt::format("not selected: it does not belong to the level at {}", number(p.level));
    case Kind::kFalseAlarm:
      return fmt::format("not selected: {} lines like its own are expected by chance", false_alarms(node.node));
    case Kind::kLessMeaningful:
      return fmt::format("not selected: node {}, in the same chain, has fewer false alarms: {} instead of {}",
                         fate.rival, false_alarms(fate.rival), false_alarms(node.node));
    case Kind::kFiltered:
      break;
  }
  const std::string& filter = selection.filters.at(static_cast<std::size_t>(fate.filter)).filter;
  const std::string detail =
      fate.rival >= 0 ? fmt::format("for node {}, q {}", fate.rival, rival_q()) : threshold(filter, node, p);
  return fmt::format("removed by {}: {}", filter, detail);
}

/// What became of the triangle after the regions were found.
std::string label_words(const Segmentation& segmentation, std::int32_t region, std::int32_t label) {
  if (label <= 0)
    return region > 0 ? "background: its patch is the whole surface around it, or was joined to the background"
                      : "background";
  const std::int32_t from = segmentation.region_of_label[static_cast<std::size_t>(label)];
  if (from == region) return fmt::format("label {}", label);
  return fmt::format("label {} of region {}, {}", label, from,
                     region > 0 ? "which its own patch was joined to" : "which flooded it or closed over it");
}

void print_path(const LevelSetTrees& trees, const RegionSelection& selection, const std::vector<NodeFates>& fates,
                std::size_t tree_index, std::int32_t triangle, const SegmentParameters& parameters) {
  const ComponentTree& tree = trees.trees[tree_index];
  const bool upper = tree.polarity == Polarity::kUpper, shapes = tree.polarity == Polarity::kShapes;
  const std::vector<ExplainedNode> path = explain_triangle(trees, selection, fates, tree_index, triangle);
  fmt::print("\n{}, {} nodes from the triangle's own to the root\n",
             shapes ? "tree of shapes" : fmt::format("{} tree", name_of(tree.polarity)), path.size());
  if (path.empty()) {
    fmt::print("  none: the triangle is {} the first level\n", upper ? "below" : "above");
    return;
  }
  fmt::print("{:>10}  {:>11}  {:>11}  {:>11}  {:>9}  {:>11}  {}\n", "node", "levels",
             shapes  ? "S"
             : upper ? "S from"
                     : "S to",
             "area", "q", "persistence", "fate");
  const auto value_of = [&](const ExplainedNode& node) {
    if (!shapes || !std::isfinite(node.value)) return number(node.value);
    return fmt::format("{} {}", node.side == Polarity::kUpper ? ">=" : "<", number(node.value));
  };
  const auto print_nodes = [&](const std::vector<ExplainedNode>& nodes) {
    for (const ExplainedNode& node : nodes)
      fmt::print("{:>10}  {:>11}  {:>11}  {:>11}  {:>9}  {:>11}  {}\n", node.node,
                 node.lo == node.hi ? fmt::format("{}", node.lo) : fmt::format("{}-{}", node.lo, node.hi),
                 value_of(node), number(node.area), number(node.stability), number(node.persistence),
                 words(node, selection, selection.selections[tree_index], tree, parameters));
  };
  print_nodes(path);
  const std::vector<ExplainedNode> rivals = explain_rivals(trees, selection, fates, tree_index, path);
  if (rivals.empty()) return;
  fmt::print("  and of the nodes named that do not hold it:\n");
  print_nodes(rivals);
}

int run_why(const CommandArguments& arguments, CommandHost& host) {
  const std::string config = arguments.get("CONFIG");
  const auto* set = arguments.find("--set");
  const auto given = std::static_pointer_cast<const MserParameters>(
      host.parameters(config, set ? *set : std::vector<std::string>(), "mser"));
  if (given == nullptr) throw UsageError(fmt::format("why: {} has no stage mser; add it", config));
  const auto mesh = take<TriangleMesh>(host, arguments, "a mesh");
  const auto trees = take<LevelSetTrees>(host, arguments, "a tree");
  const auto segmentation = take<Segmentation>(host, arguments, "labels");

  const Execution& execution = host.execution();
  std::vector<std::int32_t> twins = twin_half_edges(mesh->triangles, mesh->num_vertices(), execution);
  if (!trees->excluded_of_triangle.empty()) cut_out_triangles(twins, trees->excluded_of_triangle);
  const SurfaceView surface{mesh->positions, mesh->triangles, twins};
  const Place place = place_of(arguments, *mesh, *trees, surface);
  const auto t = static_cast<std::size_t>(place.triangle);

  const auto& corners = mesh->triangles[t];
  Eigen::Vector3d centroid = mesh->origin;
  for (const std::int32_t v : corners) centroid += mesh->positions[static_cast<std::size_t>(v)] / 3;
  fmt::print("triangle {}{}\n", t, place.found.empty() ? "" : ", " + place.found);
  fmt::print("  vertices {} {} {}, centroid {:.6g},{:.6g},{:.6g}\n", corners[0], corners[1], corners[2], centroid.x(),
             centroid.y(), centroid.z());
  const auto value = [&](std::size_t k) { return number(trees->values[static_cast<std::size_t>(corners[k])]); };
  fmt::print("  {} {}, {}, {}{}\n", trees->scalar, value(0), value(1), value(2),
             trees->unit.empty() ? "" : " " + unit_for_people(trees->unit, host.units(config)));
  const std::int32_t region = segmentation->region_of_triangle.at(t), label = segmentation->label_of_triangle.at(t);
  fmt::print("  {}; {}\n", region > 0 ? fmt::format("region {}", region) : "in no region",
             label_words(*segmentation, region, label));
  if (!trees->excluded_of_triangle.empty() && trees->excluded_of_triangle[t] != 0) {
    fmt::print("  excluded by the tree stage (near a rim, or without a value): it is in no tree\n");
    return static_cast<int>(ExitCode::kOk);
  }

  SegmentParameters parameters = resolve(*given, *mesh, *trees, execution);
  // Growth and merging come after the regions and are not asked about; what they need is not at hand here.
  parameters.grow = Grow::kNone;
  parameters.merge = Merge::kNone;
  std::vector<NodeFates> fates;
  const RegionSelection selection =
      select_regions({surface, *trees, {}, {}, mesh->normals}, parameters, &fates, execution);
  for (std::size_t i = 0; i < trees->trees.size(); ++i)
    print_path(*trees, selection, fates, i, place.triangle, parameters);
  return static_cast<int>(ExitCode::kOk);
}

CommandDefinition definition() {
  return {"why",
          "Tells for a place on the mesh which nodes of the trees hold it, and why each is a region or is none.",
          {{"CONFIG", "a configuration (.yaml) with the stages tree and mser", true},
           {"--point", "x,y,z in the coordinates of the scan: the nearest triangle"},
           {"--vertex", "number of a vertex of the mesh, from 0: its first triangle"},
           {"--triangle", "number of a triangle of the mesh, from 0"},
           set_option(),
           cache_option()},
          run_why,
          "meshmser why configs/demo.yaml --point 10,5,0"};
}

MESHMSER_COMMAND(why, definition());

}  // namespace
}  // namespace meshmser
