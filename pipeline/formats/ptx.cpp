#include "pipeline/formats/ptx.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <limits>

namespace meshmser {
namespace {

class PtxReader {
 public:
  explicit PtxReader(const FileBytes& file)
      : file_(file),
        terminator_(line_terminator({file.begin(), file.size()})),
        lines_(file.begin(), file.end(), terminator_) {}

  std::vector<Geometry> read() {
    std::vector<Geometry> scans;
    while (lines_.next_filled(line_)) {
      scans.push_back(read_scan());
      total_ += static_cast<std::int64_t>(scans.back().num_vertices());
      if (total_ > std::numeric_limits<std::int32_t>::max()) file_.fail("holds too many points; split the file");
    }
    if (total_ == 0) file_.fail("holds no measured points; expected scans in PTX form");
    for (std::size_t i = 0; i < scans.size(); ++i)
      scans[i].name = scans.size() == 1 ? file_.name() : fmt::format("{} #{}", file_.name(), i + 1);
    return scans;
  }

 private:
  [[noreturn]] void fail(const std::string& message) const { file_.fail_at(line_.data(), message, terminator_); }

  void next_line(const char* wanted) {
    if (!lines_.next_filled(line_))
      file_.fail_at(file_.end(), fmt::format("the file ends before {}; it is truncated, copy it again", wanted),
                    terminator_);
  }

  /// The line's numbers; fails unless there are between `least` and `most`.
  std::size_t numbers(std::array<double, 7>& values, std::size_t least, std::size_t most, const char* wanted) const {
    const char* cursor = line_.data();
    const char* const last = cursor + line_.size();
    std::size_t n = 0;
    for (cursor = skip_blanks(cursor, last); cursor != last; cursor = skip_blanks(cursor, last)) {
      double value = 0;
      const char* stop = parse_number(cursor, last, value);
      if (stop == nullptr || (stop != last && !is_blank(*stop)) || n == most)
        fail(fmt::format("{} is not {}", in_quotes(line_), wanted));
      values[n++] = value;
      cursor = stop;
    }
    if (n < least) fail(fmt::format("{} is not {}", in_quotes(line_), wanted));
    return n;
  }

  std::int64_t count(const char* what) const {
    std::int64_t value = 0;
    const char* last = line_.data() + line_.size();
    if (parse_integer(line_.data(), last, value) != last || value < 0)
      fail(fmt::format(
          "{} is not the number of {}; expected a whole number (PTX begins with the columns and rows of its grid)",
          in_quotes(line_), what));
    return value;
  }

  /// With line_ at the first line of a scan's header.
  Geometry read_scan() {
    std::array<double, 7> v{};
    const std::int64_t columns = count("columns");
    next_line("the number of rows");
    const std::int64_t rows = count("rows");
    const std::int64_t bytes = file_.end() - lines_.position();
    if (rows > 0 && columns > (bytes / 6 + 1) / rows)  // "0 0 0\n" is the shortest cell
      fail(fmt::format(
          "a grid of {} x {} cells does not fit into the {} bytes that follow; the file is truncated or its head wrong",
          columns, rows, bytes));
    Geometry geometry;
    next_line("the scanner's position");
    numbers(v, 3, 3, "the scanner's position; expected three numbers");
    const Eigen::Vector3d position(v[0], v[1], v[2]);
    for (int axis = 0; axis < 3; ++axis) {
      next_line("the scanner's axes");
      numbers(v, 3, 3, "an axis of the scanner; expected three numbers");
    }
    Eigen::Matrix4d matrix;
    for (int row = 0; row < 4; ++row) {
      next_line("the four rows of the matrix");
      numbers(v, 4, 4, "a row of the 4 x 4 matrix; expected four numbers");
      matrix.col(row) << v[0], v[1], v[2], v[3];  // PTX multiplies row vectors from the left
    }
    if (!matrix.allFinite() || matrix.row(3) != Eigen::RowVector4d(0, 0, 0, 1))
      fail("the matrix is not a motion: expected 0 0 0 1 in its last column and the translation in its last row");
    const Eigen::Affine3d world_from_scan(matrix);
    const bool moved = !matrix.isIdentity(0);
    // The scanner stands at the origin of its own points; the stated position is the same place in the world.
    geometry.scanner_position = moved ? Eigen::Vector3d(world_from_scan.translation()) : position;
    const std::int64_t cells = columns * rows;
    geometry.positions.reserve(static_cast<std::size_t>(std::min(cells, bytes / 12)));
    std::size_t width = 0;
    std::vector<double> line, place;
    for (std::int64_t cell = 0; cell < cells; ++cell) {
      next_line("the last cell of the grid");
      const std::size_t n = numbers(v, 3, 7, "a cell of the grid; expected x y z, an intensity and a colour");
      if (width == 0) {
        if (n == 5) fail(fmt::format("{} has 5 columns; expected 3, 4, 6 or 7", in_quotes(line_)));
        width = n;
        if (n == 4 || n == 7) geometry.properties.push_back({"intensity", ValueType::kFloat32, {}});
        if (n >= 6)
          for (const char* colour : {"red", "green", "blue"})
            geometry.properties.push_back({colour, ValueType::kUint8, {}});
      }
      if (n != width) fail(fmt::format("{} has {} columns; the cells before have {}", in_quotes(line_), n, width));
      if (v[0] == 0 && v[1] == 0 && v[2] == 0) {
        ++geometry.num_empty_cells;
        continue;
      }
      const Eigen::Vector3d p(v[0], v[1], v[2]);
      geometry.positions.push_back(moved ? Eigen::Vector3d(world_from_scan * p) : p);
      for (std::size_t i = 3; i < n; ++i) geometry.properties[i - 3].values.push_back(v[i]);
      line.push_back(static_cast<double>(cell / rows));
      place.push_back(static_cast<double>(cell % rows));
    }
    geometry.properties.push_back({kGridLine, ValueType::kInt32, std::move(line)});
    geometry.properties.push_back({kGridPlace, ValueType::kInt32, std::move(place)});
    return geometry;
  }

  const FileBytes& file_;
  char terminator_;
  Lines lines_;
  std::string_view line_;
  std::int64_t total_ = 0;
};

}  // namespace

std::vector<Geometry> read_ptx(const FileBytes& file) {
  return PtxReader(file).read();
}

}  // namespace meshmser
