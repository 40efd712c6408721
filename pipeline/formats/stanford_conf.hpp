#pragma once
#include <Eigen/Geometry>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/formats/file_bytes.hpp"

namespace meshmser {

/// A file and where it stands.
struct PosedFile {
  std::filesystem::path path;
  Eigen::Isometry3d world_from_file = Eigen::Isometry3d::Identity();
};

/// Reads a `.conf` of the Stanford 3D Scanning Repository: lines `bmesh FILE tx ty tz qx qy qz qw`, files beside the
/// .conf. A point is turned by the *conjugate* of the stored quaternion, then moved by t: so neighbouring maps of the
/// bunny lie 0.3 mm apart, with the stored sign 4 to 108 mm. Lines `camera` (a view for pictures, not the scanner) and
/// `mesh` (as `bmesh`) are known, others are errors.
/// Throws InputError naming file:line. In the order of the file.
std::vector<PosedFile> read_stanford_conf(const FileBytes& file);

}  // namespace meshmser
