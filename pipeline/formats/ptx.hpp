#pragma once
#include <vector>

#include "pipeline/formats/file_bytes.hpp"
#include "pipeline/formats/geometry.hpp"

namespace meshmser {

/// Reads a PTX file (Leica; also as Photoneo writes it): one or several scans, each ten header lines (columns, rows,
/// scanner position, three scanner axes, a 4 x 4 matrix whose last row is the translation) and a grid of
/// `x y z [intensity [red green blue]]`. The matrix is applied to points and scanner position; `0 0 0` marks a cell
/// without a measured point and is left out and counted.
/// Throws InputError naming file:line. O(bytes).
std::vector<Geometry> read_ptx(const FileBytes& file);

}  // namespace meshmser
