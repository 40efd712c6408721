#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/execution/execution.hpp"

namespace meshmser {

/// The shape of a triangle mesh regardless of where its vertices lie.
struct MeshTopology {
  /// Empty for an oriented manifold with one fan at each vertex; else the first defect found, naming its elements.
  std::string defect;
  std::int64_t num_vertices = 0;  ///< that are corners
  std::int64_t num_edges = 0;
  std::int64_t num_triangles = 0;
  std::int64_t num_components = 0;  ///< edge-connected
  std::int64_t num_border_edges = 0;
  std::vector<std::int64_t> border_loops;  ///< number of edges of each, longest first
  std::int64_t euler = 0;                  ///< vertices - edges + triangles

  /// Loops of more than `edges` edges.
  std::int64_t loops_longer_than(std::int64_t edges) const;
};

/// Checks that `triangles` (corners below `num_vertices`; anything else is a defect too) are an oriented 2-manifold
/// with boundary - each edge in one or two triangles that run along it in opposite directions, one fan at each vertex -
/// and counts. With a defect the counts but `num_triangles` are not made. By counting sort, linear, independent of how
/// the mesh was built.
MeshTopology describe_topology(const std::vector<std::array<std::int32_t, 3>>& triangles, std::size_t num_vertices,
                               const Execution& execution = {});

}  // namespace meshmser
