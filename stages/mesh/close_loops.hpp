#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "pipeline/execution/execution.hpp"
#include "stages/mesh/triangle.hpp"

namespace meshmser {

struct LoopCounts {
  std::int64_t closed = 0;     ///< loops filled
  std::int64_t left_open = 0;  ///< loops short enough that no valid triangles fill
  std::int64_t triangles = 0;  ///< made
};

/// Fills the short loops of a mesh's rim: cracks between triangles that their points could not agree on.
///
/// `triangles` over points #P: sorted (sort_triangles), each half-edge at most once (else StageError), pinches allowed.
/// A loop runs around one gap: where several fans meet at a point, it goes on along the fan across the gap, by angle
/// about the point's normal. A loop of at most `max_loop_edges` edges gets the triangulation of its polygon with the
/// least sum of edge lengths among those that use no edge of the mesh again, none longer than `max_edge` between
/// `positions` or between `other_positions` (null: not asked), and no triangle against the sum of its corners' normals.
/// Where there is none such, as in a fold, the last condition is dropped if the loop as a whole runs with its points'
/// normals; so the outer rim of a small patch is never filled. Adds the triangles, sorted too. Shorter loops first,
/// then smallest half-edge. Linear in the mesh, cubic in `max_loop_edges`; deterministic, one thread. Throws Cancelled.
///
/// Minimum-weight triangulation of a polygon: Klincsek, 1980; Barequet and Sharir, "Filling gaps in the boundary of a
/// polyhedron", 1995; deviation: edge lengths for areas, which tie on flat polygons.
LoopCounts close_loops(std::vector<Triangle>& triangles, const std::vector<Eigen::Vector3d>& positions,
                       const std::vector<Eigen::Vector3d>& normals, const std::vector<Eigen::Vector3d>* other_positions,
                       double max_edge, int max_loop_edges, const Execution& execution = {});

}  // namespace meshmser
