#pragma once
/// The laws of trees, selections, labels and borders on any small mesh that a string of bytes stands for.

#include <cstdint>
#include <span>
#include <string>

namespace meshmser::testing {

/// Reads a mesh of at most 20 vertices and 40 triangles, a scalar, levels, excluded triangles and parameters out of any
/// bytes, makes trees, selections, labels and borders of it, and compares each with the slow literal oracle and the
/// border checker. Returns what is wrong, or nothing. The same bytes, the same mesh.
std::string broken_law(std::span<const std::uint8_t> bytes);

/// What a corpus should reach: counted in broken_law of the bytes.
struct MeshLawsCase {
  std::size_t num_triangles = 0, num_nodes = 0, num_regions = 0, num_loops = 0;
};
MeshLawsCase describe_case(std::span<const std::uint8_t> bytes);

}  // namespace meshmser::testing
