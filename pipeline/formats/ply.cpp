#include "pipeline/formats/ply.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <optional>

namespace meshmser {
namespace {

constexpr std::int64_t kMostElements = std::numeric_limits<std::int32_t>::max();

enum class Encoding { kAscii, kLittle, kBig };

struct PlyProperty {
  std::string name;
  ValueType type = ValueType::kFloat32;
  std::optional<ValueType> count_type;  // of a list
};

struct PlyElement {
  std::string name;
  std::int64_t count = 0;
  std::vector<PlyProperty> properties;

  bool has_lists() const {
    return std::any_of(properties.begin(), properties.end(),
                       [](const PlyProperty& p) { return p.count_type.has_value(); });
  }
  /// Position of the list property of that name, or -1.
  int find_list(std::initializer_list<std::string_view> names) const {
    for (std::size_t i = 0; i < properties.size(); ++i)
      if (properties[i].count_type && std::find(names.begin(), names.end(), properties[i].name) != names.end())
        return static_cast<int>(i);
    return -1;
  }
};

struct Header {
  Encoding encoding = Encoding::kAscii;
  std::vector<PlyElement> elements;
  std::int64_t num_columns = 0;  // of a range grid, from `obj_info num_cols`; 0: not told
  const char* data = nullptr;    // first byte after it
};

std::size_t size_of(ValueType type) {
  switch (type) {
    case ValueType::kInt8:
    case ValueType::kUint8:
      return 1;
    case ValueType::kInt16:
    case ValueType::kUint16:
      return 2;
    case ValueType::kInt32:
    case ValueType::kUint32:
    case ValueType::kFloat32:
      return 4;
    case ValueType::kFloat64:
      return 8;
  }
  return 0;
}

std::optional<ValueType> type_named(std::string_view name) {
  static constexpr std::array<std::pair<std::string_view, ValueType>, 16> kTypes{{{"char", ValueType::kInt8},
                                                                                  {"int8", ValueType::kInt8},
                                                                                  {"uchar", ValueType::kUint8},
                                                                                  {"uint8", ValueType::kUint8},
                                                                                  {"short", ValueType::kInt16},
                                                                                  {"int16", ValueType::kInt16},
                                                                                  {"ushort", ValueType::kUint16},
                                                                                  {"uint16", ValueType::kUint16},
                                                                                  {"int", ValueType::kInt32},
                                                                                  {"int32", ValueType::kInt32},
                                                                                  {"uint", ValueType::kUint32},
                                                                                  {"uint32", ValueType::kUint32},
                                                                                  {"float", ValueType::kFloat32},
                                                                                  {"float32", ValueType::kFloat32},
                                                                                  {"double", ValueType::kFloat64},
                                                                                  {"float64", ValueType::kFloat64}}};
  for (const auto& [known, type] : kTypes)
    if (known == name) return type;
  return std::nullopt;
}

ValueType type_or_fail(const FileBytes& file, const char* at, std::string_view name) {
  const std::optional<ValueType> type = type_named(name);
  if (!type)
    file.fail_at(
        at, fmt::format("unknown PLY type {}; expected one of char, uchar, short, ushort, int, uint, float, double",
                        in_quotes(name)));
  return *type;
}

template <class Unsigned>
Unsigned load_bytes(const char* bytes, bool swap) {
  Unsigned value;
  std::memcpy(&value, bytes, sizeof(value));
  if (swap) {
    if constexpr (sizeof(Unsigned) == 2) value = static_cast<Unsigned>(__builtin_bswap16(value));
    if constexpr (sizeof(Unsigned) == 4) value = __builtin_bswap32(value);
    if constexpr (sizeof(Unsigned) == 8) value = __builtin_bswap64(value);
  }
  return value;
}

double load_value(const char* bytes, ValueType type, bool swap) {
  switch (type) {
    case ValueType::kInt8:
      return static_cast<signed char>(*bytes);
    case ValueType::kUint8:
      return static_cast<unsigned char>(*bytes);
    case ValueType::kInt16:
      return static_cast<std::int16_t>(load_bytes<std::uint16_t>(bytes, swap));
    case ValueType::kUint16:
      return load_bytes<std::uint16_t>(bytes, swap);
    case ValueType::kInt32:
      return static_cast<std::int32_t>(load_bytes<std::uint32_t>(bytes, swap));
    case ValueType::kUint32:
      return load_bytes<std::uint32_t>(bytes, swap);
    case ValueType::kFloat32:
      return std::bit_cast<float>(load_bytes<std::uint32_t>(bytes, swap));
    case ValueType::kFloat64:
      return std::bit_cast<double>(load_bytes<std::uint64_t>(bytes, swap));
  }
  return 0;
}

/// One header line `property ...` without its first word.
PlyProperty parse_property(const FileBytes& file, std::string_view line) {
  const char* at = line.data();
  PlyProperty property;
  std::string_view word = take_word(line);
  if (word == "list") {
    const std::string_view count_type = take_word(line), type = take_word(line);
    property.count_type = type_or_fail(file, at, count_type);
    if (*property.count_type == ValueType::kFloat32 || *property.count_type == ValueType::kFloat64)
      file.fail_at(at, fmt::format("a list is counted in {}; expected a whole-number type such as uchar", count_type));
    property.type = type_or_fail(file, at, type);
  } else {
    property.type = type_or_fail(file, at, word);
  }
  property.name = std::string(take_word(line));
  if (property.name.empty()) file.fail_at(at, "a property without a name; expected 'property TYPE NAME'");
  return property;
}

PlyElement parse_element(const FileBytes& file, std::string_view line) {
  const char* at = line.data();
  PlyElement element;
  element.name = std::string(take_word(line));
  const std::string_view count = take_word(line);
  const char* stop = parse_integer(count.data(), count.data() + count.size(), element.count);
  if (element.name.empty() || count.empty() || stop != count.data() + count.size() || element.count < 0)
    file.fail_at(at, fmt::format("expected 'element NAME COUNT' with a whole number, found {}", in_quotes(count)));
  return element;
}

Header parse_header(const FileBytes& file) {
  Lines lines(file.begin(), file.end());
  std::string_view line;
  lines.next(line);
  if (line != "ply")
    file.fail_at(file.begin(), fmt::format("does not begin with 'ply' but {}; is it a PLY file?", in_quotes(line)));
  Header header;
  bool has_format = false, ended = false;
  while (!ended && lines.next(line)) {
    const char* at = line.data();
    const std::string_view word = take_word(line);
    if (word.empty() || word == "comment") continue;
    if (word == "obj_info") {
      // Free text but for what range maps say of their grid; what is no number is left alone.
      if (take_word(line) == "num_cols") {
        const std::string_view count = take_word(line);
        parse_integer(count.data(), count.data() + count.size(), header.num_columns);
      }
      continue;
    }
    if (word == "format") {
      const std::string_view encoding = take_word(line);
      if (encoding == "ascii") {
        header.encoding = Encoding::kAscii;
      } else if (encoding == "binary_little_endian") {
        header.encoding = Encoding::kLittle;
      } else if (encoding == "binary_big_endian") {
        header.encoding = Encoding::kBig;
      } else {
        file.fail_at(at,
                     fmt::format("unknown PLY encoding {}; expected ascii, binary_little_endian or binary_big_endian",
                                 in_quotes(encoding)));
      }
      if (const std::string_view version = take_word(line); version != "1.0")
        file.fail_at(at, fmt::format("PLY version {}; only 1.0 is known", in_quotes(version)));
      has_format = true;
    } else if (word == "element") {
      header.elements.push_back(parse_element(file, line));
    } else if (word == "property") {
      if (header.elements.empty())
        file.fail_at(at, "a property before the first element; put 'element vertex COUNT' before it");
      PlyElement& element = header.elements.back();
      PlyProperty property = parse_property(file, line);
      for (const PlyProperty& other : element.properties)
        if (other.name == property.name)
          file.fail_at(
              at, fmt::format("property '{}' stands twice in element '{}'; rename one", property.name, element.name));
      element.properties.push_back(std::move(property));
    } else if (word == "end_header") {
      ended = true;
    } else {
      file.fail_at(
          at, fmt::format("unknown header line {}; expected format, comment, obj_info, element, property or end_header",
                          in_quotes(word)));
    }
  }
  if (!ended) file.fail("the header has no 'end_header'; the file is cut short or not a PLY file");
  if (!has_format) file.fail("the header has no 'format' line; expected 'format ascii 1.0' or a binary one");
  header.data = lines.position();
  return header;
}

/// Where the values of an element go, as they are read row by row.
struct Sink {
  std::vector<double*> scalar;  // one per property: array of values by row, or null
  int list = -1;                // position of the list that is wanted, or -1
  std::vector<std::int64_t>* first = nullptr;
  std::vector<std::int32_t>* items = nullptr;
};

std::string element_row(const PlyElement& element, std::int64_t row) {
  return fmt::format("{} {} of {}", element.name, row, element.count);
}

[[noreturn]] void fail_truncated(const FileBytes& file, const PlyElement& element, std::int64_t row) {
  file.fail(fmt::format("ends at byte {} inside {}; the file is truncated, copy it again", file.size(),
                        element_row(element, row)));
}

/// A number of a wanted list as an index; strips hold -1, faces must not, which is checked later.
std::int32_t as_index(const FileBytes& file, const PlyElement& element, std::int64_t row, double value) {
  if (!(value >= -1 && value <= static_cast<double>(kMostElements)) ||
      value != static_cast<double>(static_cast<std::int64_t>(value)))
    file.fail(fmt::format("{}: {} is not the number of a vertex; expected a whole number from 0",
                          element_row(element, row), value));
  return static_cast<std::int32_t>(value);
}

const char* read_binary_element(const FileBytes& file, const PlyElement& element, const char* data, bool swap,
                                const Sink& sink) {
  if (!element.has_lists()) {
    std::size_t stride = 0;
    std::vector<std::size_t> offsets;
    for (const PlyProperty& property : element.properties) {
      offsets.push_back(stride);
      stride += size_of(property.type);
    }
    const std::size_t rest = static_cast<std::size_t>(file.end() - data);
    if (stride > 0 && static_cast<std::size_t>(element.count) > rest / stride)
      fail_truncated(file, element, static_cast<std::int64_t>(rest / stride));
    for (std::size_t p = 0; p < offsets.size(); ++p) {
      if (sink.scalar[p] == nullptr) continue;
      const char* from = data + offsets[p];
      for (std::int64_t row = 0; row < element.count; ++row, from += stride)
        sink.scalar[p][row] = load_value(from, element.properties[p].type, swap);
    }
    return data + stride * static_cast<std::size_t>(element.count);
  }
  for (std::int64_t row = 0; row < element.count; ++row) {
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      const PlyProperty& property = element.properties[p];
      const std::size_t size = size_of(property.type);
      std::int64_t items = 1;
      if (property.count_type) {
        const std::size_t count_size = size_of(*property.count_type);
        if (static_cast<std::size_t>(file.end() - data) < count_size) fail_truncated(file, element, row);
        items = static_cast<std::int64_t>(load_value(data, *property.count_type, swap));
        if (items < 0)
          file.fail(fmt::format("{}: a list of {} items at byte {}; the file is damaged", element_row(element, row),
                                items, data - file.begin()));
        data += count_size;
      }
      if (static_cast<std::size_t>(file.end() - data) / size < static_cast<std::size_t>(items))
        fail_truncated(file, element, row);
      if (static_cast<int>(p) == sink.list) {
        for (std::int64_t i = 0; i < items; ++i)
          sink.items->push_back(
              as_index(file, element, row, load_value(data + static_cast<std::size_t>(i) * size, property.type, swap)));
        sink.first->push_back(static_cast<std::int64_t>(sink.items->size()));
      } else if (!property.count_type && sink.scalar[p] != nullptr) {
        sink.scalar[p][row] = load_value(data, property.type, swap);
      }
      data += static_cast<std::size_t>(items) * size;
    }
  }
  return data;
}

double take_number(const FileBytes& file, const PlyElement& element, std::string_view& line, std::string_view whole) {
  const char* first = skip_blanks(line.data(), line.data() + line.size());
  const char* last = line.data() + line.size();
  if (first == last)
    file.fail_at(whole.data(), fmt::format("too few values for element '{}': {}; expected {} properties", element.name,
                                           in_quotes(whole), element.properties.size()));
  double value = 0;
  const char* stop = parse_number(first, last, value);
  if (stop == nullptr || (stop != last && !is_blank(*stop))) {
    std::string_view rest(first, static_cast<std::size_t>(last - first));
    file.fail_at(whole.data(),
                 fmt::format("{} is not a number; expected the properties of element '{}', separated by blanks",
                             in_quotes(take_word(rest)), element.name));
  }
  line = {stop, static_cast<std::size_t>(last - stop)};
  return value;
}

const char* read_ascii_element(const FileBytes& file, const PlyElement& element, const char* data, const Sink& sink) {
  if (element.properties.empty()) return data;
  // Each row is a line of at least one character, so a count beyond that is absurd.
  if (element.count > (file.end() - data + 1) / 2 + 1)
    file.fail(
        fmt::format("the header announces {} '{}' rows, more than the {} bytes after it can hold; the file is "
                    "truncated or its header wrong",
                    element.count, element.name, file.end() - data));
  Lines lines(data, file.end());
  std::string_view line;
  for (std::int64_t row = 0; row < element.count; ++row) {
    if (!lines.next_filled(line))
      file.fail_at(file.end(),
                   fmt::format("the file ends before {}; it is truncated, copy it again", element_row(element, row)));
    const std::string_view whole = line;
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      const double value = take_number(file, element, line, whole);
      if (!element.properties[p].count_type) {
        if (sink.scalar[p] != nullptr) sink.scalar[p][row] = value;
        continue;
      }
      if (!(value >= 0 && value <= static_cast<double>(whole.size())))
        file.fail_at(
            whole.data(),
            fmt::format("a list of {} items does not fit its line; expected the count, then so many numbers", value));
      const bool wanted = static_cast<int>(p) == sink.list;
      for (std::int64_t i = 0; i < static_cast<std::int64_t>(value); ++i) {
        const double item = take_number(file, element, line, whole);
        if (wanted) sink.items->push_back(as_index(file, element, row, item));
      }
      if (wanted) sink.first->push_back(static_cast<std::int64_t>(sink.items->size()));
    }
    if (skip_blanks(line.data(), line.data() + line.size()) != line.data() + line.size())
      file.fail_at(whole.data(), fmt::format("too many values for element '{}': {}; expected {} properties",
                                             element.name, in_quotes(whole), element.properties.size()));
  }
  return lines.position();
}

