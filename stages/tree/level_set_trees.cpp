#include "stages/tree/level_set_trees.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <utility>

#include "pipeline/execution/error.hpp"
#include "pipeline/execution/jobs.hpp"
#include "stages/common/adjacency.hpp"
#include "stages/common/parallel.hpp"
#include "stages/common/surface.hpp"
#include "stages/tree/component_tree.hpp"
#include "stages/tree/fallen_rim.hpp"
#include "stages/tree/local_mean.hpp"
#include "stages/tree/tree_of_shapes.hpp"

namespace meshmser {
namespace {

double transformed(double value, ScalarTransform transform) {
  switch (transform) {
    case ScalarTransform::kNegate:
      return -value;
    case ScalarTransform::kAbs:
      return std::abs(value);
    case ScalarTransform::kNegateAbs:
      return -std::abs(value);
    default:
      return value;
  }
}

void refuse_values_that_are_not_finite(const VertexScalar& scalar, const TriangleMesh& mesh) {
  std::size_t first = scalar.values.size(), count = 0;
  for (std::size_t v = scalar.values.size(); v-- > 0;)
    if (!std::isfinite(scalar.values[v])) {
      first = v;
      ++count;
    }
  if (count == 0) return;
  // A place, since vertices are not counted as in the file they come from.
  const Eigen::Vector3d place = mesh.positions[first] + mesh.origin;
  std::ostringstream text;
  text.precision(9);
  text << "the scalar '" << scalar.name << "' is not finite at the vertex " << place.x() << ',' << place.y() << ','
       << place.z();
  if (count > 1) text << " and " << count - 1 << " more";
  text << "; mend it, or leave such triangles out with 'nan: exclude'";
  throw StageError(text.str());
}

std::vector<Polarity> polarities_of(PolarityChoice choice) {
  switch (choice) {
    case PolarityChoice::kUpper:
      return {Polarity::kUpper};
    case PolarityChoice::kLower:
      return {Polarity::kLower};
    case PolarityChoice::kShapes:
      return {Polarity::kShapes};
    case PolarityChoice::kBoth:
      break;
  }
  return {Polarity::kUpper, Polarity::kLower};
}

/// The levels of S, or of -S, and of its vertices in them. `values`: #V, NaN where a vertex does not count.
RankedValues quantise(std::span<const double> values, std::span<const double> weights, const LevelParameters& levels,
                      bool lower, const Execution& execution) {
  if (levels.rule == LevelRule::kEveryValue && !(levels.delta_value > 0))
    return rank_values(values, lower ? -1 : 1, execution);
  RankedValues quantised;
  quantised.levels = make_levels(values, weights, levels, lower);
  quantised.level_of_vertex = levels_of_vertices(values, quantised.levels, lower ? -1 : 1, execution);
  return quantised;
}

/// Of the vertices that count the one nearest to a point, ties to the smallest; -1: there is none.
std::int32_t nearest_vertex(std::span<const Eigen::Vector3d> positions, std::span<const double> values,
                            const Eigen::Vector3d& point) {
  std::int32_t nearest = -1;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t v = 0; v < positions.size(); ++v) {
    const double distance = (positions[v] - point).squaredNorm();
    if (std::isnan(values[v]) || !(distance < least)) continue;
    least = distance;
    nearest = static_cast<std::int32_t>(v);
  }
  return nearest;
}

}  // namespace

