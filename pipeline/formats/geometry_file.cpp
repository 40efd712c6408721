#include "pipeline/formats/geometry_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "pipeline/formats/obj.hpp"
#include "pipeline/formats/off.hpp"
#include "pipeline/formats/pcd.hpp"
#include "pipeline/formats/ply.hpp"
#include "pipeline/formats/ptx.hpp"
#include "pipeline/formats/stl.hpp"

namespace meshmser {
namespace {

constexpr std::array<std::string_view, 7> kFormats{"ply", "xyz", "pcd", "off", "obj", "stl", "ptx"};

/// The format by content where it can be told, else by extension; empty: unknown.
std::string format_of(const FileBytes& file) {
  const std::string_view start(file.begin(), std::min<std::size_t>(file.size(), 512));
  if (start.starts_with("ply\n") || start.starts_with("ply\r")) return "ply";
  if (start.find("# .PCD v") != std::string_view::npos || start.starts_with("VERSION .7")) return "pcd";
  const std::string extension = lower_case(file.path().extension().string());
  for (const char* known : {"ply", "pcd", "off", "obj", "stl", "ptx"})
    if (extension == fmt::format(".{}", known)) return known;
  for (const char* text : {".xyz", ".txt", ".csv", ".asc", ".pts", ".dat", ".xyzrgb", ".xyzn", ".xyzi"})
    if (extension == text) return "xyz";
  for (const char* kind : {"OFF", "COFF", "NOFF", "CNOFF"})
    if (start.starts_with(kind)) return "off";
  return "";
}

}  // namespace

std::span<const std::string_view> geometry_formats() {
  return kFormats;
}

std::vector<Geometry> read_geometry_file(const std::filesystem::path& path, const ReadOptions& options) {
  return read_geometry(read_file_bytes(path), options);
}

std::vector<Geometry> read_geometry(const FileBytes& file, const ReadOptions& options) {
  const std::string format = options.format == "auto" ? format_of(file) : options.format;
  if (format != "xyz" && !format.empty() &&
      (!options.text.columns.empty() || options.text.decimal_comma || options.text.skip_bad_lines))
    file.fail(
        fmt::format("'columns', 'decimal_comma' and 'skip_bad_lines' are for text of one point a line, this is read as "
                    "'{}'; leave them out",
                    format));
  if (format == "ply") return {read_ply(file)};
  if (format == "xyz") return {read_xyz(file, options.text)};
  if (format == "pcd") return {read_pcd(file)};
  if (format == "off") return {read_off(file)};
  if (format == "obj") return {read_obj(file)};
  if (format == "stl") return {read_stl(file)};
  if (format == "ptx") return read_ptx(file);
  file.fail(fmt::format("unknown format{}; name it with 'format', one of {}",
                        format.empty() ? std::string() : fmt::format(" {}", in_quotes(format)),
                        fmt::join(kFormats, ", ")));
}

bool announces_faces(const std::filesystem::path& path, const std::string& given_format) {
  constexpr std::size_t kHead = 1 << 16;
  FileBytes head = read_file_head(path, kHead);
  const std::string format = given_format == "auto" ? format_of(head) : given_format;
  if (format == "stl") return true;
  if (format != "ply" && format != "off" && format != "obj") return false;
  const std::string_view start(head.begin(), head.size());
  if (format == "ply" && start.find("end_header") != std::string_view::npos) return ply_announces_faces(head);
  const FileBytes file = head.size() < kHead ? std::move(head) : read_file_bytes(path);
  if (format == "ply") return ply_announces_faces(file);
  if (format == "off") return read_off(file).num_faces() > 0;
  Lines lines(file.begin(), file.end(), line_terminator({file.begin(), file.size()}));
  for (std::string_view line; lines.next(line);)
    if (line.size() > 1 && line[0] == 'f' && is_blank(line[1])) return true;
  return false;
}

}  // namespace meshmser