/// Strips of triangles separated by -1, every second triangle turned, as faces.
void append_strips(const std::vector<std::int32_t>& strip, Geometry& geometry) {
  std::size_t begin = 0;
  for (std::size_t i = 0; i < strip.size(); ++i) {
    if (strip[i] < 0) begin = i + 1;
    if (i < begin + 2) continue;
    const bool turned = (i - begin) % 2 == 1;
    const std::array<std::int32_t, 3> corners{strip[i - 2], strip[turned ? i : i - 1], strip[turned ? i - 1 : i]};
    if (corners[0] == corners[1] || corners[1] == corners[2] || corners[0] == corners[2]) continue;
    geometry.corners.insert(geometry.corners.end(), corners.begin(), corners.end());
    geometry.first_corner_of_face.push_back(static_cast<std::int64_t>(geometry.corners.size()));
  }
}

/// The cells of a range grid, row by row, as the row and column of each vertex; -1 for those in no cell.
void add_grid_places(const FileBytes& file, const std::vector<std::int64_t>& first_of_cell,
                     const std::vector<std::int32_t>& vertices, std::int64_t num_columns, Geometry& geometry) {
  const auto has = [&](std::string_view name) {
    return std::any_of(geometry.properties.begin(), geometry.properties.end(),
                       [&](const Property& property) { return property.name == name; });
  };
  if (num_columns <= 0 || has(kGridLine) || has(kGridPlace)) return;
  const std::size_t n = geometry.num_vertices();
  std::vector<double> line(n, -1), place(n, -1);
  for (std::size_t cell = 0; cell + 1 < first_of_cell.size(); ++cell)
    for (std::int64_t i = first_of_cell[cell]; i < first_of_cell[cell + 1]; ++i) {
      const std::int32_t vertex = vertices[static_cast<std::size_t>(i)];
      if (vertex < 0) continue;
      if (static_cast<std::size_t>(vertex) >= n)
        file.fail(
            fmt::format("range_grid cell {} names vertex {}; the file has vertices 0 to {}", cell, vertex, n - 1));
      line[static_cast<std::size_t>(vertex)] = static_cast<double>(static_cast<std::int64_t>(cell) / num_columns);
      place[static_cast<std::size_t>(vertex)] = static_cast<double>(static_cast<std::int64_t>(cell) % num_columns);
    }
  geometry.properties.push_back({kGridLine, ValueType::kInt32, std::move(line)});
  geometry.properties.push_back({kGridPlace, ValueType::kInt32, std::move(place)});
}

