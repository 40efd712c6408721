#include <algorithm>
#include <limits>

#include "pipeline/formats/ply.hpp"
#include "stages/common/colours.hpp"
#include "stages/export/export_files.hpp"

namespace meshmser {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Floats where every coordinate is one.
ValueType coordinate_type(const Eigen::Vector3d& origin,
                          std::initializer_list<const std::vector<Eigen::Vector3d>*> parts) {
  for (const auto* positions : parts)
    for (const Eigen::Vector3d& p : *positions)
      for (int axis = 0; axis < 3; ++axis) {
        const double c = p[axis] + origin[axis];
        if (c == c && static_cast<double>(static_cast<float>(c)) != c) return ValueType::kFloat64;
      }
  return ValueType::kFloat32;
}

void add_names(std::vector<PlyPropertySpec>& specs, std::initializer_list<const char*> names, ValueType type) {
  for (const char* name : names) specs.push_back({name, type});
}

bool has_name(const std::vector<PlyPropertySpec>& specs, const std::string& name) {
  return std::any_of(specs.begin(), specs.end(), [&](const PlyPropertySpec& spec) { return spec.name == name; });
}

/// A name that a PLY header can hold and that is not yet taken.
std::string free_name(const std::vector<PlyPropertySpec>& specs, std::string name) {
  for (char& c : name)
    if (static_cast<unsigned char>(c) <= ' ') c = '_';
  while (has_name(specs, name)) name = "file_" + name;
  return name;
}

}  // namespace

void write_points_ply(const std::filesystem::path& path, const PointCloud& points, const PointColumns& columns) {
  const ValueType coordinates = coordinate_type(points.origin, {&points.positions, &points.dropped_positions});
  std::vector<PlyPropertySpec> specs;
  add_names(specs, {"x", "y", "z"}, coordinates);
  if (columns.normals != nullptr) add_names(specs, {"nx", "ny", "nz"}, ValueType::kFloat32);
  for (const auto& [name, field] : columns.scalars) specs.push_back({free_name(specs, name), ValueType::kFloat32});
  if (!columns.labels.empty()) specs.push_back({"label", ValueType::kInt32});
  for (const Property& property : points.properties) specs.push_back({free_name(specs, property.name), property.type});

  // For each raw point its point, or -1 - its place among the dropped.
  std::vector<std::int32_t> point_of_raw(static_cast<std::size_t>(points.num_raw_points));
  for (std::size_t p = 0; p < points.num_points(); ++p)
    point_of_raw[static_cast<std::size_t>(points.raw_index_of_point[p])] = static_cast<std::int32_t>(p);
  for (std::size_t d = 0; d < points.dropped_raw_index.size(); ++d)
    point_of_raw[static_cast<std::size_t>(points.dropped_raw_index[d])] = -1 - static_cast<std::int32_t>(d);

  PlyWriter writer(path, points.num_raw_points, specs);
  std::vector<double> row;
  row.reserve(specs.size());
  for (const std::int32_t entry : point_of_raw) {
    row.clear();
    const bool dropped = entry < 0;
    const auto place = static_cast<std::size_t>(dropped ? -1 - entry : entry);
    const Eigen::Vector3d position =
        (dropped ? points.dropped_positions[place] : points.positions[place]) + points.origin;
    const std::int32_t point = dropped ? points.kept_point_of_dropped[place] : entry;
    const auto p = static_cast<std::size_t>(std::max(point, 0));
    row.insert(row.end(), {position.x(), position.y(), position.z()});
    if (columns.normals != nullptr)
      for (int axis = 0; axis < 3; ++axis) row.push_back(point < 0 ? kNan : columns.normals->normals[p][axis]);
    for (const auto& [name, field] : columns.scalars) row.push_back(point < 0 ? kNan : field->values[p]);
    if (!columns.labels.empty()) row.push_back(point < 0 ? -1 : columns.labels[p]);
    for (const Property& property : points.properties) row.push_back(point < 0 ? kNan : property.values[p]);
    writer.add_vertex(row);
  }
  writer.finish();
}

void write_segments_ply(const std::filesystem::path& path, const TriangleMesh& mesh, const SegmentColumns& columns) {
  const bool has_labels = !columns.labels.empty(), has_quality = !columns.quality.empty();
  std::vector<PlyPropertySpec> vertex, face;
  add_names(vertex, {"x", "y", "z"}, coordinate_type(mesh.origin, {&mesh.positions}));
  add_names(vertex, {"nx", "ny", "nz"}, ValueType::kFloat32);
  if (has_labels) add_names(vertex, {"red", "green", "blue"}, ValueType::kUint8);
  if (has_quality) vertex.push_back({"quality", ValueType::kFloat32});
  if (has_labels) {
    face.push_back({"label", ValueType::kInt32});
    add_names(face, {"red", "green", "blue"}, ValueType::kUint8);
  }
  std::vector<Colour> colours;
  std::vector<std::int32_t> labels;
  if (has_labels) {
    colours = label_colours(mesh, columns.labels);
    labels = label_of_vertices(mesh, columns.labels);
  }
  PlyWriter writer(path, static_cast<std::int64_t>(mesh.num_vertices()), vertex,
                   static_cast<std::int64_t>(mesh.num_triangles()), face);
  std::vector<double> row;
  for (std::size_t v = 0; v < mesh.num_vertices(); ++v) {
    const Eigen::Vector3d position = mesh.positions[v] + mesh.origin;
    row.assign(
        {position.x(), position.y(), position.z(), mesh.normals[v].x(), mesh.normals[v].y(), mesh.normals[v].z()});
    if (has_labels)
      for (const std::uint8_t part : colours[static_cast<std::size_t>(std::max(labels[v], 0))]) row.push_back(part);
    if (has_quality) row.push_back(columns.quality[v]);
    writer.add_vertex(row);
  }
  for (std::size_t t = 0; t < mesh.num_triangles(); ++t) {
    row.clear();
    if (has_labels) {
      row.push_back(columns.labels[t]);
      for (const std::uint8_t part : colours[static_cast<std::size_t>(columns.labels[t])]) row.push_back(part);
    }
    writer.add_triangle(mesh.triangles[t], row);
  }
  writer.finish();
}

}  // namespace meshmser
