#include "pipeline/formats/file_bytes.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>

namespace meshmser {
namespace {

struct Descriptor {
  int value = -1;
  ~Descriptor() {
    if (value >= 0) ::close(value);
  }
};

/// `1.#QNAN` and its kin after the sign; nullptr when it is none of them.
const char* parse_windows_special(const char* first, const char* last, double& value) {
  if (last - first < 6 || first[0] != '1' || first[1] != '.' || first[2] != '#') return nullptr;
  const char* stop = first + 3;
  while (stop != last && std::isalnum(static_cast<unsigned char>(*stop))) ++stop;
  const std::string word = lower_case({first + 3, static_cast<std::size_t>(stop - first - 3)});
  if (word.starts_with("inf")) {
    value = std::numeric_limits<double>::infinity();
  } else if (word.starts_with("qnan") || word.starts_with("snan") || word.starts_with("ind") ||
             word.starts_with("nan")) {
    value = std::numeric_limits<double>::quiet_NaN();
  } else {
    return nullptr;
  }
  return stop;
}

}  // namespace

std::int64_t FileBytes::line_of(const char* position, char terminator) const {
  return 1 + std::count(begin(), std::min(position, end()), terminator);
}

void FileBytes::fail_at(const char* position, const std::string& message, char terminator) const {
  throw InputError(fmt::format("{}:{}: {}", path_.string(), line_of(position, terminator), message));
}

void FileBytes::fail(const std::string& message) const {
  throw InputError(fmt::format("{}: {}", path_.string(), message));
}

FileBytes read_file_bytes(const std::filesystem::path& path) {
  return read_file_head(path, std::numeric_limits<std::size_t>::max());
}

FileBytes read_file_head(const std::filesystem::path& path, std::size_t most) {
  auto fail = [&](const std::string& message) { throw InputError(fmt::format("{}: {}", path.string(), message)); };
  Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
  if (file.value < 0) {
    const int reason = errno;
    if (reason == ENOENT) fail("no such file; give the path of a scan, relative to the config file or absolute");
    fail(fmt::format("cannot be opened: {}; check the path and its permissions", std::strerror(reason)));
  }
  struct stat status {};
  if (::fstat(file.value, &status) != 0) fail(fmt::format("cannot be examined: {}", std::strerror(errno)));
  if (S_ISDIR(status.st_mode)) fail("is a folder; give a file, or list its files under 'files'");
  if (!S_ISREG(status.st_mode)) fail("is not a regular file; copy the data into a file first");
  if (status.st_size == 0) fail("is empty; expected a scan or a mesh");
  const std::size_t size = std::min(static_cast<std::size_t>(status.st_size), most);
  auto data = std::make_unique_for_overwrite<char[]>(size + 1);
  for (std::size_t done = 0; done < size;) {
    const ssize_t got = ::read(file.value, data.get() + done, size - done);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail(fmt::format("cannot be read: {}", std::strerror(errno)));
    if (got == 0) fail("was cut short while it was read; run again when it is no longer written to");
    done += static_cast<std::size_t>(got);
  }
  data[size] = '\0';
  return {path, std::move(data), size};
}

char line_terminator(std::string_view text) {
  return text.find('\n') == std::string_view::npos && text.find('\r') != std::string_view::npos ? '\r' : '\n';
}

bool Lines::next(std::string_view& line) {
  if (next_ >= end_) return false;
  const char* first = next_;
  const void* found = std::memchr(first, terminator_, static_cast<std::size_t>(end_ - first));
  const char* last = found == nullptr ? end_ : static_cast<const char*>(found);
  next_ = found == nullptr ? end_ : last + 1;
  first = skip_blanks(first, last);
  while (last != first && is_blank(last[-1])) --last;
  line = {first, static_cast<std::size_t>(last - first)};
  return true;
}

bool Lines::next_filled(std::string_view& line) {
  while (next(line))
    if (!line.empty()) return true;
  return false;
}

const char* parse_number(const char* first, const char* last, double& value) {
  if (first != last && *first == '+') {
    ++first;
    if (first != last && (*first == '-' || *first == '+')) return nullptr;
  }
  const std::from_chars_result result = std::from_chars(first, last, value);
  if (result.ec == std::errc() && (result.ptr == last || *result.ptr != '#')) return result.ptr;
  if (result.ec == std::errc::result_out_of_range) {
    // An exponent that a double lacks: too small is zero, too large infinite.
    const std::string text(first, result.ptr);
    value = std::strtod(text.c_str(), nullptr);
    return result.ptr;
  }
  const bool negative = first != last && *first == '-';
  const char* stop = parse_windows_special(negative ? first + 1 : first, last, value);
  if (stop != nullptr && negative) value = -value;
  return stop;
}

const char* parse_integer(const char* first, const char* last, std::int64_t& value) {
  if (first != last && *first == '+') ++first;
  const std::from_chars_result result = std::from_chars(first, last, value);
  return result.ec == std::errc() ? result.ptr : nullptr;
}

std::string_view take_word(std::string_view& line) {
  std::size_t first = 0;
  while (first < line.size() && is_blank(line[first])) ++first;
  std::size_t last = first;
  while (last < line.size() && !is_blank(line[last])) ++last;
  const std::string_view word = line.substr(first, last - first);
  line.remove_prefix(last);
  return word;
}

std::string in_quotes(std::string_view text) {
  constexpr std::size_t kShown = 40;
  std::string result = "'";
  for (const char c : text.substr(0, kShown)) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7f) {
      result += fmt::format("\\x{:02x}", byte);
    } else {
      result += c;
    }
  }
  return result + (text.size() > kShown ? "...'" : "'");
}

std::string lower_case(std::string_view text) {
  std::string result(text);
  for (char& c : result)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return result;
}

}  // namespace meshmser
