#include "stages/mesh/orientation_vote.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <utility>

#include "stages/mesh/manifold.hpp"

namespace meshmser {
namespace {

using Eigen::Vector3d;

/// Below this cosine between a normal and the surface's own, the normal lies in the surface and tells no side: sin 12
/// deg.
constexpr double kIndifferentCosine = 0.2;

std::size_t at(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

/// What speaks for and against a mesh component's present sides.
struct Ballot {
  std::int64_t for_trusted = 0, against_trusted = 0;
  std::int64_t for_guess = 0, against_guess = 0;
  double six_volumes = 0;
  std::int64_t num_vertices = 0, num_turned = 0;
  bool has_rim = false;
  bool turn = false;
};

}  // namespace

OrientationReport orient_by_vote(const std::vector<Vector3d>& positions, std::vector<Triangle>& triangles,
                                 std::vector<std::int32_t>& twins, const std::vector<std::int32_t>& point_of_vertex,
                                 const PointNormals& normals, std::vector<Vector3d>& vertex_normals,
                                 std::vector<std::uint8_t>& turned, const Execution& execution) {
  const std::size_t num_vertices = positions.size();
  execution.check();
  std::int32_t num_components = 0;
  const std::vector<std::int32_t> component_of_triangle = edge_components(twins, &num_components);
  std::vector<Ballot> ballots(at(num_components));

  // The triangles' own normal at each vertex, area-weighted. One fan at each vertex, so one component.
  vertex_normals.assign(num_vertices, Vector3d::Zero());
  std::vector<std::int32_t> component_of_vertex(num_vertices, -1);
  std::vector<Vector3d> reference(at(num_components), Vector3d::Zero());
  std::vector<std::uint8_t> has_reference(at(num_components), 0);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Triangle& corners = triangles[t];
    const Vector3d &a = positions[at(corners[0])], &b = positions[at(corners[1])], &c = positions[at(corners[2])];
    const Vector3d twice_area = (b - a).cross(c - a);
    const std::int32_t component = component_of_triangle[t];
    Ballot& ballot = ballots[at(component)];
    // Volumes are taken from a vertex of the component, so that its place does not cost digits.
    Vector3d& base = reference[at(component)];
    if (!std::exchange(has_reference[at(component)], std::uint8_t{1})) base = a;
    ballot.six_volumes += twice_area.dot(a - base);
    for (std::size_t k = 0; k < 3; ++k) {
      vertex_normals[at(corners[k])] += twice_area;
      component_of_vertex[at(corners[k])] = component;
      if (twins[3 * t + k] < 0) ballot.has_rim = true;
    }
  }
  execution.check();

  const auto point_normal = [&](std::size_t v) -> const Vector3d& { return normals.normals[at(point_of_vertex[v])]; };
  std::vector<std::int8_t> side(num_vertices,
                                0);  // of the point's normal: 1 as the triangles, -1 against, 0 no opinion
  for (std::size_t v = 0; v < num_vertices; ++v) {
    if (component_of_vertex[v] < 0) continue;
    Ballot& ballot = ballots[at(component_of_vertex[v])];
    ++ballot.num_vertices;
    const double length = vertex_normals[v].norm();
    if (length > 0) vertex_normals[v] /= length;
    const double cosine = vertex_normals[v].dot(point_normal(v));
    if (!(std::abs(cosine) > kIndifferentCosine)) continue;
    side[v] = cosine > 0 ? 1 : -1;
    const std::int32_t source = normals.component_of_point[at(point_of_vertex[v])];
    const bool guess = source < 0 || normals.components[at(source)].source == SignSource::kGuess;
    ++(guess ? (cosine > 0 ? ballot.for_guess : ballot.against_guess)
             : (cosine > 0 ? ballot.for_trusted : ballot.against_trusted));
  }

  OrientationReport report;
  for (Ballot& ballot : ballots) {
    if (ballot.for_trusted != ballot.against_trusted) {
      ballot.turn = ballot.against_trusted > ballot.for_trusted;
      ++report.by_vote;
    } else if (!ballot.has_rim && ballot.six_volumes != 0) {
      ballot.turn = ballot.six_volumes < 0;
      ++report.by_volume;
    } else {
      ballot.turn = ballot.against_guess > ballot.for_guess;
      ++(ballot.for_guess != ballot.against_guess ? report.by_guess : report.undecided);
      report.vertices_by_guess += ballot.num_vertices;
    }
  }

  // Swapping corners 1 and 2 makes the old half-edges 0, 1, 2 the new 2, 1, 0.
  const auto renumbered = [&](std::int32_t h) { return h < 0 ? h : h / 3 * 3 + 2 - h % 3; };
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (!ballots[at(component_of_triangle[t])].turn) continue;
    std::swap(triangles[t][1], triangles[t][2]);
    std::swap(twins[3 * t], twins[3 * t + 2]);
    for (std::size_t k = 0; k < 3; ++k) twins[3 * t + k] = renumbered(twins[3 * t + k]);
  }

  turned.assign(num_vertices, 0);
  for (std::size_t v = 0; v < num_vertices; ++v) {
    if (component_of_vertex[v] < 0) continue;
    const Ballot& ballot = ballots[at(component_of_vertex[v])];
    if (ballot.turn) vertex_normals[v] = -vertex_normals[v];
    if (point_normal(v).isZero(0)) continue;
    const std::int64_t against = ballot.against_trusted + ballot.against_guess,
                       in_favour = ballot.for_trusted + ballot.for_guess;
    const std::int8_t opinion = side[v] != 0 ? side[v] : (against > in_favour ? std::int8_t{-1} : std::int8_t{1});
    const bool opposes = (opinion < 0) != ballot.turn;
    turned[v] = opposes;
    vertex_normals[v] = opposes ? Vector3d(-point_normal(v)) : point_normal(v);
    if (opposes) {
      ++report.turned_vertices;
      ++ballots[at(component_of_vertex[v])].num_turned;
    }
  }
  for (const Ballot& ballot : ballots)
    if (2 * ballot.num_turned > ballot.num_vertices) ++report.turned_components;
  return report;
}

}  // namespace meshmser
