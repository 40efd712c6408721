#pragma once
/// Trees of shapes checked by the words of the definition: components of vertices, and what they enclose, as sets.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "pipeline/artifacts/level_set_trees.hpp"

namespace meshmser::oracle {

/// What a tree of shapes is made of; `twins`: 3 #F, -1 at rims and at triangles that are cut out.
struct ShapesCase {
  std::span<const Eigen::Vector3d> positions;
  std::span<const std::array<std::int32_t, 3>> triangles;
  std::span<const std::uint8_t> excluded;
  std::span<const std::int32_t> twins;
  std::span<const std::int32_t> level_of_vertex;
  std::span<const double> areas;
  int num_levels = 0;
  std::int32_t root_vertex = -1;
};

/// Is each component a sphere once its rims are closed?
bool has_no_handle(const ShapesCase& of);

struct ShapesCheck {
  std::string broken;      ///< "" or what is wrong
  std::vector<int> lines;  ///< #F: 1 + the number of shapes of all levels that hold the triangle; 0: excluded
  int num_filled = 0;      ///< vertices in a shape that are not of its side
  int num_closed = 0;      ///< components without rim and without a given root
};

/// Compares a tree with saturation: shapes are nested or disjoint, the nodes are the edge-connected parts of their
/// triangles, and levels, sides, lines and own levels are those of the shapes. For a surface without handles.
ShapesCheck check_shapes(const ShapesCase& of, const ComponentTree& tree);

}  // namespace meshmser::oracle
