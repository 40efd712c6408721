#pragma once
#include <cstdint>
#include <vector>

#include "stages/mesh/triangle.hpp"

namespace meshmser {

/// What had to leave so that triangles make an oriented manifold.
struct ManifoldRepair {
  std::int64_t degenerate = 0;     ///< triangles with a repeated corner, or the same corners as another
  std::int64_t third_on_edge = 0;  ///< triangles on an edge that two others use already
  std::int64_t inconsistent = 0;   ///< triangles that no orientation of their component could agree with
};

/// Leaves out triangles until each edge is in one or two, and orients the others so that neighbours across an edge
/// agree; the smallest triangle of each component has its corners ascending. `triangles` in any order and orientation,
/// which decide nothing; of the triangles on an overused edge the first two by corners stay. The result is sorted
/// (sort_triangles). Vertices may still be pinched: see split_pinched_vertices. Deterministic; n log n.
std::vector<Triangle> oriented_manifold(std::vector<Triangle> triangles, ManifoldRepair* repair = nullptr);

/// Triangles over their own vertices, one fan at each vertex.
struct CompactMesh {
  std::vector<Triangle> triangles;            ///< corners are vertices
  std::vector<std::int32_t> point_of_vertex;  ///< ascending; a point that was pinched stands once for each fan
  std::int64_t num_split = 0;                 ///< vertices made by splitting
  std::int64_t num_unused = 0;                ///< points in no triangle
};

/// Gives every fan of triangles around a point its own vertex and drops points without triangle. `triangles`: an
/// oriented manifold but for pinches (each half-edge once, else StageError), kept in order. Linear.
CompactMesh split_pinched_vertices(const std::vector<Triangle>& triangles, std::size_t num_points);

/// The number of the edge-connected component of each triangle, counted from 0 by smallest triangle id.
/// `twins` as of twin_half_edges. Linear.
std::vector<std::int32_t> edge_components(const std::vector<std::int32_t>& twins, std::int32_t* num_components);

}  // namespace meshmser
