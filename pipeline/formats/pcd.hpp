#pragma once
#include "pipeline/formats/file_bytes.hpp"
#include "pipeline/formats/geometry.hpp"

namespace meshmser {

/// Reads a PCD file (PCL; ASCII, binary, compressed) by PCL. Fields of one value become properties; a packed `rgb` or
/// `rgba` becomes `red green blue`. VIEWPOINT's translation is the scanner position unless it is zero.
/// The header is checked against the size of the file before PCL sees it. Throws InputError. O(bytes).
Geometry read_pcd(const FileBytes& file);

}  // namespace meshmser
