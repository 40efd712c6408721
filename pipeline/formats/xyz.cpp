#include "pipeline/formats/xyz.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <optional>

namespace meshmser {
namespace {

constexpr std::int64_t kMostPoints = std::numeric_limits<std::int32_t>::max();

/// How the lines of one file are written.
struct Layout {
  char separator = ' ';  // ' ': any run of blanks
  std::vector<std::string> columns;
  std::array<std::size_t, 3> coordinate{};
  std::vector<std::size_t> property_columns;
};

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

bool is_comment(std::string_view line) {
  return line.starts_with('#') || line.starts_with("//") || line.starts_with('%') || line.starts_with('!');
}

std::string_view without_comment_mark(std::string_view line) {
  while (!line.empty() && (line[0] == '#' || line[0] == '/' || line[0] == '%' || line[0] == '!' || is_blank(line[0])))
    line.remove_prefix(1);
  return line;
}

/// The words between separators, without blanks around them; a separator at the very end of the line adds none.
std::vector<std::string_view> split(std::string_view line, char separator) {
  std::vector<std::string_view> words;
  if (separator == ' ') {
    for (std::string_view word = take_word(line); !word.empty(); word = take_word(line)) words.push_back(word);
    return words;
  }
  while (!line.empty()) {
    const std::size_t at = std::min(line.find(separator), line.size());
    std::string_view word = line.substr(0, at);
    while (!word.empty() && is_blank(word.front())) word.remove_prefix(1);
    while (!word.empty() && is_blank(word.back())) word.remove_suffix(1);
    words.push_back(word);
    line.remove_prefix(std::min(at + 1, line.size()));
  }
  return words;
}

bool is_number(std::string_view word) {
  double value = 0;
  return !word.empty() && parse_number(word.data(), word.data() + word.size(), value) == word.data() + word.size();
}

char separator_of(std::string_view line, bool decimal_comma) {
  if (line.find(';') != std::string_view::npos) return ';';
  if (!decimal_comma && line.find(',') != std::string_view::npos) return ',';
  return ' ';
}

/// Names as in a header: lower case for x, y, z and without quotes.
std::vector<std::string> header_names(const std::vector<std::string_view>& words) {
  std::vector<std::string> names;
  for (std::string_view word : words) {
    if (word.size() >= 2 && word.front() == '"' && word.back() == '"') word = word.substr(1, word.size() - 2);
    std::string name(word);
    for (char& c : name)
      if (is_blank(c)) c = '_';
    names.push_back(name.size() == 1 ? lower_case(name) : name);
  }
  return names;
}

bool has_xyz(const std::vector<std::string>& names) {
  for (const char* axis : {"x", "y", "z"})
    if (std::find(names.begin(), names.end(), axis) == names.end()) return false;
  return true;
}

std::vector<std::string> default_names(std::size_t num_columns, bool is_pts) {
  if (is_pts && num_columns == 7) return {"x", "y", "z", "intensity", "red", "green", "blue"};
  if (is_pts && num_columns == 6) return {"x", "y", "z", "red", "green", "blue"};
  if (is_pts && num_columns == 4) return {"x", "y", "z", "intensity"};
  std::vector<std::string> names{"x", "y", "z"};
  for (std::size_t i = 3; i < num_columns; ++i) names.push_back(fmt::format("column{}", i + 1));
  return names;
}

class Reader {
 public:
  Reader(const FileBytes& file, const XyzOptions& options)
      : file_(file),
        options_(options),
        terminator_(line_terminator({file.begin(), file.size()})),
        is_pts_(lower_case(file.path().extension().string()) == ".pts") {}

  Geometry read() {
    refuse_binary();
    const char* begin = file_.begin();
    if (std::string_view(begin, file_.size()).starts_with("\xEF\xBB\xBF")) begin += 3;
    const char* first_point = find_layout(begin);
    reserve(first_point);
    Lines lines(first_point, file_.end(), terminator_);
    std::string_view line;
    while (lines.next(line)) {
      if (line.empty() || is_comment(line)) continue;
      read_line(line);
    }
    finish_block(file_.end());
    if (geometry_.positions.empty()) fail_without_points();
    geometry_.name = file_.name();
    return std::move(geometry_);
  }

 private:
  [[noreturn]] void fail(std::string_view line, const std::string& message) const {
    file_.fail_at(line.data(), message, terminator_);
  }

  void refuse_binary() const {
    const std::string_view start(file_.begin(), std::min<std::size_t>(file_.size(), 4096));
    if (start.starts_with("\xFF\xFE") || start.starts_with("\xFE\xFF"))
      file_.fail("is UTF-16 text; save it as UTF-8 or plain ASCII");
    if (const std::size_t at = start.find('\0'); at != std::string_view::npos)
      file_.fail(
          fmt::format("holds binary data (a zero byte at {}); expected text, or name its format with 'format'", at));
  }

