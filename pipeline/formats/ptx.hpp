#pragma once
#include <vector>

#include "pipeline/formats/file_bytes.hpp"
#include "pipeline/formats/geometry.hpp"

namespace meshmser {

/// Reads a PTX file: one or several scans, each ten header lines (the number of scan lines and of places along one,
/// scanner position, three scanner axes, a 4 x 4 matrix whose last row is the translation) and a grid of
/// `x y z [intensity [red green blue]]`, line by line. Leica calls its lines columns (the first number) and their
/// places rows, Photoneo writes rows first and goes row by row: the order of the cells is the same. Points get their
/// line and place as the properties kGridLine and kGridPlace. The matrix is applied to points and scanner position; `0
/// 0 0` marks a cell without a measured point and is left out and counted. Throws InputError naming file:line.
/// O(bytes).
std::vector<Geometry> read_ptx(const FileBytes& file);

}  // namespace meshmser
