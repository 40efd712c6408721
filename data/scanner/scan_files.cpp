#include "data/scanner/scan_files.hpp"

#include <fmt/format.h>

#include <cmath>
#include <span>

#include "pipeline/execution/error.hpp"
#include "pipeline/formats/file_bytes.hpp"
#include "pipeline/formats/geometry_file.hpp"
#include "pipeline/formats/output_file.hpp"
#include "pipeline/formats/ply.hpp"

namespace meshmser::scanner {
namespace {

/// NumPy's header: magic, version, length, a Python dictionary, blanks up to a multiple of 64 bytes.
void write_npy(const std::filesystem::path& path, const char* type, const std::string& shape, const void* data,
               std::size_t size) {
  std::string header = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}", type, shape);
  header.resize((header.size() + 1 + 10 + 63) / 64 * 64 - 10, ' ');
  header.back() = '\n';
  OutputFile file(path);
  file.text(std::string_view("\x93NUMPY\x01\x00", 8));
  file.character(static_cast<char>(header.size() & 0xff));
  file.character(static_cast<char>(header.size() >> 8));
  file.text(header);
  file.bytes(data, size);
  file.finish();
}

void write_ply_points(const std::filesystem::path& path, const std::vector<Eigen::Vector3d>& points,
                      const std::vector<std::uint32_t>& selected, const PointFileOptions& options) {
  const ValueType type = options.double_precision ? ValueType::kFloat64 : ValueType::kFloat32;
  PlyWriter writer(path, static_cast<std::int64_t>(selected.size()), {{"x", type}, {"y", type}, {"z", type}}, -1, {},
                   {options.comment});
  for (std::uint32_t i : selected) {
    const Eigen::Vector3d p = points[i] + options.origin;
    writer.add_vertex(std::span<const double>(p.data(), 3));
  }
  writer.finish();
}

void write_pcd_points(const std::filesystem::path& path, const std::vector<Eigen::Vector3d>& points,
                      const std::vector<std::uint32_t>& selected, const PointFileOptions& options) {
  const Eigen::Vector3d view = options.viewpoint + options.origin;
  const int size = options.double_precision ? 8 : 4;
  OutputFile file(path);
  file.text(
      fmt::format("# .PCD v0.7 - {}\nVERSION 0.7\nFIELDS x y z\nSIZE {} {} {}\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {}\n"
                  "HEIGHT 1\nVIEWPOINT {} {} {} 1 0 0 0\nPOINTS {}\nDATA binary\n",
                  options.comment, size, size, size, selected.size(), view.x(), view.y(), view.z(), selected.size()));
  for (std::uint32_t i : selected) {
    const Eigen::Vector3d p = points[i] + options.origin;
    const Eigen::Vector3f single = p.cast<float>();
    if (options.double_precision)
      file.bytes(p.data(), sizeof(double) * 3);
    else
      file.bytes(single.data(), sizeof(float) * 3);
  }
  file.finish();
}

void write_xyz_points(const std::filesystem::path& path, const std::vector<Eigen::Vector3d>& points,
                      const std::vector<std::uint32_t>& selected, const PointFileOptions& options) {
  const int digits = std::max(0, static_cast<int>(std::ceil(-std::log10(options.spacing * 1e-4))));
  OutputFile file(path);
  for (std::uint32_t i : selected) {
    const Eigen::Vector3d p = points[i] + options.origin;
    file.text(fmt::format("{:.{}f} {:.{}f} {:.{}f}\n", p.x(), digits, p.y(), digits, p.z(), digits));
  }
  file.finish();
}

}  // namespace

Shape read_shape(const std::filesystem::path& path, double face_angle) {
  const std::vector<Geometry> scans = read_geometry_file(path);
  const Geometry& geometry = scans.front();
  if (geometry.num_faces() == 0)
    throw InputError(path.string() +
                     ": no faces, only points; the scanner needs a surface: give a mesh, or a built-in shape");
  Shape shape;
  shape.mesh.positions = geometry.positions;
  for (std::size_t face = 0; face < geometry.num_faces(); ++face) {
    const auto first = static_cast<std::size_t>(geometry.first_corner_of_face[face]);
    const auto end = static_cast<std::size_t>(geometry.first_corner_of_face[face + 1]);
    for (std::size_t corner = first + 2; corner < end; ++corner)
      shape.mesh.triangles.push_back({geometry.corners[first], geometry.corners[corner - 1], geometry.corners[corner]});
  }
  shape.face_of_triangle = faces_by_angle(shape.mesh, face_angle);
  return shape;
}

