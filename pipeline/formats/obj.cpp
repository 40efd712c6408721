#include "pipeline/formats/obj.hpp"

#include <fmt/format.h>

#include <array>
#include <limits>

namespace meshmser {
namespace {

class ObjReader {
 public:
  explicit ObjReader(const FileBytes& file) : file_(file), terminator_(line_terminator({file.begin(), file.size()})) {}

  Geometry read() {
    Lines lines(file_.begin(), file_.end(), terminator_);
    std::string_view line;
    while (lines.next(line)) {
      if (!line.empty() && line.back() == '\\') {
        line_at_ = line.data();
        std::string joined(line.substr(0, line.size() - 1));
        while (lines.next(line)) {
          const bool more = !line.empty() && line.back() == '\\';
          joined += ' ';
          joined += line.substr(0, line.size() - (more ? 1 : 0));
          if (!more) break;
        }
        read_line(joined);
      } else {
        line_at_ = line.data();
        read_line(line);
      }
    }
    if (geometry_.positions.empty()) file_.fail("holds no vertices; expected lines 'v x y z'");
    if (!colours_[0].empty()) {
      constexpr std::array<const char*, 3> kNames{"red", "green", "blue"};
      for (std::size_t i = 0; i < 3; ++i)
        geometry_.properties.push_back({kNames[i], ValueType::kFloat64, std::move(colours_[i])});
    }
    geometry_.name = file_.name();
    return std::move(geometry_);
  }

 private:
  [[noreturn]] void fail(const std::string& message) const { file_.fail_at(line_at_, message, terminator_); }

  void read_line(std::string_view line) {
    const std::string_view whole = line;
    const std::string_view key = take_word(line);
    if (key == "v") {
      read_vertex(line, whole);
    } else if (key == "f") {
      read_face(line, whole);
    }
  }

  void read_vertex(std::string_view line, std::string_view whole) {
    std::array<double, 7> values{};
    std::size_t n = 0;
    for (std::string_view word = take_word(line); !word.empty(); word = take_word(line)) {
      if (word.starts_with('#')) break;
      if (n == values.size())
        fail(fmt::format("too many values for a vertex: {}; expected x y z, a weight, or a colour", in_quotes(whole)));
      if (parse_number(word.data(), word.data() + word.size(), values[n]) != word.data() + word.size())
        fail(fmt::format("{} is not a number; expected 'v x y z'", in_quotes(word)));
      ++n;
    }
    if (n < 3) fail(fmt::format("too few values for a vertex: {}; expected 'v x y z'", in_quotes(whole)));
    if (geometry_.positions.size() >= static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
      file_.fail("holds too many vertices; split the mesh");
    const bool coloured = n >= 6;
    if (!geometry_.positions.empty() && coloured != !colours_[0].empty())
      fail("some vertices have colours and some have none; expected all or none");
    geometry_.positions.emplace_back(values[0], values[1], values[2]);
    if (coloured)
      for (std::size_t i = 0; i < 3; ++i) colours_[i].push_back(values[n - 3 + i]);
  }

  void read_face(std::string_view line, std::string_view whole) {
    if (geometry_.first_corner_of_face.empty()) geometry_.first_corner_of_face.push_back(0);
    const auto num_vertices = static_cast<std::int64_t>(geometry_.num_vertices());
    std::int64_t n = 0;
    for (std::string_view word = take_word(line); !word.empty(); word = take_word(line)) {
      if (word.starts_with('#')) break;
      std::int64_t v = 0;
      const char* last = word.data() + word.size();
      const char* stop = parse_integer(word.data(), last, v);
      if (stop == nullptr || (stop != last && *stop != '/'))
        fail(fmt::format("{} is not a corner; expected 'f v v v' or 'f v/vt/vn ...'", in_quotes(word)));
      const std::int64_t index = v < 0 ? num_vertices + v : v - 1;
      if (v == 0 || index < 0 || index >= num_vertices)
        fail(fmt::format("the face names vertex {}; there are vertices 1 to {} before it", v, num_vertices));
      geometry_.corners.push_back(static_cast<std::int32_t>(index));
      ++n;
    }
    if (n < 3) fail(fmt::format("a face of {} corners: {}; expected at least 3", n, in_quotes(whole)));
    geometry_.first_corner_of_face.push_back(static_cast<std::int64_t>(geometry_.corners.size()));
  }

  const FileBytes& file_;
  char terminator_;
  const char* line_at_ = nullptr;
  Geometry geometry_;
  std::array<std::vector<double>, 3> colours_;
};

}  // namespace

Geometry read_obj(const FileBytes& file) {
  return ObjReader(file).read();
}

}  // namespace meshmser
