#pragma once
/// Whole files in memory, their lines, and the numbers in them: what every reader here is made of.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "pipeline/execution/error.hpp"

namespace meshmser {

/// The bytes of a file, followed by one zero byte that is not counted.
class FileBytes {
 public:
  FileBytes(std::filesystem::path path, std::unique_ptr<char[]> data, std::size_t size)
      : path_(std::move(path)), data_(std::move(data)), size_(size) {}
  const std::filesystem::path& path() const { return path_; }
  std::string name() const { return path_.filename().string(); }
  char* begin() { return data_.get(); }
  const char* begin() const { return data_.get(); }
  const char* end() const { return data_.get() + size_; }
  std::size_t size() const { return size_; }
  /// Number of the line, from 1, that `position` lies in; lines end with `terminator`. O(bytes before it).
  std::int64_t line_of(const char* position, char terminator = '\n') const;
  /// Throws InputError "path:line: message" for the line that holds `position`.
  [[noreturn]] void fail_at(const char* position, const std::string& message, char terminator = '\n') const;
  /// Throws InputError "path: message".
  [[noreturn]] void fail(const std::string& message) const;

 private:
  std::filesystem::path path_;
  std::unique_ptr<char[]> data_;
  std::size_t size_;
};

/// Reads a regular file at once. Throws InputError when it does not exist, is a folder, may not be read, is empty, or
/// is cut short while it is read. O(bytes).
FileBytes read_file_bytes(const std::filesystem::path& path);

/// As read_file_bytes, but at most the first `most` bytes.
FileBytes read_file_head(const std::filesystem::path& path, std::size_t most);

/// What ends a line: '\n', or '\r' for text without any '\n' (old Macintosh files).
char line_terminator(std::string_view text);

/// Walks over the lines of a text in memory, without copying.
class Lines {
 public:
  Lines(const char* begin, const char* end, char terminator = '\n')
      : next_(begin), end_(end), terminator_(terminator) {}
  /// The next line without its end and without blanks around it; false after the last.
  bool next(std::string_view& line);
  /// As `next`, over lines that are not empty.
  bool next_filled(std::string_view& line);
  /// Where the line after the current one begins.
  const char* position() const { return next_; }

 private:
  const char* next_;
  const char* end_;
  char terminator_;
};

/// Reads one number at `first`: decimal or exponent form, a sign, `nan` and `inf` in any case, and the forms `1.#QNAN`,
/// `-1.#IND`, `1.#INF` of older Windows programs. Beyond the range of a double: infinity or zero.
/// Returns the place after it, or nullptr when there is no number. Independent of the locale.
const char* parse_number(const char* first, const char* last, double& value);

/// Reads one whole number; nullptr when there is none or it does not fit.
const char* parse_integer(const char* first, const char* last, std::int64_t& value);

inline bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}
inline const char* skip_blanks(const char* first, const char* last) {
  while (first != last && is_blank(*first)) ++first;
  return first;
}
/// Takes the next word, up to a blank, off the front of `line`; empty at its end.
std::string_view take_word(std::string_view& line);
/// For messages: the text in quotes, shortened, with unprintable bytes as \xNN.
std::string in_quotes(std::string_view text);
std::string lower_case(std::string_view text);

}  // namespace meshmser