std::vector<Pose> read_poses(const std::filesystem::path& path, const Eigen::Vector3d& target) {
  const FileBytes file = read_file_bytes(path);
  Lines lines(file.begin(), file.end(), line_terminator({file.begin(), file.size()}));
  std::vector<Pose> poses;
  std::string_view line;
  while (lines.next_filled(line)) {
    if (line.front() == '#') continue;
    std::vector<double> values;
    for (std::string_view rest = line; !rest.empty();) {
      const std::string_view word = take_word(rest);
      double value = 0;
      if (parse_number(word.data(), word.data() + word.size(), value) != word.data() + word.size() ||
          !std::isfinite(value))
        file.fail_at(line.data(), fmt::format("'{}' is not a number", word));
      values.push_back(value);
    }
    if (values.size() != 3 && values.size() != 6)
      file.fail_at(line.data(), fmt::format("{} numbers; expected the scanner's x y z, or these and the target's x y z",
                                            values.size()));
    Pose pose{{values[0], values[1], values[2]}, target};
    if (values.size() == 6) pose.target = {values[3], values[4], values[5]};
    if (pose.position == pose.target) file.fail_at(line.data(), "the scanner stands where it looks at");
    poses.push_back(pose);
  }
  if (poses.empty()) file.fail("no poses; expected lines with the scanner's x y z");
  return poses;
}

void write_points(const std::filesystem::path& path, const std::vector<Eigen::Vector3d>& points,
                  const std::vector<std::uint32_t>& selected, const PointFileOptions& options) {
  const std::string extension = lower_case(path.extension().string());
  if (extension == ".ply")
    write_ply_points(path, points, selected, options);
  else if (extension == ".pcd")
    write_pcd_points(path, points, selected, options);
  else if (extension == ".xyz" || extension == ".txt")
    write_xyz_points(path, points, selected, options);
  else
    throw UsageError(path.string() + ": cannot tell the format from the name; end it in .ply, .pcd, .xyz or .txt");
}

void write_faces_npy(const std::filesystem::path& path, const std::vector<std::int32_t>& faces) {
  std::vector<std::uint16_t> values(faces.begin(), faces.end());
  write_npy(path, "<u2", fmt::format("{},", values.size()), values.data(), 2 * values.size());
}

void write_passes_npy(const std::filesystem::path& path, const std::vector<std::uint16_t>& passes) {
  write_npy(path, "<u2", fmt::format("{},", passes.size()), passes.data(), 2 * passes.size());
}

void write_normals_npy(const std::filesystem::path& path, const std::vector<Eigen::Vector3f>& normals) {
  write_npy(path, "<f4", fmt::format("{}, 3", normals.size()), normals.data(), 12 * normals.size());
}

void write_edges_npy(const std::filesystem::path& path, const std::vector<EdgeSample>& edges,
                     const Eigen::Vector3d& origin) {
  std::vector<float> values;
  for (const EdgeSample& edge : edges) {
    for (int c = 0; c < 3; ++c) values.push_back(static_cast<float>(edge.position[c] + origin[c]));
    values.push_back(static_cast<float>(edge.angle));
  }
  write_npy(path, "<f4", fmt::format("{}, 4", edges.size()), values.data(), 4 * values.size());
}

void write_shape(const std::filesystem::path& path, const Shape& shape, const Eigen::Vector3d& origin,
                 const std::string& comment) {
  PlyWriter writer(path, static_cast<std::int64_t>(shape.mesh.num_vertices()),
                   {{"x", ValueType::kFloat64}, {"y", ValueType::kFloat64}, {"z", ValueType::kFloat64}},
                   static_cast<std::int64_t>(shape.mesh.num_triangles()), {{"label", ValueType::kInt32}}, {comment});
  for (const Eigen::Vector3d& position : shape.mesh.positions) {
    const Eigen::Vector3d p = position + origin;
    writer.add_vertex(std::span<const double>(p.data(), 3));
  }
  for (std::size_t t = 0; t < shape.mesh.num_triangles(); ++t) {
    const double label = shape.face_of_triangle[t];
    writer.add_triangle(shape.mesh.triangles[t], std::span<const double>(&label, 1));
  }
  writer.finish();
}

}  // namespace meshmser::scanner
