#include "pipeline/formats/off.hpp"

#include <fmt/format.h>

#include <limits>

namespace meshmser {
namespace {

/// Lines with something before any `#`.
class OffLines {
 public:
  explicit OffLines(const FileBytes& file)
      : file_(file), lines_(file.begin(), file.end(), line_terminator({file.begin(), file.size()})) {}
  std::string_view next(const char* wanted) {
    std::string_view line;
    while (lines_.next(line)) {
      line = line.substr(0, line.find('#'));
      while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
      if (!line.empty()) return line;
    }
    file_.fail_at(file_.end(),
                  fmt::format("the file ends before {}; it is truncated, or the counts in its head are wrong", wanted),
                  line_terminator({file_.begin(), file_.size()}));
  }
  [[noreturn]] void fail(std::string_view line, const std::string& message) const {
    file_.fail_at(line.data(), message, line_terminator({file_.begin(), file_.size()}));
  }

 private:
  const FileBytes& file_;
  Lines lines_;
};

std::int64_t take_count(const OffLines& lines, std::string_view whole, std::string_view& line, const char* what) {
  const std::string_view word = take_word(line);
  std::int64_t value = 0;
  if (word.empty() || parse_integer(word.data(), word.data() + word.size(), value) != word.data() + word.size())
    lines.fail(whole, fmt::format("{} is not {}; expected a whole number", in_quotes(word), what));
  return value;
}

double take_number(const OffLines& lines, std::string_view whole, std::string_view& line, const char* what) {
  const std::string_view word = take_word(line);
  double value = 0;
  if (word.empty() || parse_number(word.data(), word.data() + word.size(), value) != word.data() + word.size())
    lines.fail(whole, fmt::format("{} is not {}; expected a number", in_quotes(word), what));
  return value;
}

}  // namespace

Geometry read_off(const FileBytes& file) {
  OffLines lines(file);
  std::string_view line = lines.next("its first line");
  const std::string_view head = line;
  std::string_view kind = take_word(line);
  const bool has_colours = kind.starts_with('C');
  std::string_view rest_of_kind = kind.substr(has_colours ? 1 : 0);
  const bool has_normals = rest_of_kind.starts_with('N');
  rest_of_kind.remove_prefix(has_normals ? 1 : 0);
  if (rest_of_kind != "OFF")
    lines.fail(head, fmt::format("begins with {}; expected OFF, COFF, NOFF or CNOFF (the variants with texture or four "
                                 "coordinates are not read)",
                                 in_quotes(kind)));
  std::string_view counts = line;
  if (take_word(line).starts_with("BINARY")) lines.fail(head, "is a binary OFF file; save it as text, or as PLY");
  std::string_view whole = counts;
  if (std::string_view probe = counts; take_word(probe).empty())
    whole = counts = lines.next("the counts of vertices and faces");
  const std::int64_t num_vertices = take_count(lines, whole, counts, "the number of vertices");
  const std::int64_t num_faces = take_count(lines, whole, counts, "the number of faces");
  const auto bytes = static_cast<std::int64_t>(file.size());
  if (num_vertices <= 0 || num_faces < 0)
    lines.fail(whole, fmt::format("{} vertices and {} faces; expected at least one vertex", num_vertices, num_faces));
  if (num_vertices > bytes / 6 + 1 || num_faces > bytes / 4 + 1)  // "0 0 0\n" and "1 0\n" are the shortest rows
    lines.fail(
        whole,
        fmt::format("{} vertices and {} faces do not fit into {} bytes; the file is truncated or the counts are wrong",
                    num_vertices, num_faces, bytes));
  if (num_vertices > std::numeric_limits<std::int32_t>::max())
    lines.fail(whole, fmt::format("{} vertices; at most {} are possible", num_vertices,
                                  std::numeric_limits<std::int32_t>::max()));

  Geometry geometry;
  geometry.name = file.name();
  geometry.positions.reserve(static_cast<std::size_t>(num_vertices));
  if (has_normals)
    for (const char* name : {"nx", "ny", "nz"}) geometry.properties.push_back({name, ValueType::kFloat64, {}});
  const std::size_t first_colour = geometry.properties.size();
  std::size_t num_colours = 0;
  for (std::int64_t v = 0; v < num_vertices; ++v) {
    line = whole = lines.next("all its vertices");
    Eigen::Vector3d p;
    for (int axis = 0; axis < 3; ++axis) p[axis] = take_number(lines, whole, line, "a coordinate");
    geometry.positions.push_back(p);
    for (std::size_t i = 0; i < first_colour; ++i)
      geometry.properties[i].values.push_back(take_number(lines, whole, line, "a normal"));
    if (has_colours && v == 0) {
      std::string_view probe = line;
      while (!take_word(probe).empty()) ++num_colours;
      if (num_colours != 3 && num_colours != 4)
        lines.fail(whole, fmt::format("{} values of colour; expected 3 or 4", num_colours));
      for (std::size_t i = 0; i < num_colours; ++i)
        geometry.properties.push_back({std::array{"red", "green", "blue", "alpha"}[i], ValueType::kFloat64, {}});
    }
    for (std::size_t i = 0; i < num_colours; ++i)
      geometry.properties[first_colour + i].values.push_back(take_number(lines, whole, line, "a colour"));
    if (!take_word(line).empty())
      lines.fail(whole, fmt::format("too many values for a vertex: {}; expected {}", in_quotes(whole),
                                    3 + geometry.properties.size()));
  }
  if (num_faces > 0) geometry.first_corner_of_face.push_back(0);
  for (std::int64_t f = 0; f < num_faces; ++f) {
    line = whole = lines.next("all its faces");
    const std::int64_t n = take_count(lines, whole, line, "the number of corners");
    if (n < 3 || n > static_cast<std::int64_t>(whole.size()))
      lines.fail(whole, fmt::format("a face of {} corners; expected 3 or more, then so many vertices", n));
    for (std::int64_t k = 0; k < n; ++k) {
      const std::int64_t v = take_count(lines, whole, line, "a vertex");
      if (v < 0 || v >= num_vertices)
        lines.fail(whole, fmt::format("the face names vertex {}; the file has vertices 0 to {}", v, num_vertices - 1));
      geometry.corners.push_back(static_cast<std::int32_t>(v));
    }
    geometry.first_corner_of_face.push_back(static_cast<std::int64_t>(geometry.corners.size()));
  }
  return geometry;
}

}  // namespace meshmser
