#pragma once
#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

namespace meshmser {

/// Cuts a polygon of n >= 3 corners in space into n - 2 triangles by ears (Meisters 1975), seen along its Newell
/// normal. Of the ears left the one of the shortest cut goes first, ties to the least corner, so that quads get their
/// shorter diagonal where both fit. A polygon without an ear (it crosses itself) is cut at its least corner. Returns
/// corner numbers 0 .. n - 1, turning as the polygon does. O(n^3) for odd shapes, fine for faces of meshes.
std::vector<std::array<int, 3>> cut_polygon(std::span<const Eigen::Vector3d> corners);

}  // namespace meshmser
