#include "pipeline/formats/output_file.hpp"
#include "stages/export/export_files.hpp"

namespace meshmser {
namespace {

std::size_t at(std::int64_t index) {
  return static_cast<std::size_t>(index);
}

/// Vertex that a half-edge runs from, or to.
std::int32_t start_of(const TriangleMesh& mesh, std::int32_t h) {
  return mesh.triangles[at(h / 3)][at(h % 3)];
}
std::int32_t end_of(const TriangleMesh& mesh, std::int32_t h) {
  return mesh.triangles[at(h / 3)][at((h + 1) % 3)];
}

/// A position as text, made once for the two edges that share it.
struct PositionText {
  char text[96];
  std::size_t size = 0;

  void set(const Eigen::Vector3d& p, char separator) {
    char* cursor = text;
    for (int axis = 0; axis < 3; ++axis) {
      *cursor++ = separator;
      cursor = std::to_chars(cursor, text + sizeof(text), p[axis]).ptr;
    }
    size = static_cast<std::size_t>(cursor - text);
  }
  std::string_view view() const { return {text, size}; }
};

/// `l a b c ... a` for the vertices first .. first + count - 1, which OBJ counts from 1.
void write_closed_line(OutputFile& file, std::int64_t first, std::int64_t count) {
  file.character('l');
  for (std::int64_t i = 0; i <= count; ++i) {
    file.character(' ');
    file.number(first + i % count);
  }
  file.character('\n');
}

void write_group(OutputFile& file, std::int32_t owner) {
  file.text("g region_");
  file.number(std::int64_t{owner});
  file.character('\n');
}

void write_obj_vertex(OutputFile& file, const Eigen::Vector3d& position) {
  PositionText text;
  text.set(position, ' ');
  file.character('v');
  file.text(text.view());
  file.character('\n');
}

}  // namespace

void write_borders_csv(const std::filesystem::path& path, const TriangleMesh& mesh, const BorderLoops& loops) {
  OutputFile file(path);
  file.text("region,loop,edge,x0,y0,z0,x1,y1,z1,kind,neighbour\n");
  PositionText from, to;
  for (std::size_t l = 0; l < loops.num_loops(); ++l) {
    const std::int64_t begin = loops.first_edge_of_loop[l], end = loops.first_edge_of_loop[l + 1];
    for (std::int64_t e = begin; e < end; ++e) {
      const std::int32_t h = loops.half_edges[at(e)];
      if (e == begin) from.set(mesh.positions[at(start_of(mesh, h))] + mesh.origin, ',');
      to.set(mesh.positions[at(end_of(mesh, h))] + mesh.origin, ',');
      file.number(std::int64_t{loops.owner_of_loop[l]});
      file.character(',');
      file.number(static_cast<std::int64_t>(l));
      file.character(',');
      file.number(e - begin);
      file.text(from.view());
      file.text(to.view());
      file.text(loops.kinds[at(e)] == EdgeKind::kLevel ? ",level," : ",hole,");
      file.number(std::int64_t{loops.neighbours[at(e)]});
      file.character('\n');
      from = to;
    }
  }
  file.finish();
}

void write_borders_obj(const std::filesystem::path& path, const TriangleMesh& mesh, const BorderLoops& loops) {
  OutputFile file(path);
  std::int64_t next_vertex = 1;
  for (std::size_t l = 0; l < loops.num_loops(); ++l) {
    if (l == 0 || loops.owner_of_loop[l] != loops.owner_of_loop[l - 1]) write_group(file, loops.owner_of_loop[l]);
    const std::int64_t begin = loops.first_edge_of_loop[l], end = loops.first_edge_of_loop[l + 1];
    for (std::int64_t e = begin; e < end; ++e)
      write_obj_vertex(file, mesh.positions[at(start_of(mesh, loops.half_edges[at(e)]))] + mesh.origin);
    write_closed_line(file, next_vertex, end - begin);
    next_vertex += end - begin;
  }
  file.finish();
}

void write_curves_obj(const std::filesystem::path& path, const Eigen::Vector3d& origin, const BorderCurves& curves,
                      std::span<const std::int32_t> owner_of_curve) {
  OutputFile file(path);
  std::int64_t next_vertex = 1;
  for (std::size_t c = 0; c < owner_of_curve.size(); ++c) {
    if (c == 0 || owner_of_curve[c] != owner_of_curve[c - 1]) write_group(file, owner_of_curve[c]);
    const std::int64_t begin = curves.first_point_of_curve[c], end = curves.first_point_of_curve[c + 1];
    if (begin == end) continue;
    for (std::int64_t i = begin; i < end; ++i) write_obj_vertex(file, curves.points[at(i)] + origin);
    write_closed_line(file, next_vertex, end - begin);
    next_vertex += end - begin;
  }
  file.finish();
}

}  // namespace meshmser
