#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "data/scanner/shape.hpp"
#include "data/scanner/virtual_scanner.hpp"

namespace meshmser::scanner {

/// Reads a triangle mesh of any format that meshmser reads; polygons are cut in fans, coordinates stay as they are.
/// Faces by faces_by_angle. Throws InputError when the file holds no faces.
Shape read_shape(const std::filesystem::path& path, double face_angle);

/// Poses from a text file: one a line, `x y z` of the scanner and, if wanted, `x y z` of what it looks at (else
/// `target`); empty lines and lines that begin with # are skipped. Throws InputError with file:line.
std::vector<Pose> read_poses(const std::filesystem::path& path, const Eigen::Vector3d& target);

/// Writes points by the file's extension: .ply (binary, float, or double where `double_precision`), .pcd (binary,
/// float, with `viewpoint`), .xyz (text, rounded to a ten-thousandth of `spacing`). `selected`: their indices, in
/// order. Throws UsageError for another extension, CacheError when the disk fails.
struct PointFileOptions {
  bool double_precision = false;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< added to every coordinate
  Eigen::Vector3d viewpoint = Eigen::Vector3d::Zero();
  double spacing = 1;
  std::string comment;
};
void write_points(const std::filesystem::path& path, const std::vector<Eigen::Vector3d>& points,
                  const std::vector<std::uint32_t>& selected, const PointFileOptions& options);

/// NumPy arrays (version 1.0, little endian): true faces as uint16 (N,), 0: outlier; passes as uint16 (N,); true
/// normals as float32 (N, 3), zero: outlier; points on true edges as float32 (N, 4): x y z and the angle in degrees.
void write_faces_npy(const std::filesystem::path& path, const std::vector<std::int32_t>& faces);
void write_passes_npy(const std::filesystem::path& path, const std::vector<std::uint16_t>& passes);
void write_normals_npy(const std::filesystem::path& path, const std::vector<Eigen::Vector3f>& normals);
void write_edges_npy(const std::filesystem::path& path, const std::vector<EdgeSample>& edges,
                     const Eigen::Vector3d& origin);

/// Writes the exact mesh as binary PLY with the true face of each triangle as property `label`.
void write_shape(const std::filesystem::path& path, const Shape& shape, const Eigen::Vector3d& origin,
                 const std::string& comment);

}  // namespace meshmser::scanner
