#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "pipeline/artifacts/triangle_mesh.hpp"
#include "pipeline/execution/execution.hpp"

namespace meshmser {

/// A mesh to look at: vertices in the order of their first use, so that triangles compress well.
struct DisplayMesh {
  std::vector<std::int32_t> vertex_of_display_vertex;      ///< of the full mesh
  std::vector<std::array<std::int32_t, 3>> triangles;      ///< of display vertices
  std::vector<std::int32_t> triangle_of_display_triangle;  ///< of the full mesh; ascending
  double cell = 0;  ///< edge of the cells whose vertices were joined, in coordinate units; 0: the full mesh
};

/// The mesh itself where it has at most `max_triangles`, else one with at most that many: the vertices in each cell of
/// a cubic grid become the first of them, triangles that keep three corners stay (once each), and the grid is made
/// coarser until few enough do. For looking at only: no figure is taken from it. A few passes, each O(F log F);
/// deterministic.
DisplayMesh display_mesh(const TriangleMesh& mesh, std::size_t max_triangles, const Execution& execution = {});

}  // namespace meshmser
