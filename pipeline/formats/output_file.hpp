#pragma once
/// Files written by the megabyte, with numbers in their shortest form that reads back the same.

#include <charconv>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>

#include "pipeline/execution/error.hpp"

namespace meshmser {

/// A new file, written through a large buffer. Throws CacheError naming the file when the disk fails. Nothing is
/// promised about the file until `finish` has returned.
class OutputFile {
 public:
  explicit OutputFile(const std::filesystem::path& path);
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  ~OutputFile();

  void text(std::string_view value) { bytes(value.data(), value.size()); }
  void character(char value) {
    char* place = reserve(1);
    *place = value;
    used_ += 1;
  }
  /// Shortest decimal form that reads back as the same double (std::to_chars).
  void number(double value) { put_number(value); }
  void number(std::int64_t value) { put_number(value); }
  void bytes(const void* data, std::size_t size);
  /// Writes what is left and closes.
  void finish();

 private:
  static constexpr std::size_t kBuffer = std::size_t{1} << 20;
  char* reserve(std::size_t size) {
    if (used_ + size > kBuffer) flush();
    return buffer_.data() + used_;
  }
  template <class Number>
  void put_number(Number value) {
    char* place = reserve(40);
    used_ += static_cast<std::size_t>(std::to_chars(place, place + 40, value).ptr - place);
  }
  void flush();
  [[noreturn]] void fail(const char* what) const;

  std::filesystem::path path_;
  int descriptor_ = -1;
  std::string buffer_;
  std::size_t used_ = 0;
};

}  // namespace meshmser
