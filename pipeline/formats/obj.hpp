#pragma once
#include "pipeline/formats/file_bytes.hpp"
#include "pipeline/formats/geometry.hpp"

namespace meshmser {

/// Reads the vertices (`v x y z [w]` or `v x y z red green blue`) and faces (`f v/vt/vn ...`, negative numbers count
/// from the end) of a Wavefront OBJ file; a backslash continues a line. Everything else is skipped.
/// Throws InputError naming file:line. O(bytes).
Geometry read_obj(const FileBytes& file);

}  // namespace meshmser
