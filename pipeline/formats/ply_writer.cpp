#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <stdexcept>

#include "pipeline/formats/output_file.hpp"
#include "pipeline/formats/ply.hpp"

namespace meshmser {
namespace {

static_assert(std::endian::native == std::endian::little, "rows are copied as they lie in memory");

template <class Number>
void put(OutputFile& file, Number value) {
  file.bytes(&value, sizeof(value));
}

/// Rounded to the nearest whole number, NaN to 0.
template <class Integer>
Integer whole(double value) {
  return std::isnan(value) ? Integer{0} : static_cast<Integer>(std::llround(value));
}

void put_value(OutputFile& file, ValueType type, double value) {
  switch (type) {
    case ValueType::kInt8:
      return put(file, whole<std::int8_t>(value));
    case ValueType::kUint8:
      return put(file, whole<std::uint8_t>(value));
    case ValueType::kInt16:
      return put(file, whole<std::int16_t>(value));
    case ValueType::kUint16:
      return put(file, whole<std::uint16_t>(value));
    case ValueType::kInt32:
      return put(file, whole<std::int32_t>(value));
    case ValueType::kUint32:
      return put(file, whole<std::uint32_t>(value));
    case ValueType::kFloat32:
      return put(file, static_cast<float>(value));
    case ValueType::kFloat64:
      return put(file, value);
  }
}

}  // namespace

struct PlyWriter::State {
  OutputFile file;
  std::vector<PlyPropertySpec> vertex, face;
  std::int64_t vertices_left, faces_left;
};

PlyWriter::PlyWriter(const std::filesystem::path& path, std::int64_t num_vertices, std::vector<PlyPropertySpec> vertex,
                     std::int64_t num_faces, std::vector<PlyPropertySpec> face,
                     const std::vector<std::string>& comments)
    : state_(new State{OutputFile(path), std::move(vertex), std::move(face), num_vertices,
                       std::max<std::int64_t>(num_faces, 0)}) {
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  for (const std::string& comment : comments) header += fmt::format("comment {}\n", comment);
  header += fmt::format("element vertex {}\n", num_vertices);
  for (const PlyPropertySpec& p : state_->vertex)
    header += fmt::format("property {} {}\n", ply_type_name(p.type), p.name);
  if (num_faces >= 0) {
    header += fmt::format("element face {}\nproperty list uchar int vertex_indices\n", num_faces);
    for (const PlyPropertySpec& p : state_->face)
      header += fmt::format("property {} {}\n", ply_type_name(p.type), p.name);
  }
  state_->file.text(header + "end_header\n");
}

PlyWriter::~PlyWriter() = default;

void PlyWriter::add_vertex(std::span<const double> values) {
  if (values.size() != state_->vertex.size())
    throw std::logic_error("PlyWriter: a vertex with other properties than declared");
  for (std::size_t i = 0; i < values.size(); ++i) put_value(state_->file, state_->vertex[i].type, values[i]);
  --state_->vertices_left;
}

void PlyWriter::add_triangle(std::span<const std::int32_t, 3> corners, std::span<const double> values) {
  if (values.size() != state_->face.size())
    throw std::logic_error("PlyWriter: a face with other properties than declared");
  put(state_->file, std::uint8_t{3});
  state_->file.bytes(corners.data(), corners.size_bytes());
  for (std::size_t i = 0; i < values.size(); ++i) put_value(state_->file, state_->face[i].type, values[i]);
  --state_->faces_left;
}

void PlyWriter::finish() {
  if (state_->vertices_left != 0 || state_->faces_left != 0)
    throw std::logic_error("PlyWriter: other counts than declared");
  state_->file.finish();
}

}  // namespace meshmser
