#pragma once
/// Which triangles touch along which edges. Half-edge h = 3 t + k runs from corner k to corner (k + 1) % 3 of triangle
/// t.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/execution/execution.hpp"

namespace meshmser {

inline std::int32_t triangle_of_half_edge(std::int32_t half_edge) {
  return half_edge / 3;
}
/// The half-edge that starts where this one ends, in the same triangle.
inline std::int32_t next_half_edge(std::int32_t half_edge) {
  return half_edge % 3 == 2 ? half_edge - 2 : half_edge + 1;
}
/// The half-edge that ends where this one starts, in the same triangle.
inline std::int32_t previous_half_edge(std::int32_t half_edge) {
  return half_edge % 3 == 0 ? half_edge + 2 : half_edge - 1;
}

/// The twin of every half-edge: the half-edge of the other triangle on the same edge, in the opposite direction.
///
/// `triangles`: #F corners in 0 .. num_vertices - 1, each edge in at most two triangles and then in opposite directions
/// (a vertex may be shared by several fans). Returns 3 #F half-edge ids, -1 where there is no other triangle.
/// Throws StageError for a corner out of range, for a triangle with a repeated corner, for an edge met twice in one
/// direction before its twin, and for more than 2^31 / 3 triangles. An edge in three or more triangles of which each two
/// that follow one another pair up is not noticed here: see find_edge_defects. Linear time; the result does not depend
/// on the number of threads.
std::vector<std::int32_t> twin_half_edges(std::span<const std::array<std::int32_t, 3>> triangles,
                                          std::size_t num_vertices, const Execution& execution = {});

/// An edge that keeps a mesh from being an oriented manifold.
struct EdgeDefect {
  std::int32_t smaller_vertex = 0, greater_vertex = 0;
  std::int32_t num_forward = 0;   ///< half-edges from the smaller to the greater vertex
  std::int32_t num_backward = 0;  ///< half-edges from the greater to the smaller vertex

  bool operator==(const EdgeDefect&) const = default;
};

/// Every edge with more than one half-edge in a direction, by ascending vertices: the exact check before
/// twin_half_edges of triangles from elsewhere. Linear time but for sorting the half-edges around each vertex. Corners
/// in range.
std::vector<EdgeDefect> find_edge_defects(std::span<const std::array<std::int32_t, 3>> triangles,
                                          std::size_t num_vertices);

/// Takes triangles out of a mesh: edges to a triangle with excluded[t] != 0 become hole edges, and its own too.
void cut_out_triangles(std::span<std::int32_t> twins, std::span<const std::uint8_t> excluded);

}  // namespace meshmser
