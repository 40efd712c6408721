#pragma once
/// PLY, the Stanford polygon format (Greg Turk, 1994): ASCII, binary little and big endian.

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "pipeline/formats/file_bytes.hpp"
#include "pipeline/formats/geometry.hpp"

namespace meshmser {

/// Reads the vertices, faces and triangle strips of a PLY file. `x y z` become positions, every other scalar property
/// of the vertices a Property; list properties of vertices, other properties of faces and unknown elements (cameras,
/// materials) are skipped. An element `range_grid` (Stanford range maps) marks a map seen along +z: the scanner looks
/// down its z axis, so that `view_direction` is +z. Where `obj_info num_cols` tells its width, each vertex gets its row
/// and column as the properties kGridLine and kGridPlace (-1: in no cell).
/// Throws InputError with the header line, the data line (ASCII) or the element and byte (binary); counts are compared
/// with the size of the file before anything is allocated. O(bytes).
Geometry read_ply(const FileBytes& file);

/// Whether the header of a PLY file announces faces or strips. `head`: at least the whole header.
bool ply_announces_faces(const FileBytes& head);

struct PlyPropertySpec {
  std::string name;
  ValueType type = ValueType::kFloat64;
};

/// Writes a binary little endian PLY, one element after the other, rows in order. NaN in a column of an integer type is
/// written as 0.
class PlyWriter {
 public:
  /// The whole header must be declared before the first row: `vertex` properties, then, if num_faces >= 0, faces with
  /// `vertex_indices` (three corners) followed by `face` properties. Comments stand in the header, one line each.
  PlyWriter(const std::filesystem::path& path, std::int64_t num_vertices, std::vector<PlyPropertySpec> vertex,
            std::int64_t num_faces = -1, std::vector<PlyPropertySpec> face = {},
            const std::vector<std::string>& comments = {});
  ~PlyWriter();
  void add_vertex(std::span<const double> values);
  void add_triangle(std::span<const std::int32_t, 3> corners, std::span<const double> values);
  /// Writes what is left and checks that rows came as declared. Throws CacheError when the disk fails.
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// `float`, `uchar` ... as PLY headers name it.
std::string_view ply_type_name(ValueType type);

}  // namespace meshmser