  /// Reads what stands before the first point and decides on separator and columns. Returns where points begin.
  const char* find_layout(const char* begin) {
    Lines lines(begin, file_.end(), terminator_);
    std::string_view line, comment;
    std::optional<std::vector<std::string>> header;
    for (const char* start = lines.position(); lines.next(line); start = lines.position()) {
      if (line.empty()) continue;
      if (is_comment(line)) {
        comment = line;
        continue;
      }
      const char separator = separator_of(line, options_.decimal_comma);
      const std::vector<std::string_view> words = split(line, separator);
      const auto num_numbers = static_cast<std::size_t>(std::count_if(words.begin(), words.end(), is_number));
      std::int64_t count = 0;
      if (words.size() == 1 &&
          parse_integer(words[0].data(), words[0].data() + words[0].size(), count) ==
              words[0].data() + words[0].size() &&
          !block_size_) {
        begin_block(line, count);
        continue;
      }
      if (num_numbers == words.size() && words.size() >= 2) {
        choose_columns(line, separator, words.size(), header, comment);
        return start;
      }
      if (num_numbers == 0 && !header && std::any_of(line.begin(), line.end(), is_letter)) {
        header = header_names(words);
        continue;
      }
      if (!options_.skip_bad_lines) fail_as_first(line, words);
      ++geometry_.num_skipped_lines;
    }
    fail_without_points();
  }

  [[noreturn]] void fail_without_points() const {
    file_.fail(geometry_.num_skipped_lines == 0
                   ? std::string("holds no points; expected lines of numbers 'x y z'")
                   : fmt::format("holds no points: {} bad lines were skipped; expected lines of numbers 'x y z'",
                                 geometry_.num_skipped_lines));
  }

  [[noreturn]] void fail_as_first(std::string_view line, const std::vector<std::string_view>& words) const {
    for (const std::string_view word : words)
      if (!is_number(word)) {
        const bool comma = line.find(',') != std::string_view::npos && !options_.decimal_comma &&
                           word.find_first_of("0123456789") != std::string_view::npos;
        fail(line, fmt::format("{} is not a number; {}", in_quotes(word),
                               comma ? "if numbers have a decimal comma, set 'decimal_comma: true'"
                                     : "expected 'x y z' and further columns of numbers, or 'skip_bad_lines: true'"));
      }
    fail(line, fmt::format("{} has {} column{}; expected at least x, y and z", in_quotes(line), words.size(),
                           words.size() == 1 ? "" : "s"));
  }

  void choose_columns(std::string_view line, char separator, std::size_t num_columns,
                      const std::optional<std::vector<std::string>>& header, std::string_view comment) {
    layout_.separator = separator;
    if (!options_.columns.empty()) {
      layout_.columns = options_.columns;
      if (layout_.columns.size() != num_columns)
        fail(line, fmt::format("{} columns, but 'columns' names {} ({}); name every column, '_' for those to leave out",
                               num_columns, layout_.columns.size(), fmt::join(layout_.columns, " ")));
    } else if (header && header->size() == num_columns && has_xyz(*header)) {
      layout_.columns = *header;
    } else if (const auto names =
                   header_names(split(without_comment_mark(comment), separator_of(comment, options_.decimal_comma)));
               !header && names.size() == num_columns && has_xyz(names)) {
      layout_.columns = names;
    } else {
      if (header && header->size() == num_columns && !options_.skip_bad_lines && num_columns > 3)
        fail(line, fmt::format("the header names the columns {}, without x, y and z; say which they are with 'columns'",
                               fmt::join(*header, " ")));
      if (num_columns < 3)
        fail(line, fmt::format("{} has {} columns; expected at least x, y and z{}", in_quotes(line), num_columns,
                               comma_hint(line)));
      layout_.columns = default_names(num_columns, is_pts_);
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto found = std::find(layout_.columns.begin(), layout_.columns.end(), std::string(1, "xyz"[axis]));
      if (found == layout_.columns.end())
        file_.fail(fmt::format("'columns' ({}) does not name '{}'; expected x, y and z among them",
                               fmt::join(layout_.columns, " "), "xyz"[axis]));
      layout_.coordinate[axis] = static_cast<std::size_t>(found - layout_.columns.begin());
    }
    for (std::size_t i = 0; i < layout_.columns.size(); ++i) {
      const std::string& name = layout_.columns[i];
      if (name == "_" || std::find(layout_.coordinate.begin(), layout_.coordinate.end(), i) != layout_.coordinate.end())
        continue;
      if (std::find(layout_.columns.begin(), layout_.columns.begin() + static_cast<std::ptrdiff_t>(i), name) !=
          layout_.columns.begin() + static_cast<std::ptrdiff_t>(i))
        file_.fail(
            fmt::format("column '{}' is named twice; rename one with 'columns', or leave it out with '_'", name));
      layout_.property_columns.push_back(i);
      const bool is_colour = name == "red" || name == "green" || name == "blue" || name == "alpha";
      geometry_.properties.push_back({name, is_colour ? ValueType::kUint8 : ValueType::kFloat64, {}});
    }
    row_.resize(num_columns);
  }

  std::string comma_hint(std::string_view line) const {
    return line.find(',') != std::string_view::npos ? "; if numbers have a decimal comma, set 'decimal_comma: true'"
                                                    : "";
  }

