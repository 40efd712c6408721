#pragma once
#include <Eigen/Core>
#include <vector>

#include "pipeline/execution/execution.hpp"
#include "stages/mesh/triangle.hpp"

namespace meshmser {

/// Triangles of a surface through the points, grown facet by facet from their 3D Delaunay triangulation.
///
/// `positions`: #P; fewer than four points, or points on one line, give no triangle. Where several points coincide one
/// of them is used. No edge is longer than `max_edge` (in coordinate units, > 0; infinite: no bound), so wider gaps
/// stay open. Corners are indices into `positions`; each edge is in one or two triangles; the orientation is consistent
/// within a component, but arbitrary. Sorted (sort_triangles). Throws Cancelled. n log n, and much slower than
/// local_delaunay (some 100 us and 1.5 kB a point at 2.5M); one thread; same triangles in every run: ties in the
/// front's queue, which CGAL decides by memory addresses, are decided here by the order in which the edges' places were
/// made. Cohen-Steiner and Da, "A greedy Delaunay-based surface reconstruction algorithm", 2004, as in CGAL; deviation:
/// the priority of a facet with too long an edge is infinite.
std::vector<Triangle> advancing_front(const std::vector<Eigen::Vector3d>& positions, double max_edge,
                                      const Execution& execution = {});

}  // namespace meshmser