void check_faces(const FileBytes& file, const Geometry& geometry) {
  const auto n = static_cast<std::int32_t>(geometry.num_vertices());
  for (std::size_t f = 0; f < geometry.num_faces(); ++f) {
    const std::int64_t begin = geometry.first_corner_of_face[f], end = geometry.first_corner_of_face[f + 1];
    if (end - begin < 3) file.fail(fmt::format("face {} has {} corners; expected at least 3", f, end - begin));
    for (std::int64_t c = begin; c < end; ++c)
      if (const std::int32_t v = geometry.corners[static_cast<std::size_t>(c)]; v < 0 || v >= n)
        file.fail(fmt::format("face {} names vertex {}; the file has vertices 0 to {}", f, v, n - 1));
  }
}

}  // namespace

std::string_view ply_type_name(ValueType type) {
  switch (type) {
    case ValueType::kInt8:
      return "char";
    case ValueType::kUint8:
      return "uchar";
    case ValueType::kInt16:
      return "short";
    case ValueType::kUint16:
      return "ushort";
    case ValueType::kInt32:
      return "int";
    case ValueType::kUint32:
      return "uint";
    case ValueType::kFloat32:
      return "float";
    case ValueType::kFloat64:
      return "double";
  }
  return "double";
}

bool ply_announces_faces(const FileBytes& head) {
  const Header header = parse_header(head);
  return std::any_of(header.elements.begin(), header.elements.end(), [](const PlyElement& element) {
    return (element.name == "face" || element.name == "tristrips") && element.count > 0;
  });
}

