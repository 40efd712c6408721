#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "pipeline/execution/execution.hpp"
#include "stages/mesh/triangle.hpp"

namespace meshmser {

/// How the triangles came to be.
struct LocalDelaunayCounts {
  std::int64_t by_three = 0;  ///< found from all three corners
  std::int64_t by_two = 0;    ///< found from two corners and taken
  std::int64_t by_one = 0;    ///< found from one corner and taken
  std::int64_t refused = 0;   ///< found, but not from all three corners, and not taken
};

/// Triangles of a surface through the points, each found in the tangent planes of its corners.
///
/// Each point lays the points around it whose normals do not oppose its own into its tangent plane, at their distance
/// in space, and finds its neighbours there as those of its Voronoi cell. A triangle found from all three corners is
/// taken. One found from two is taken if it shares an edge with a taken one and overlaps none around any of its
/// corners; smaller circumradius first, over and over until none fits. Then those found from one corner alone, those
/// that share two edges first. So every half-edge is in at most one triangle: edges are manifold and the orientation,
/// counter-clockwise about the normals, is consistent. What remains open is for close_loops.
///
/// `positions`, `normals` (unit; zero: the point finds nothing) #P, `spacing` >= 0 only sets the pace, `max_edge`
/// finite and > 0 in coordinate units: no longer edge is made. Of coincident points the first is used. Corners are
/// indices into the arrays. Sorted (sort_triangles). Throws Cancelled. Linear, about 3 us and 150 bytes a point; same
/// triangles for any number of threads. Ties (points on one circle, as on a grid) are broken by weights that depend on
/// the index alone, so that neighbours agree; what they still disagree on costs triangles, never manifoldness.
///
/// Local Delaunay triangulation by votes: Gopi, Krishnan and Silva, "Surface reconstruction based on lower dimensional
/// localized Delaunay triangulation", 2000; deviations: circumcircles reach up to a radius of
/// max_edge, two votes or one may do.
std::vector<Triangle> local_delaunay(const std::vector<Eigen::Vector3d>& positions,
                                     const std::vector<Eigen::Vector3d>& normals, double spacing, double max_edge,
                                     const Execution& execution = {}, LocalDelaunayCounts* counts = nullptr);

}  // namespace meshmser
