#include "pipeline/formats/pcd.hpp"

#include <fmt/format.h>
#include <pcl/console/print.h>
#include <pcl/io/pcd_io.h>

#include <bit>
#include <cstring>
#include <limits>
#include <sstream>

namespace meshmser {
namespace {

struct Field {
  std::string name;
  ValueType type = ValueType::kFloat32;
  std::size_t size = 4, count = 1, offset = 0;
  bool is_wide_integer = false;  // 8 bytes: read as a double, rounded beyond 2^53
  bool is_signed = false;
};

struct Header {
  std::vector<Field> fields;
  std::int64_t num_points = 0;
  std::size_t point_size = 0;
  Eigen::Vector3d viewpoint = Eigen::Vector3d::Zero();
  std::string encoding;
  const char* data = nullptr;
};

class HeaderReader {
 public:
  explicit HeaderReader(const FileBytes& file) : file_(file) {}

  Header read() {
    Lines lines(file_.begin(), file_.end());
    std::string_view line;
    std::vector<std::string> names, sizes, types, counts;
    std::int64_t width = -1, height = 1, points = -1;
    while (header_.encoding.empty() && lines.next(line)) {
      line_ = line;
      if (line.empty() || line.starts_with('#')) continue;
      const std::string_view key = take_word(line);
      if (key == "FIELDS" || key == "COLUMNS") {
        names = words(line);
      } else if (key == "SIZE") {
        sizes = words(line);
      } else if (key == "TYPE") {
        types = words(line);
      } else if (key == "COUNT") {
        counts = words(line);
      } else if (key == "WIDTH") {
        width = whole(line);
      } else if (key == "HEIGHT") {
        height = whole(line);
      } else if (key == "POINTS") {
        points = whole(line);
      } else if (key == "VIEWPOINT") {
        for (int axis = 0; axis < 3; ++axis) {
          const std::string_view word = take_word(line);
          if (parse_number(word.data(), word.data() + word.size(), header_.viewpoint[axis]) !=
                  word.data() + word.size() ||
              word.empty())
            fail("is not a viewpoint; expected 'VIEWPOINT x y z qw qx qy qz'");
        }
      } else if (key == "DATA") {
        header_.encoding = std::string(take_word(line));
        if (header_.encoding != "ascii" && header_.encoding != "binary" && header_.encoding != "binary_compressed")
          fail("is not a known encoding; expected 'DATA ascii', 'DATA binary' or 'DATA binary_compressed'");
      } else if (key != "VERSION") {
        fail(
            "is not a PCD header line; expected VERSION, FIELDS, SIZE, TYPE, COUNT, WIDTH, HEIGHT, VIEWPOINT, POINTS "
            "or DATA");
      }
    }
    if (header_.encoding.empty()) file_.fail("the header has no 'DATA' line; the file is cut short or not a PCD file");
    header_.data = lines.position();
    make_fields(names, sizes, types, counts);
    header_.num_points = points >= 0 ? points : width * height;
    if (header_.num_points <= 0) file_.fail("the header announces no points; expected POINTS, or WIDTH and HEIGHT");
    if (header_.num_points > std::numeric_limits<std::int32_t>::max())
      file_.fail(fmt::format("the header announces {} points; at most {} are possible", header_.num_points,
                             std::numeric_limits<std::int32_t>::max()));
    if (width >= 0 && height > 0 && (width > header_.num_points || width * height != header_.num_points))
      file_.fail(fmt::format("the header announces {} points, but WIDTH {} x HEIGHT {}; make them agree",
                             header_.num_points, width, height));
    return std::move(header_);
  }

 private:
  [[noreturn]] void fail(const std::string& message) const {
    file_.fail_at(line_.data(), fmt::format("{} {}", in_quotes(line_), message));
  }

  static std::vector<std::string> words(std::string_view line) {
    std::vector<std::string> result;
    for (std::string_view word = take_word(line); !word.empty(); word = take_word(line)) result.emplace_back(word);
    return result;
  }

  std::int64_t whole(std::string_view line) const {
    const std::string_view word = take_word(line);
    std::int64_t value = 0;
    if (word.empty() || parse_integer(word.data(), word.data() + word.size(), value) != word.data() + word.size() ||
        value < 0 || value > (std::int64_t{1} << 40))
      fail("has no sensible number; expected a whole number from 0");
    return value;
  }

