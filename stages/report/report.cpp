#include "stages/report/report.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>

#include "pipeline/formats/output_file.hpp"
#include "pipeline/formats/stored_artifact.hpp"
#include "stages/common/adjacency.hpp"
#include "stages/common/colours.hpp"
#include "stages/report/block_writer.hpp"
#include "stages/report/display_mesh.hpp"
#include "stages/report/page_template.hpp"

namespace meshmser {
namespace {

using Json = nlohmann::ordered_json;

/// JSON has no infinities and no NaN: they become text.
Json number(double value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  return value;
}

Json vector3(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

/// The page says these as sentences.
const char* name_of(NodeFate::Kind kind) {
  using Kind = NodeFate::Kind;
  switch (kind) {
    case Kind::kRegion:
      return "region";
    case Kind::kRoot:
      return "root";
    case Kind::kLessStable:
      return "less_stable";
    case Kind::kSmallerOfPlateau:
      return "smaller_of_plateau";
    case Kind::kNoMaximum:
      return "no_maximum";
    case Kind::kSeveralMaxima:
      return "several_maxima";
    case Kind::kSingleMaximum:
      return "single_maximum";
    case Kind::kSmallerOfMaximum:
      return "smaller_of_maximum";
    case Kind::kNotOnBranch:
      return "not_on_branch";
    case Kind::kShortLine:
      return "short_line";
    case Kind::kOtherLevel:
      return "other_level";
    case Kind::kFalseAlarm:
      return "false_alarm";
    case Kind::kLessMeaningful:
      return "less_meaningful";
    case Kind::kFiltered:
      return "filtered";
  }
  return "other";
}

/// A region's fields under the names of regions.csv; places with the mesh's origin.
Json region_row(const Region& region, const Eigen::Vector3d& origin) {
  struct Named {
    const char *field, *column;
    bool place;  ///< of a vector: the origin is added
  };
  constexpr Named kOtherNames[] = {
      {"low_level", "level", false}, {"num_triangles", "triangles", false}, {"level_length", "border_length", false},
      {"centroid", "", true},        {"mean_normal", "n", false},           {"box_min", "min_", true},
      {"box_max", "max_", true},     {"sphere_centre", "sphere_", true},    {"cylinder_point", "cylinder_", true}};
  Json row = Json::object();
  Region::visit(region, [&]<class Value>(const char* field, const Value& value) {
    constexpr bool kVector = std::is_same_v<Value, Eigen::Vector3d>;
    Named named{field, nullptr, false};
    for (const Named& other : kOtherNames)
      if (named.column == nullptr && std::string_view(other.field) == field) named = other;
    const std::string name = named.column != nullptr ? named.column : std::string(field) + (kVector ? "_" : "");
    if constexpr (std::is_enum_v<Value>) {
      row[name] = name_of(value);
    } else if constexpr (std::is_same_v<Value, double>) {
      row[name] = number(value);
    } else if constexpr (kVector) {
      const char* axes = std::string_view(field) == "spread" ? "123" : "xyz";
      for (Eigen::Index k = 0; k < 3; ++k) row[name + axes[k]] = number(value[k] + (named.place ? origin[k] : 0));
    } else {
      row[name] = value;
    }
  });
  return row;
}

/// Positions as whole steps from the low corner, 65535 steps along the longest edge of the box.
struct Quantiser {
  Eigen::Vector3d low = Eigen::Vector3d::Zero();
  double step = 1;

  explicit Quantiser(const std::vector<Eigen::Vector3d>& positions) {
    if (positions.empty()) return;
    Eigen::Vector3d high = low = positions.front();
    for (const Eigen::Vector3d& p : positions) low = low.cwiseMin(p), high = high.cwiseMax(p);
    const double extent = (high - low).maxCoeff();
    if (extent > 0) step = extent / 65535;
  }
  void put(const Eigen::Vector3d& position, std::vector<std::uint16_t>& steps) const {
    for (Eigen::Index k = 0; k < 3; ++k)
      steps.push_back(static_cast<std::uint16_t>(std::clamp(std::round((position[k] - low[k]) / step), 0.0, 65535.0)));
  }
};

class Page {
 public:
  Page(const ReportContents& contents, const ReportOptions& options, std::size_t max_triangles,
       const Execution& execution)
      : c_(contents),
        options_(options),
        execution_(execution),
        quantiser_(contents.mesh != nullptr     ? contents.mesh->positions
                   : contents.points != nullptr ? contents.points->positions
                                                : std::vector<Eigen::Vector3d>()) {
    header_["title"] = options.title;
    header_["units"] = options.units;
    const Eigen::Vector3d origin = c_.mesh     ? c_.mesh->origin
                                   : c_.points ? c_.points->origin
                                               : Eigen::Vector3d(Eigen::Vector3d::Zero());
    header_["origin"] = vector3(origin);
    header_["low"] = vector3(quantiser_.low);
    header_["step"] = quantiser_.step;
    header_["page_format"] = kPageFormat;
    add_outputs();
    add_summary();
    if (c_.points != nullptr) add_points();
    if (c_.mesh != nullptr && c_.mesh->num_triangles() > 0) {
      display_ = display_mesh(*c_.mesh, max_triangles, execution_);
      add_mesh();
      add_scalars();
      add_rims();
      if (c_.segmentation != nullptr) add_segmentation();
      if (c_.trees != nullptr) add_trees();
      if (c_.borders != nullptr) add_borders();
    }
  }

  std::int64_t num_triangles() const { return static_cast<std::int64_t>(display_.triangles.size()); }

  std::string data() {
    header_["blocks"] = Json::array();
    for (const Block& b : writer_.blocks())
      header_["blocks"].push_back({{"name", b.name},
                                   {"coding", b.coding},
                                   {"count", b.count},
                                   {"stride", b.stride},
                                   {"offset", b.offset},
                                   {"size", b.size}});
    return "<script type=\"application/json\" id=\"header\">" +
           json_for_html(header_.dump(-1, ' ', false, Json::error_handler_t::replace)) +
           "</script>\n<script type=\"text/plain\" id=\"blocks\">" + base64(writer_.bytes()) + "</script>\n";
  }

 private:
  /// Statistics of the fields of every output, of the full data.
  void add_outputs() {
    Json& outputs = header_["outputs"] = Json::array();
    add_output(outputs, "load", "points", c_.points);
    add_output(outputs, "orient", "normals", c_.normals);
    add_output(outputs, "curvature", "smoothed points", c_.smoothed);
    for (const auto& [stage, fields] : c_.scalars)
      for (const ScalarField& field : fields->fields) {
        const ScalarFields alone{{field}};
        add_output(outputs, stage, field.name, &alone);
      }
    add_output(outputs, "mesh", "mesh", c_.mesh);
    add_output(outputs, "tree", "trees", c_.trees);
    add_output(outputs, "mser", "segmentation", c_.segmentation);
    add_output(outputs, "borders", "borders", c_.borders);
  }

  template <class T>
  static void add_output(Json& outputs, const std::string& stage, const std::string& name, const T* artifact) {
    if (artifact == nullptr) return;
    Json fields = Json::array();
    for (const FieldStatistics& field : field_statistics(Shared<T>(Shared<T>(), artifact))) {
      if (field.columns.empty()) continue;
      Json columns = Json::array();
      for (const FieldStatistics::Column& c : field.columns)
        columns.push_back({{"least", number(c.least)},
                           {"greatest", number(c.greatest)},
                           {"mean", number(c.mean)},
                           {"not_finite", c.num_not_finite},
                           {"histogram", c.histogram}});
      fields.push_back({{"name", field.name}, {"count", field.shape.front()}, {"columns", std::move(columns)}});
    }
    outputs.push_back({{"stage", stage}, {"output", name}, {"fields", std::move(fields)}});
  }

  void add_summary() {
    Json& summary = header_["summary"] = Json::object();
    if (c_.points != nullptr) {
      const PointCloud& p = *c_.points;
      summary["num_raw_points"] = p.num_raw_points;
      summary["num_points"] = p.num_points();
      summary["spacing"] = p.spacing;
      summary["scans"] = Json::array();
      for (const Scan& scan : p.scans) summary["scans"].push_back(scan.name);
    }
    if (c_.normals != nullptr) {
      std::int64_t oriented = 0, guessed = 0, guessed_points = 0;
      for (const std::int32_t component : c_.normals->component_of_point) oriented += component >= 0;
      for (const NormalComponent& component : c_.normals->components)
        if (component.source == SignSource::kGuess && !component.flipped_by_user)
          ++guessed, guessed_points += component.num_points;
      summary["num_oriented"] = oriented;
      summary["num_components"] = c_.normals->components.size();
      summary["num_guessed_components"] = guessed;
      summary["num_guessed_points"] = guessed_points;
    }
    if (c_.mesh != nullptr) {
      summary["num_vertices"] = c_.mesh->num_vertices();
      summary["num_triangles"] = c_.mesh->num_triangles();
    }
    if (c_.trees != nullptr) {
      summary["scalar"] = c_.trees->scalar;
      summary["scalar_unit"] = c_.trees->unit;
      summary["scalar_noise"] = number(c_.trees->noise);
    }
    if (c_.segmentation != nullptr) {
      summary["num_regions"] = c_.segmentation->regions.size();
      summary["num_labels"] = c_.segmentation->region_of_label.size() - 1;
    }
  }

  void add_points() {
    const std::size_t n = c_.points->num_points();
    const std::size_t every = std::max<std::size_t>(1, (n + options_.max_points - 1) / options_.max_points);
    header_["every_point"] = every;
    std::vector<std::uint16_t> raw, smoothed;
    std::vector<std::uint8_t> normals;
    for (std::size_t i = 0; i < n; i += every) {
      quantiser_.put(c_.points->positions[i], raw);
      if (c_.smoothed != nullptr && c_.smoothed->positions.size() == n)
        quantiser_.put(c_.smoothed->positions[i], smoothed);
      if (c_.normals != nullptr && c_.normals->normals.size() == n)
        for (Eigen::Index k = 0; k < 3; ++k)
          normals.push_back(static_cast<std::uint8_t>(std::lround(c_.normals->normals[i][k] * 127) + 128));
    }
    writer_.add("points", raw, 3);
    if (!smoothed.empty()) writer_.add("smoothed", smoothed, 3);
    if (!normals.empty()) writer_.add("normals", normals);
  }

  void add_mesh() {
    header_["cell"] = display_.cell;
    std::vector<std::uint16_t> positions;
    for (const std::int32_t v : display_.vertex_of_display_vertex)
      quantiser_.put(c_.mesh->positions[static_cast<std::size_t>(v)], positions);
    writer_.add("positions", positions, 3);
    std::vector<std::int32_t> corners;
    for (const auto& t : display_.triangles) corners.insert(corners.end(), t.begin(), t.end());
    writer_.add_corners("corners", corners);
  }

  /// The tree's scalar, then others, at display vertices, as 65534 steps over what 99.9 % of the values span; 65535:
  /// NaN.
  void add_scalars() {
    header_["scalars"] = Json::array();
    if (c_.trees != nullptr) add_scalar(c_.trees->scalar, "tree", c_.trees->unit, c_.trees->noise, c_.trees->values);
    const std::size_t most = display_.triangles.size() > 500000 ? 3 : 6;
    for (auto made = c_.scalars.rbegin(); made != c_.scalars.rend(); ++made)
      for (const ScalarField& field : made->second->fields) {
        if (header_["scalars"].size() >= most) return;
        std::vector<double> values(c_.mesh->num_vertices(), std::numeric_limits<double>::quiet_NaN());
        for (std::size_t v = 0; v < c_.mesh->point_of_vertex.size(); ++v) {
          const auto point = static_cast<std::size_t>(c_.mesh->point_of_vertex[v]);
          if (point < field.values.size()) values[v] = field.values[point];
          if (field.parity == Parity::kOdd && v < c_.mesh->turned_of_vertex.size() && c_.mesh->turned_of_vertex[v] != 0)
            values[v] = -values[v];
        }
        add_scalar(field.name, made->first, field.unit, field.noise, values);
      }
  }

  void add_scalar(const std::string& name, const std::string& stage, const std::string& unit, double noise,
                  const std::vector<double>& values) {
    const ColourMap map = ColourMap::of_values(values), wide = ColourMap::of_values(values, 0.0005);
    std::vector<std::uint16_t> steps;
    for (const std::int32_t v : display_.vertex_of_display_vertex) {
      const double value = values[static_cast<std::size_t>(v)];
      const double at = std::clamp((value - wide.low) / (wide.high - wide.low), 0.0, 1.0);
      steps.push_back(std::isfinite(value) ? static_cast<std::uint16_t>(std::lround(at * 65534))
                                           : std::uint16_t{65535});
    }
    Json scalar{{"name", name},     {"stage", stage},  {"unit", unit},   {"noise", number(noise)},
                {"from", wide.low}, {"to", wide.high}, {"low", map.low}, {"high", map.high}};
    constexpr int kStops = 64;
    for (int i = 0; i <= kStops; ++i) scalar["colours"].push_back(map(map.low + (map.high - map.low) * i / kStops));
    const std::string block = "scalar" + std::to_string(header_["scalars"].size());
    header_["scalars"].push_back(std::move(scalar));
    writer_.add(block, steps);
  }

  /// The mesh's own border edges.
  void add_rims() {
    const std::vector<std::int32_t> twins = twin_half_edges(c_.mesh->triangles, c_.mesh->num_vertices(), execution_);
    std::vector<std::uint16_t> steps;
    std::size_t edges = 0;
    for (std::size_t h = 0; h < twins.size(); ++h)
      if (twins[h] < 0 && ++edges <= options_.max_border_edges) {
        put_vertex(h, steps);
        put_vertex(static_cast<std::size_t>(next_half_edge(static_cast<std::int32_t>(h))), steps);
      }
    header_["num_rim_edges"] = edges;
    writer_.add("rims", steps, 6);
  }

  void put_vertex(std::size_t half_edge, std::vector<std::uint16_t>& steps) const {
    const std::int32_t v = c_.mesh->triangles[half_edge / 3][half_edge % 3];
    quantiser_.put(c_.mesh->positions[static_cast<std::size_t>(v)], steps);
  }

  template <class Value>
  std::vector<Value> of_display(const std::vector<Value>& of_triangle) const {
    std::vector<Value> values;
    values.reserve(display_.triangles.size());
    for (const std::int32_t t : display_.triangle_of_display_triangle)
      values.push_back(of_triangle[static_cast<std::size_t>(t)]);
    return values;
  }

  void add_segmentation() {
    const Segmentation& s = *c_.segmentation;
    writer_.add("labels", std::span<const std::int32_t>(of_display(s.label_of_triangle)));
    writer_.add("regions", std::span<const std::int32_t>(of_display(s.region_of_triangle)));
    header_["label_colours"] = label_colours(*c_.mesh, s.label_of_triangle);
    std::vector<std::int64_t> triangles(s.region_of_label.size(), 0);
    for (const std::int32_t label : s.label_of_triangle) ++triangles[static_cast<std::size_t>(label)];
    header_["labels"] = Json::array();
    for (std::size_t label = 1; label < s.region_of_label.size(); ++label)
      header_["labels"].push_back({{"label", label},
                                   {"region", s.region_of_label[label]},
                                   {"triangles", triangles[label]},
                                   {"area", s.area_of_label[label]}});
    header_["filters"] = Json::array();
    for (const FilterCount& f : s.filters)
      header_["filters"].push_back({{"filter", f.filter}, {"seen", f.seen}, {"removed", f.removed}});
    header_["regions"] = Json::array();
    for (std::size_t i = 0; i < s.regions.size(); ++i) {
      Json row{{"label", i + 1}};
      row.update(region_row(s.regions[i], c_.mesh->origin));
      header_["regions"].push_back(std::move(row));
    }
  }

  void add_trees() {
    header_["trees"] = Json::array();
    for (std::size_t k = 0; k < c_.trees->trees.size(); ++k) {
      const ComponentTree& tree = c_.trees->trees[k];
      const std::size_t n = tree.num_nodes();
      std::vector<float> area(n);
      for (std::size_t i = 0; i < n; ++i)
        area[i] =
            static_cast<float>(std::ldexp(static_cast<double>(tree.area_of_node[i]), -tree.area_exponent_of_node[i]));
      float least = 0;
      if (n > options_.max_nodes) {
        std::vector<float> sorted = area;
        std::nth_element(sorted.begin(), sorted.end() - static_cast<std::ptrdiff_t>(options_.max_nodes), sorted.end());
        least = *(sorted.end() - static_cast<std::ptrdiff_t>(options_.max_nodes));
      }
      // A node is at least as large as those in it: who is kept has a kept parent. Numbers stay in postorder.
      std::vector<std::int32_t> shown_node(n, -1);
      std::int32_t count = 0;
      for (std::size_t i = 0; i < n; ++i)
        if (area[i] >= least) shown_node[i] = count++;
      std::vector<std::int32_t> parents, hi;
      std::vector<float> areas;
      for (std::size_t i = 0; i < n; ++i) {
        if (area[i] < least) continue;
        const std::int32_t parent = tree.parent_of_node[i];
        parents.push_back(parent < 0 ? -1 : shown_node[static_cast<std::size_t>(parent)]);
        hi.push_back(tree.hi_of_node[i]);
        areas.push_back(area[i]);
      }
      for (std::size_t i = n; i-- > 0;)
        if (area[i] < least && tree.parent_of_node[i] >= 0)
          shown_node[i] = shown_node[static_cast<std::size_t>(tree.parent_of_node[i])];
      std::vector<std::int32_t> of_triangle = of_display(tree.node_of_triangle);
      for (std::int32_t& node : of_triangle)
        if (node >= 0) node = shown_node[static_cast<std::size_t>(node)];
      const std::string name = name_of(tree.polarity);
      writer_.add(name + "_parent", std::span<const std::int32_t>(parents));
      writer_.add(name + "_hi", std::span<const std::int32_t>(hi));
      writer_.add(name + "_area", std::span<const float>(areas));
      writer_.add(name + "_node", std::span<const std::int32_t>(of_triangle));
      Json shown{{"polarity", name}, {"num_nodes", n}, {"least_area", least}};
      // Levels of shapes count lines, which have no common value.
      shown["num_levels"] = tree.levels.size();
      if (tree.polarity == Polarity::kShapes)
        shown["num_levels"] = hi.empty() ? 1 : *std::max_element(hi.begin(), hi.end());
      else
        for (std::size_t level = 1; level <= tree.levels.size(); ++level)
          shown["levels"].push_back(number(tree.value_of_level(static_cast<std::int32_t>(level))));
      shown["node_of_region"] = Json::array();
      if (c_.segmentation != nullptr)
        for (const Region& region : c_.segmentation->regions)
          shown["node_of_region"].push_back(tree.has_side(region.polarity) && region.node >= 0
                                                ? shown_node[static_cast<std::size_t>(region.node)]
                                                : -1);
      if (c_.segmentation != nullptr && k < c_.segmentation->fates.size() &&
          c_.segmentation->fates[k].nodes.size() == n)
        add_fates(name, c_.segmentation->fates[k].nodes, area, least, shown_node, shown);
      header_["trees"].push_back(std::move(shown));
    }
  }

  /// What became of each node that is in the page; the rival, or -2 - the smallest node in the page around one that is
  /// not, or -1.
  void add_fates(const std::string& tree, const std::vector<NodeFate>& fates, const std::vector<float>& area,
                 float least, const std::vector<std::int32_t>& shown_node, Json& shown) {
    std::vector<std::uint8_t> kinds, filters;
    std::vector<std::int32_t> rivals;
    std::vector<std::string> names;
    for (std::size_t i = 0; i < fates.size(); ++i) {
      if (area[i] < least) continue;
      const NodeFate& fate = fates[i];
      const std::string name = name_of(fate.kind);
      const auto known = std::find(names.begin(), names.end(), name);
      kinds.push_back(static_cast<std::uint8_t>(known - names.begin()));
      if (known == names.end()) names.push_back(name);
      filters.push_back(static_cast<std::uint8_t>(fate.filter + 1));
      if (fate.rival < 0) {
        rivals.push_back(-1);
      } else {
        const auto rival = static_cast<std::size_t>(fate.rival);
        rivals.push_back(area[rival] < least ? -2 - shown_node[rival] : shown_node[rival]);
      }
    }
    shown["fates"] = names;
    writer_.add(tree + "_fate", kinds);
    writer_.add(tree + "_filter", filters);
    writer_.add(tree + "_rival", std::span<const std::int32_t>(rivals));
  }

  void add_borders() {
    add_loops("region_borders", c_.borders->regions);
    add_loops("label_borders", c_.borders->labels);
    const BorderCurves& curves = c_.borders->interpolated;
    if (curves.points.empty() || curves.points.size() > options_.max_border_edges) return;
    std::vector<std::uint16_t> steps;
    for (const Eigen::Vector3d& p : curves.points) quantiser_.put(p, steps);
    add_curves("interpolated", steps, curves.first_point_of_curve, c_.borders->regions.owner_of_loop, curves.kinds);
  }

  void add_loops(const std::string& name, const BorderLoops& loops) {
    header_["num_" + name] = loops.half_edges.size();
    if (loops.half_edges.size() > options_.max_border_edges) return;
    std::vector<std::uint16_t> steps;
    for (const std::int32_t h : loops.half_edges) put_vertex(static_cast<std::size_t>(h), steps);
    add_curves(name, steps, loops.first_edge_of_loop, loops.owner_of_loop, loops.kinds);
  }

  void add_curves(const std::string& name, const std::vector<std::uint16_t>& steps,
                  const std::vector<std::int64_t>& first, const std::vector<std::int32_t>& owners,
                  const std::vector<EdgeKind>& kinds) {
    std::vector<std::uint8_t> holes;
    for (const EdgeKind kind : kinds) holes.push_back(kind == EdgeKind::kHole ? 1 : 0);
    writer_.add(name, steps, 3);
    writer_.add(name + "_first", std::vector<std::int32_t>(first.begin(), first.end()));
    writer_.add(name + "_owner", std::span<const std::int32_t>(owners));
    writer_.add(name + "_hole", holes);
  }

  const ReportContents& c_;
  const ReportOptions& options_;
  const Execution& execution_;
  Quantiser quantiser_;
  DisplayMesh display_;
  Json header_;
  BlockWriter writer_;
};

}  // namespace

std::string json_for_html(std::string text) {
  std::string safe;
  safe.reserve(text.size());
  for (const char c : text)
    if (c == '<')
      safe += "\\u003c";
    else
      safe += c;
  return safe;
}

ReportSummary write_report(const std::filesystem::path& path, const ReportContents& contents,
                           const ReportOptions& options, const Execution& execution) {
  if (contents.points == nullptr && contents.mesh == nullptr)
    throw StageError("nothing to show: no earlier stage made points or a mesh");
  ReportSummary summary;
  std::string data;
  for (std::size_t most = options.max_triangles;; most = most * 2 / 3) {
    execution.report("write page", 0, 0);
    Page page(contents, options, most, execution);
    data = page.data();
    summary.num_triangles = page.num_triangles();
    if (data.size() + page_template().size() <= options.max_bytes || most < 50000) break;
  }
  OutputFile file(path);
  file.text(page_template());
  file.text(data);
  file.finish();
  summary.num_bytes = static_cast<std::int64_t>(data.size() + page_template().size());
  return summary;
}

}  // namespace meshmser