LevelSetTreesResult build_level_set_trees(const TriangleMesh& mesh, const VertexScalar& scalar,
                                          const LevelSetTreesParameters& parameters, const Execution& execution) {
  if (scalar.values.size() != mesh.num_vertices())
    throw StageError("the scalar '" + scalar.name + "' has " + std::to_string(scalar.values.size()) +
                     " values, but the mesh has " + std::to_string(mesh.num_vertices()) + " vertices");
  const bool nan_is_error =
      parameters.nan == NanPolicy::kError || (parameters.nan == NanPolicy::kAuto && scalar.is_given);
  if (nan_is_error) refuse_values_that_are_not_finite(scalar, mesh);

  LevelSetTreesResult result;
  LevelSetTrees& out = result.trees;
  out.scalar = scalar.name;
  out.unit = scalar.unit;
  out.noise = std::isnan(parameters.levels.noise) ? scalar.noise : parameters.levels.noise;
  out.values = scalar.values;

  std::vector<std::int32_t> twins = twin_half_edges(mesh.triangles, mesh.num_vertices(), execution);
  const std::vector<double> areas = triangle_areas(mesh.positions, mesh.triangles, execution);
  FallenRim fallen;
  if (parameters.fallen_rim) {
    if (!(scalar.radius > 0))
      throw StageError("fallen_rim needs the scale of the scalar '" + scalar.name +
                       "', which no curvature stage measured");
    fallen = fallen_rim(mesh.positions, mesh.normals, vertex_areas(mesh.triangles, areas, {}, mesh.num_vertices()),
                        mesh.triangles, twins, {scalar.radius, parameters.fallen_depth, parameters.min_rim}, execution);
    result.fallen_depth = fallen.depth;
  }
  result.exclusion = exclude_triangles(mesh.positions, mesh.triangles, twins, out.values, parameters.exclude_rim,
                                       parameters.min_rim, fallen.fallen_of_vertex, execution);
  out.excluded_of_triangle = std::move(result.exclusion.excluded_of_triangle);
  cut_out_triangles(twins, out.excluded_of_triangle);

  std::vector<double> weights;
  if (parameters.detrend > 0 || parameters.levels.rule == LevelRule::kEqualArea)
    weights = vertex_areas(mesh.triangles, areas, out.excluded_of_triangle, mesh.num_vertices());
  if (parameters.detrend > 0) {
    const std::vector<double> means =
        parameters.detrend_clip > 0 ? clipped_local_means(mesh.positions, out.values, weights, parameters.detrend,
                                                          parameters.detrend_clip, execution)
                                    : local_means(mesh.positions, out.values, weights, parameters.detrend, execution);
    for (std::size_t v = 0; v < means.size(); ++v)
      if (std::isfinite(means[v])) out.values[v] -= means[v];
  }
  for (double& value : out.values) value = transformed(value, parameters.transform);

  // Levels are laid over the vertices that remain in a triangle.
  std::vector<double> remaining(out.values.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (out.excluded_of_triangle[t] == 0)
      for (const std::int32_t corner : mesh.triangles[t])
        remaining[static_cast<std::size_t>(corner)] = out.values[static_cast<std::size_t>(corner)];
  LevelParameters levels = parameters.levels;
  levels.noise = out.noise;

  if (parameters.root) result.root_vertex = nearest_vertex(mesh.positions, remaining, *parameters.root);
  const std::vector<Polarity> polarities = polarities_of(parameters.polarity);
  // Two trees know nothing of each other, so that each has half of the threads.
  const int threads = thread_count(execution);
  Execution for_one = execution;
  for_one.threads = std::max(1, threads / static_cast<int>(polarities.size()));
  out.trees.resize(polarities.size());
  run_jobs(polarities.size(), threads, [&](std::size_t i) {
    execution.check();
    RankedValues ranked = quantise(remaining, weights, levels, polarities[i] == Polarity::kLower, for_one);
    if (polarities[i] == Polarity::kShapes) {
      out.trees[i] = build_tree_of_shapes({mesh.positions, mesh.triangles, twins}, areas, ranked.level_of_vertex,
                                          ranked.levels, out.excluded_of_triangle, result.root_vertex, for_one);
      return;
    }
    const std::vector<std::int32_t> level =
        levels_of_triangles(mesh.triangles, ranked.level_of_vertex, out.excluded_of_triangle, for_one);
    out.trees[i] = build_component_tree(twins, areas, level, static_cast<std::int32_t>(ranked.levels.size()), for_one);
    out.trees[i].polarity = polarities[i];
    out.trees[i].levels = std::move(ranked.levels);
  });
  return result;
}

}  // namespace meshmser