  void reserve(const char* first_point) {
    // A guess from the length of the first lines; it is bounded by the size of the file.
    const char* stop = std::min(file_.end(), first_point + 65536);
    const std::int64_t lines = std::max<std::int64_t>(1, std::count(first_point, stop, terminator_));
    const auto guess =
        static_cast<std::size_t>(1.05 * static_cast<double>(lines) * static_cast<double>(file_.end() - first_point) /
                                 static_cast<double>(std::max<std::int64_t>(1, stop - first_point))) +
        16;
    geometry_.positions.reserve(guess);
    for (Property& property : geometry_.properties) property.values.reserve(guess);
  }

  void begin_block(std::string_view line, std::int64_t count) {
    if (count < 0) fail(line, fmt::format("{} points are announced; expected a whole number from 0", count));
    block_size_ = count;
    block_line_ = line;
    block_begin_ = static_cast<std::int64_t>(geometry_.num_vertices()) + geometry_.num_skipped_lines;
  }

  void finish_block(const char* at) const {
    if (!block_size_) return;
    const std::int64_t read =
        static_cast<std::int64_t>(geometry_.num_vertices()) + geometry_.num_skipped_lines - block_begin_;
    if (read == *block_size_ || options_.skip_bad_lines) return;
    file_.fail_at(
        at,
        fmt::format("{} points were announced in line {}, but {} follow; the file is truncated, or remove the count",
                    *block_size_, file_.line_of(block_line_.data(), terminator_), read),
        terminator_);
  }

  void read_line(std::string_view line) {
    if (parse_row(line)) {
      if (static_cast<std::int64_t>(geometry_.num_vertices()) >= kMostPoints)
        file_.fail(fmt::format("holds more than {} points; split the scan", kMostPoints));
      geometry_.positions.emplace_back(row_[layout_.coordinate[0]], row_[layout_.coordinate[1]],
                                       row_[layout_.coordinate[2]]);
      for (std::size_t i = 0; i < layout_.property_columns.size(); ++i)
        geometry_.properties[i].values.push_back(row_[layout_.property_columns[i]]);
      return;
    }
    std::int64_t count = 0;
    if (block_size_ && parse_integer(line.data(), line.data() + line.size(), count) == line.data() + line.size()) {
      // PTS files may hold several clouds, each after its count.
      finish_block(line.data());
      begin_block(line, count);
      return;
    }
    if (!options_.skip_bad_lines) fail_row(line);
    ++geometry_.num_skipped_lines;
  }

  /// Fills row_; false when the line is not a row of numbers.
  bool parse_row(std::string_view line) {
    const char* cursor = line.data();
    const char* const last = cursor + line.size();
    const std::size_t n = row_.size();
    for (std::size_t i = 0; i < n; ++i) {
      cursor = skip_blanks(cursor, last);
      cursor = parse_number(cursor, last, row_[i]);
      if (cursor == nullptr) return false;
      if (i + 1 == n) break;
      if (layout_.separator == ' ') {
        if (cursor == last || !is_blank(*cursor)) return false;
      } else {
        cursor = skip_blanks(cursor, last);
        if (cursor == last || *cursor != layout_.separator) return false;
        ++cursor;
      }
    }
    cursor = skip_blanks(cursor, last);
    if (cursor != last && *cursor == layout_.separator) ++cursor;  // one at the end of the line
    return cursor == last;
  }

  [[noreturn]] void fail_row(std::string_view line) const {
    const std::vector<std::string_view> words = split(line, layout_.separator);
    if (words.size() != row_.size())
      fail(line, fmt::format("{} has {} column{}; the lines before have {}; mend it, or set 'skip_bad_lines: true'{}",
                             in_quotes(line), words.size(), words.size() == 1 ? "" : "s", row_.size(),
                             comma_hint_if_blank(line)));
    for (const std::string_view word : words)
      if (!is_number(word))
        fail(line, fmt::format("{} is not a number; mend the line, or set 'skip_bad_lines: true'", in_quotes(word)));
    fail(line, fmt::format("{} is not a point; expected {} numbers", in_quotes(line), row_.size()));
  }

  std::string comma_hint_if_blank(std::string_view line) const {
    return layout_.separator == ' ' ? comma_hint(line) : std::string();
  }

  const FileBytes& file_;
  const XyzOptions& options_;
  char terminator_;
  bool is_pts_;
  Layout layout_;
  Geometry geometry_;
  std::vector<double> row_;
  std::optional<std::int64_t> block_size_;
  std::string_view block_line_;
  std::int64_t block_begin_ = 0;
};

}  // namespace

Geometry read_xyz(const FileBytes& file, const XyzOptions& options) {
  if (!options.decimal_comma) return Reader(file, options).read();
  auto data = std::make_unique_for_overwrite<char[]>(file.size() + 1);
  std::replace_copy(file.begin(), file.end() + 1, data.get(), ',', '.');
  const FileBytes with_points(file.path(), std::move(data), file.size());
  return Reader(with_points, options).read();
}

}  // namespace meshmser
