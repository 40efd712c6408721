#include "stages/tree/vertex_scalar.hpp"

#include <algorithm>

#include "pipeline/execution/error.hpp"

namespace meshmser {
namespace {

/// Values over points, read at the vertices' points.
std::vector<double> at_vertices(const std::string& name, const std::vector<double>& of_point, Parity parity,
                                const TriangleMesh& mesh) {
  std::vector<double> values(mesh.num_vertices());
  if (mesh.point_of_vertex.size() != mesh.num_vertices())
    throw StageError("the scalar '" + name + "' is over points, but the mesh does not say which point each vertex is");
  for (std::size_t v = 0; v < values.size(); ++v) {
    const auto point = static_cast<std::size_t>(mesh.point_of_vertex[v]);
    if (point >= of_point.size())
      throw StageError("the scalar '" + name + "' has " + std::to_string(of_point.size()) + " values, but vertex " +
                       std::to_string(v) + " is point " + std::to_string(mesh.point_of_vertex[v]));
    const bool turned = parity == Parity::kOdd && !mesh.turned_of_vertex.empty() && mesh.turned_of_vertex[v] != 0;
    values[v] = turned ? -of_point[point] : of_point[point];
  }
  return values;
}

}  // namespace

VertexScalar find_vertex_scalar(const std::string& name, std::span<const StageFields> fields, const TriangleMesh& mesh,
                                const PointCloud* cloud) {
  std::vector<std::string> available, matches;
  const ScalarField* found = nullptr;
  double radius = 0;
  bool exact = false;
  for (const StageFields& stage : fields)
    for (const ScalarField& field : stage.fields->fields) {
      const std::string full_name = stage.stage + "." + field.name;
      available.push_back(full_name);
      const bool is_full = name == full_name;
      if (!is_full && (exact || name != field.name)) continue;
      if (is_full) {
        exact = true;
        matches.clear();
      }
      matches.push_back(full_name);
      found = &field;
      radius = stage.fields->radius;
    }
  if (matches.size() > 1) {
    std::string text = matches[0];
    for (std::size_t i = 1; i < matches.size(); ++i) text += (i + 1 == matches.size() ? " or " : ", ") + matches[i];
    throw StageError("several stages make the scalar '" + name + "': write " + text);
  }
  VertexScalar scalar;
  scalar.name = name;
  if (found != nullptr) {
    scalar.unit = found->unit;
    scalar.noise = found->noise;
    scalar.radius = radius;
    scalar.values = at_vertices(name, found->values, found->parity, mesh);
    return scalar;
  }
  scalar.is_given = true;
  for (const Property& property : mesh.properties) {
    available.push_back(property.name);
    if (property.name != name) continue;
    scalar.values = property.values;
    return scalar;
  }
  if (cloud != nullptr)
    for (const Property& property : cloud->properties) {
      available.push_back(property.name);
      if (property.name != name) continue;
      scalar.values = at_vertices(name, property.values, Parity::kEven, mesh);
      return scalar;
    }
  std::string text = "there is no scalar '" + name + "'";
  if (available.empty()) {
    text += ", nor any other: add a curvature stage, or give a mesh with vertex properties";
  } else {
    std::sort(available.begin(), available.end());
    available.erase(std::unique(available.begin(), available.end()), available.end());
    text += available.size() == 1 ? "; there is only " : "; there are ";
    for (std::size_t i = 0; i < available.size(); ++i)
      text += (i == 0 ? "" : i + 1 == available.size() ? " and " : ", ") + available[i];
  }
  throw StageError(text);
}

}  // namespace meshmser
