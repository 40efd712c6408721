#include "pipeline/formats/geometry_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "pipeline/formats/ply.hpp"

namespace meshmser {
namespace {

constexpr std::array<std::string_view, 2> kFormats{"ply", "xyz"};

/// The format by content where it can be told, else by extension; empty: unknown.
std::string format_of(const FileBytes& file) {
  const std::string_view start(file.begin(), std::min<std::size_t>(file.size(), 512));
  if (start.starts_with("ply\n") || start.starts_with("ply\r")) return "ply";
  const std::string extension = lower_case(file.path().extension().string());
  if (extension == ".ply") return "ply";
  for (const char* text : {".xyz", ".txt", ".csv", ".asc", ".pts", ".dat", ".xyzrgb", ".xyzn"})
    if (extension == text) return "xyz";
  return "";
}

}  // namespace

std::span<const std::string_view> geometry_formats() {
  return kFormats;
}

std::vector<Geometry> read_geometry_file(const std::filesystem::path& path, const ReadOptions& options) {
  const FileBytes file = read_file_bytes(path);
  const std::string format = options.format == "auto" ? format_of(file) : options.format;
  if (format == "ply") return {read_ply(file)};
  if (format == "xyz") return {read_xyz(file, options.text)};
  file.fail(fmt::format("unknown format; name it with 'format', one of {}", fmt::join(kFormats, ", ")));
}

}  // namespace meshmser