  void make_fields(const std::vector<std::string>& names, const std::vector<std::string>& sizes,
                   const std::vector<std::string>& types, const std::vector<std::string>& counts) {
    if (names.empty()) file_.fail("the header has no 'FIELDS' line; expected 'FIELDS x y z ...'");
    if (sizes.size() != names.size() || types.size() != names.size() ||
        (!counts.empty() && counts.size() != names.size()))
      file_.fail(fmt::format(
          "the header has {} fields, {} sizes, {} types and {} counts; expected one of each for every field",
          names.size(), sizes.size(), types.size(), counts.size()));
    for (std::size_t i = 0; i < names.size(); ++i) {
      Field field;
      field.name = names[i];
      const std::string kind = types[i] + sizes[i];
      static const std::vector<std::pair<std::string, ValueType>> kKinds{
          {"I1", ValueType::kInt8},    {"U1", ValueType::kUint8},   {"I2", ValueType::kInt16},
          {"U2", ValueType::kUint16},  {"I4", ValueType::kInt32},   {"U4", ValueType::kUint32},
          {"F4", ValueType::kFloat32}, {"F8", ValueType::kFloat64}, {"I8", ValueType::kFloat64},
          {"U8", ValueType::kFloat64}};
      const auto known = std::find_if(kKinds.begin(), kKinds.end(), [&](const auto& k) { return k.first == kind; });
      if (known == kKinds.end())
        file_.fail(
            fmt::format("field '{}' has type {} and size {}; expected I or U of 1, 2, 4 or 8 bytes, or F of 4 or 8",
                        names[i], types[i], sizes[i]));
      field.type = known->second;
      field.size = static_cast<std::size_t>(sizes[i][0] - '0');
      field.is_wide_integer = kind == "I8" || kind == "U8";
      field.is_signed = types[i] == "I";
      if (!counts.empty()) {
        std::int64_t count = 0;
        if (parse_integer(counts[i].data(), counts[i].data() + counts[i].size(), count) == nullptr || count < 1 ||
            count > 100'000)
          file_.fail(
              fmt::format("field '{}' has count {}; expected a whole number from 1", names[i], in_quotes(counts[i])));
        field.count = static_cast<std::size_t>(count);
      }
      field.offset = header_.point_size;
      header_.point_size += field.size * field.count;
      header_.fields.push_back(field);
    }
  }

  const FileBytes& file_;
  std::string_view line_;
  Header header_;
};

template <class Number>
double load_as(const char* bytes) {
  Number value;
  std::memcpy(&value, bytes, sizeof(value));
  return static_cast<double>(value);
}

double load_value(const Field& field, const char* bytes) {
  if (field.is_wide_integer) return field.is_signed ? load_as<std::int64_t>(bytes) : load_as<std::uint64_t>(bytes);
  switch (field.type) {
    case ValueType::kInt8:
      return load_as<std::int8_t>(bytes);
    case ValueType::kUint8:
      return load_as<std::uint8_t>(bytes);
    case ValueType::kInt16:
      return load_as<std::int16_t>(bytes);
    case ValueType::kUint16:
      return load_as<std::uint16_t>(bytes);
    case ValueType::kInt32:
      return load_as<std::int32_t>(bytes);
    case ValueType::kUint32:
      return load_as<std::uint32_t>(bytes);
    case ValueType::kFloat32:
      return load_as<float>(bytes);
    case ValueType::kFloat64:
      return load_as<double>(bytes);
  }
  return 0;
}

/// One array a field, or none for fields of several values and padding.
using Columns = std::vector<std::vector<double>>;

Columns make_columns(const Header& header) {
  Columns columns(header.fields.size());
  for (std::size_t f = 0; f < columns.size(); ++f)
    if (header.fields[f].count == 1 && header.fields[f].name != "_")
      columns[f].resize(static_cast<std::size_t>(header.num_points));
  return columns;
}

Columns read_ascii(const FileBytes& file, const Header& header) {
  std::size_t num_values = 0;
  for (const Field& field : header.fields) num_values += field.count;
  const std::int64_t rest = file.end() - header.data;
  if (header.num_points > rest / static_cast<std::int64_t>(2 * num_values) + 1)
    file.fail(
        fmt::format("the header announces {} points, more than the {} bytes after it can hold; the file is truncated "
                    "or its header wrong",
                    header.num_points, rest));
  Columns columns = make_columns(header);
  Lines lines(header.data, file.end());
  std::string_view line;
  for (std::int64_t row = 0; row < header.num_points; ++row) {
    if (!lines.next_filled(line))
      file.fail_at(file.end(), fmt::format("the file ends before point {} of {}; it is truncated, copy it again", row,
                                           header.num_points));
    const std::string_view whole = line;
    for (std::size_t f = 0; f < header.fields.size(); ++f)
      for (std::size_t k = 0; k < header.fields[f].count; ++k) {
        const std::string_view word = take_word(line);
        double value = 0;
        if (word.empty())
          file.fail_at(whole.data(),
                       fmt::format("too few values for a point: {}; expected {}", in_quotes(whole), num_values));
        if (parse_number(word.data(), word.data() + word.size(), value) != word.data() + word.size())
          file.fail_at(whole.data(),
                       fmt::format("{} is not a number; expected {} of them", in_quotes(word), num_values));
        if (!columns[f].empty()) columns[f][static_cast<std::size_t>(row)] = value;
      }
    if (!take_word(line).empty())
      file.fail_at(whole.data(),
                   fmt::format("too many values for a point: {}; expected {}", in_quotes(whole), num_values));
  }
  return columns;
}

Columns read_binary(const FileBytes& file, const Header& header) {
  const auto rest = static_cast<std::uint64_t>(file.end() - header.data);
  const std::uint64_t needed = static_cast<std::uint64_t>(header.num_points) * header.point_size;
  const bool compressed = header.encoding == "binary_compressed";
  if (compressed) {
    std::uint32_t sizes[2] = {0, 0};  // compressed, uncompressed
    if (rest >= sizeof(sizes)) std::memcpy(sizes, header.data, sizeof(sizes));
    if (rest < sizeof(sizes) || rest - sizeof(sizes) < sizes[0])
      file.fail(
          fmt::format("ends at byte {} inside its compressed data; the file is truncated, copy it again", file.size()));
    constexpr std::uint64_t kMostRatio = 100;  // LZF packs at most 264 bytes into 3
    if (sizes[1] != needed || needed > kMostRatio * sizes[0])
      file.fail(
          fmt::format("its compressed data hold {} bytes, but {} points of {} bytes are announced; the file is damaged",
                      sizes[1], header.num_points, header.point_size));
  } else if (rest < needed) {
    file.fail(fmt::format("ends at byte {} inside point {} of {}; the file is truncated, copy it again", file.size(),
                          rest / header.point_size, header.num_points));
  }
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);  // PCL prints its errors; ours are thrown
  pcl::PCDReader reader;
  pcl::PCLPointCloud2 cloud;
  Eigen::Vector4f origin;
  Eigen::Quaternionf orientation;
  int version = 0, data_type = 0;
  unsigned int data_index = 0;
  std::istringstream head(std::string(file.begin(), static_cast<std::size_t>(header.data - file.begin())));
  if (reader.readHeader(head, cloud, origin, orientation, version, data_type, data_index) != 0)
    file.fail("PCL cannot read its header; write the file again, or save it as PLY");
  if (cloud.point_step != header.point_size ||
      std::uint64_t{cloud.width} * cloud.height != static_cast<std::uint64_t>(header.num_points))
    file.fail("its header is not consistent; write the file again, or save it as PLY");
  if (reader.readBodyBinary(reinterpret_cast<const unsigned char*>(file.begin()), cloud, version, compressed,
                            static_cast<unsigned int>(header.data - file.begin())) != 0)
    file.fail("its data are damaged: they do not decompress; copy the file again");
  if (cloud.data.size() < needed) file.fail("its data are damaged: fewer bytes than announced; copy the file again");
  Columns columns = make_columns(header);
  for (std::size_t f = 0; f < columns.size(); ++f) {
    const char* from = reinterpret_cast<const char*>(cloud.data.data()) + header.fields[f].offset;
    for (double& value : columns[f]) {
      value = load_value(header.fields[f], from);
      from += header.point_size;
    }
  }
  return columns;
}

void add_colours(Geometry& geometry, const Field& field, const std::vector<double>& packed) {
  const bool has_alpha = field.name == "rgba";
  std::vector<Property> colours;
  for (const char* name : {"red", "green", "blue", "alpha"})
    if (has_alpha || name[0] != 'a') colours.push_back({name, ValueType::kUint8, {}});
  for (const double value : packed) {
    const std::uint32_t bits = field.type == ValueType::kFloat32
                                   ? std::bit_cast<std::uint32_t>(static_cast<float>(value))
                                   : static_cast<std::uint32_t>(static_cast<std::int64_t>(value));
    for (std::size_t i = 0; i < colours.size(); ++i)
      colours[i].values.push_back(bits >> (i == 3 ? 24 : 16 - 8 * i) & 255);
  }
  for (Property& colour : colours) geometry.properties.push_back(std::move(colour));
}

}  // namespace

Geometry read_pcd(const FileBytes& file) {
  const Header header = HeaderReader(file).read();
  Columns columns = header.encoding == "ascii" ? read_ascii(file, header) : read_binary(file, header);
  Geometry geometry;
  geometry.name = file.name();
  std::array<const std::vector<double>*, 3> coordinates{};
  for (std::size_t f = 0; f < header.fields.size(); ++f) {
    const Field& field = header.fields[f];
    if (columns[f].empty()) continue;
    if (field.name.size() == 1 && field.name[0] >= 'x' && field.name[0] <= 'z') {
      coordinates[static_cast<std::size_t>(field.name[0] - 'x')] = &columns[f];
    } else if ((field.name == "rgb" || field.name == "rgba") && field.size == 4) {
      add_colours(geometry, field, columns[f]);
    } else {
      geometry.properties.push_back({field.name == "normal_x"   ? "nx"
                                     : field.name == "normal_y" ? "ny"
                                     : field.name == "normal_z" ? "nz"
                                                                : field.name,
                                     field.type, std::move(columns[f])});
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (coordinates[axis] == nullptr) file.fail(fmt::format("has no field '{}'; expected x, y and z", "xyz"[axis]));
  geometry.positions.resize(static_cast<std::size_t>(header.num_points));
  for (std::size_t i = 0; i < geometry.positions.size(); ++i)
    geometry.positions[i] = {(*coordinates[0])[i], (*coordinates[1])[i], (*coordinates[2])[i]};
  if (!header.viewpoint.isZero(0)) geometry.scanner_position = header.viewpoint;
  return geometry;
}

}  // namespace meshmser
