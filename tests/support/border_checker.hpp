#pragma once
/// Proof, apart from the code that made them, that border loops are what definitions 10 says.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "pipeline/artifacts/border_set.hpp"

namespace meshmser::testing {

/// Checks the loops of one owner against the set of its triangles, with edges looked up in maps and no half-edge walk.
///
/// `inside`: #F, 1 for a triangle of the region; `excluded`: #F or empty, 1 for a triangle that left the mesh. Proved
/// is: every loop is closed, lies on mesh edges with the region on its left, and begins at its smallest level
/// half-edge; no half-edge stands twice; kinds are right; every level half-edge of the region is there, and hole
/// half-edges are missing only as whole rims, `rims_missing` of them; loops are ordered; lengths are right; where a
/// vertex repeats, the loop stays within one wedge of the region, so that it does not cross itself; what the loops
/// fence off on their left is exactly the region (where there is a loop). Returns "" or what is wrong.
std::string check_border_loops(std::span<const Eigen::Vector3d> positions,
                               std::span<const std::array<std::int32_t, 3>> triangles,
                               std::span<const std::uint8_t> excluded, std::span<const std::uint8_t> inside,
                               const BorderLoops& loops, std::int32_t owner, std::int64_t* rims_missing = nullptr);

}  // namespace meshmser::testing