Geometry read_ply(const FileBytes& file) {
  const Header header = parse_header(file);
  const bool swap = (header.encoding == Encoding::kBig) == (std::endian::native == std::endian::little);
  Geometry geometry;
  geometry.name = file.name();
  bool has_vertices = false;
  std::vector<std::int64_t> first_of_cell;
  std::vector<std::int32_t> cells;
  const char* data = header.data;
  for (const PlyElement& element : header.elements) {
    if (element.count > kMostElements)
      file.fail(fmt::format("the header announces {} '{}' rows; at most {} are possible", element.count, element.name,
                            kMostElements));
    Sink sink;
    sink.scalar.assign(element.properties.size(), nullptr);
    std::array<std::vector<double>, 3> coordinates;
    std::vector<std::int32_t> strips;
    std::vector<std::int64_t> first_of_strip;
    const bool is_vertex = element.name == "vertex";
    if (is_vertex) {
      if (has_vertices) file.fail("element 'vertex' stands twice in the header; expected it once");
      has_vertices = true;
      // Before anything is allocated: a row takes at least so many bytes.
      std::size_t least = 0;
      for (const PlyProperty& property : element.properties)
        least += header.encoding == Encoding::kAscii ? 2 : size_of(property.count_type.value_or(property.type));
      const std::size_t rest = static_cast<std::size_t>(file.end() - data) + 1;
      if (least > 0 && static_cast<std::size_t>(element.count) > rest / least) {
        if (header.encoding != Encoding::kAscii) fail_truncated(file, element, static_cast<std::int64_t>(rest / least));
        file.fail(
            fmt::format("the header announces {} vertices, more than the {} bytes after it can hold; the file is "
                        "truncated or its header wrong",
                        element.count, rest - 1));
      }
      for (std::size_t p = 0; p < element.properties.size(); ++p) {
        const PlyProperty& property = element.properties[p];
        if (property.count_type) continue;
        const auto n = static_cast<std::size_t>(element.count);
        if (property.name.size() == 1 && property.name[0] >= 'x' && property.name[0] <= 'z') {
          std::vector<double>& values = coordinates[static_cast<std::size_t>(property.name[0] - 'x')];
          values.resize(std::max<std::size_t>(n, 1));
          sink.scalar[p] = values.data();
        } else {
          geometry.properties.push_back({property.name, property.type, std::vector<double>(n)});
          sink.scalar[p] = geometry.properties.back().values.data();
        }
      }
      for (std::size_t axis = 0; axis < 3; ++axis)
        if (coordinates[axis].empty())
          file.fail(fmt::format("element 'vertex' has no property '{}'; expected x, y and z", "xyz"[axis]));
    } else if (element.name == "face") {
      sink.list = element.find_list({"vertex_indices", "vertex_index"});
      if (sink.list < 0 && element.count > 0)
        file.fail("element 'face' has no list 'vertex_indices'; expected 'property list uchar int vertex_indices'");
      if (geometry.first_corner_of_face.empty()) geometry.first_corner_of_face.push_back(0);
      sink.first = &geometry.first_corner_of_face;
      sink.items = &geometry.corners;
    } else if (element.name == "tristrips") {
      sink.list = element.find_list({"vertex_indices", "vertex_index"});
      sink.first = &first_of_strip;
      sink.items = &strips;
    } else if (element.name == "range_grid") {
      geometry.view_direction = Eigen::Vector3d::UnitZ();
      sink.list = element.find_list({"vertex_indices", "vertex_index"});
      first_of_cell.assign(1, 0);
      cells.clear();
      sink.first = &first_of_cell;
      sink.items = &cells;
    }
    data = header.encoding == Encoding::kAscii ? read_ascii_element(file, element, data, sink)
                                               : read_binary_element(file, element, data, swap, sink);
    if (is_vertex) {
      geometry.positions.resize(static_cast<std::size_t>(element.count));
      for (std::size_t i = 0; i < geometry.positions.size(); ++i)
        geometry.positions[i] = {coordinates[0][i], coordinates[1][i], coordinates[2][i]};
    }
    if (element.name == "tristrips") {
      if (geometry.first_corner_of_face.empty()) geometry.first_corner_of_face.push_back(0);
      append_strips(strips, geometry);
    }
  }
  if (!has_vertices) file.fail("has no element 'vertex'; expected points or a mesh");
  if (geometry.positions.empty()) file.fail("has no vertices; expected points or a mesh");
  if (geometry.num_faces() == 0) geometry.first_corner_of_face.clear();
  if (first_of_cell.size() > 1) add_grid_places(file, first_of_cell, cells, header.num_columns, geometry);
  check_faces(file, geometry);
  return geometry;
}

}  // namespace meshmser
