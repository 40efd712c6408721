#pragma once
/// Any file a user may give, by its format.

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/formats/file_bytes.hpp"
#include "pipeline/formats/geometry.hpp"
#include "pipeline/formats/xyz.hpp"

namespace meshmser {

struct ReadOptions {
  std::string format = "auto";  ///< one of geometry_formats(), or `auto`: by the first bytes, then by the extension
  XyzOptions text;              ///< for the formats of one point a line
};

/// Names accepted by ReadOptions::format, without `auto`.
std::span<const std::string_view> geometry_formats();

/// Reads a file in memory. One Geometry a scan: PTX may hold several, every other format one.
/// Throws InputError that names the file and what to do, also when the format is unknown or an option does not fit it.
std::vector<Geometry> read_geometry(const FileBytes& file, const ReadOptions& options = {});

/// As read_geometry, of the file at `path`.
std::vector<Geometry> read_geometry_file(const std::filesystem::path& path, const ReadOptions& options = {});

/// Whether reading the file would give faces, from as little of it as tells. `format`: as in ReadOptions.
/// Throws InputError where the file cannot be read or its head is wrong.
bool announces_faces(const std::filesystem::path& path, const std::string& format = "auto");

}  // namespace meshmser
