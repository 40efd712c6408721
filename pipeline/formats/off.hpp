#pragma once
#include "pipeline/formats/file_bytes.hpp"
#include "pipeline/formats/geometry.hpp"

namespace meshmser {

/// Reads an ASCII OFF file (Geomview's object file format), with the variants COFF (colours), NOFF (normals) and CNOFF.
/// `#` begins a comment anywhere. Vertex normals become `nx ny nz`, vertex colours `red green blue alpha`; colours of
/// faces are skipped. Throws InputError naming file:line. O(bytes).
Geometry read_off(const FileBytes& file);

}  // namespace meshmser
