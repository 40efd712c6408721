#pragma once
#include "pipeline/formats/file_bytes.hpp"
#include "pipeline/formats/geometry.hpp"

namespace meshmser {

/// Reads an STL file, ASCII or binary, told apart by its size. Every facet has three vertices of its own; merging equal
/// ones is the caller's. Facet normals are skipped: the order of the corners decides.
/// Throws InputError naming file:line, or the byte of a binary file. O(bytes).
Geometry read_stl(const FileBytes& file);

}  // namespace meshmser
