#include "pipeline/formats/stl.hpp"

#include <fmt/format.h>

#include <bit>
#include <cstring>
#include <limits>

namespace meshmser {
namespace {

constexpr std::size_t kHead = 84, kFacet = 50;
constexpr std::size_t kMostFacets = std::numeric_limits<std::int32_t>::max() / 3;

void close_face(Geometry& geometry) {
  if (geometry.first_corner_of_face.empty()) geometry.first_corner_of_face.push_back(0);
  for (int k = 0; k < 3; ++k) geometry.corners.push_back(static_cast<std::int32_t>(geometry.corners.size()));
  geometry.first_corner_of_face.push_back(static_cast<std::int64_t>(geometry.corners.size()));
}

float little_endian_float(const char* bytes) {
  std::uint32_t bits;
  std::memcpy(&bits, bytes, sizeof(bits));
  if constexpr (std::endian::native == std::endian::big) bits = __builtin_bswap32(bits);
  return std::bit_cast<float>(bits);
}

Geometry read_binary(const FileBytes& file, std::size_t num_facets) {
  if (num_facets == 0) file.fail("holds no facets; expected a mesh");
  if (num_facets > kMostFacets)
    file.fail(fmt::format("announces {} facets; at most {} are possible", num_facets, kMostFacets));
  if (file.size() < kHead + kFacet * num_facets)
    file.fail(fmt::format("ends at byte {} inside facet {} of {}; the file is truncated, copy it again", file.size(),
                          (file.size() - kHead) / kFacet, num_facets));
  Geometry geometry;
  geometry.positions.reserve(3 * num_facets);
  for (std::size_t f = 0; f < num_facets; ++f) {
    const char* at = file.begin() + kHead + kFacet * f + 12;
    for (int k = 0; k < 3; ++k, at += 12)
      geometry.positions.emplace_back(little_endian_float(at), little_endian_float(at + 4),
                                      little_endian_float(at + 8));
    close_face(geometry);
  }
  return geometry;
}

Geometry read_ascii(const FileBytes& file) {
  const char terminator = line_terminator({file.begin(), file.size()});
  Lines lines(file.begin(), file.end(), terminator);
  Geometry geometry;
  std::string_view line;
  // The corners of the facet being read; -1: between facets.
  int corners = -1;
  bool ended = false;
  while (lines.next_filled(line)) {
    const std::string_view whole = line;
    const std::string key = lower_case(take_word(line));
    auto fail = [&](const std::string& message) { file.fail_at(whole.data(), message, terminator); };
    if (key == "facet") {
      if (corners >= 0) fail("a facet begins inside another; expected 'endfacet' before it");
      corners = 0;
    } else if (key == "vertex") {
      if (corners < 0) fail("a vertex outside a facet; expected 'facet normal' before it");
      if (corners == 3) fail("a fourth vertex in a facet; expected three");
      Eigen::Vector3d p;
      for (int axis = 0; axis < 3; ++axis) {
        const std::string_view word = take_word(line);
        if (word.empty() || parse_number(word.data(), word.data() + word.size(), p[axis]) != word.data() + word.size())
          fail(fmt::format("{} is not a number; expected 'vertex x y z'", in_quotes(word)));
      }
      if (!take_word(line).empty())
        fail(fmt::format("too many values for a vertex: {}; expected 'vertex x y z'", in_quotes(whole)));
      geometry.positions.push_back(p);
      ++corners;
    } else if (key == "endfacet") {
      if (corners != 3) fail(fmt::format("a facet of {} vertices; expected three", std::max(corners, 0)));
      if (geometry.positions.size() / 3 > kMostFacets) file.fail("holds too many facets; split the mesh");
      close_face(geometry);
      corners = -1;
    } else if (key == "endsolid") {
      ended = true;
    } else if (key == "solid") {
      ended = false;
    } else if (key != "outer" && key != "endloop") {
      fail(fmt::format("unknown word {}; expected solid, facet, outer, vertex, endloop, endfacet or endsolid",
                       in_quotes(key)));
    }
  }
  if (corners >= 0 || !ended)
    file.fail_at(file.end(), "the file ends without 'endsolid'; it is truncated, copy it again", terminator);
  if (geometry.positions.empty()) file.fail("holds no facets; expected a mesh");
  return geometry;
}

}  // namespace

Geometry read_stl(const FileBytes& file) {
  Geometry geometry;
  std::size_t announced = 0;
  if (file.size() >= kHead) {
    std::uint32_t count;
    std::memcpy(&count, file.begin() + 80, sizeof(count));
    if constexpr (std::endian::native == std::endian::big) count = __builtin_bswap32(count);
    announced = count;
  }
  // Binary files may begin with 'solid' too; their size tells, and zero bytes do.
  const std::string_view bytes(file.begin(), file.size());
  const bool fits = file.size() >= kHead && file.size() == kHead + kFacet * announced;
  const bool is_text = bytes.starts_with("solid") && !fits && bytes.substr(0, 512).find('\0') == std::string_view::npos;
  if (is_text) {
    geometry = read_ascii(file);
  } else if (file.size() < kHead) {
    file.fail(fmt::format("has {} bytes and does not begin with 'solid'; a binary STL file has at least {}",
                          file.size(), kHead));
  } else {
    geometry = read_binary(file, announced);
  }
  geometry.name = file.name();
  geometry.loose_facets = true;
  return geometry;
}

}  // namespace meshmser
