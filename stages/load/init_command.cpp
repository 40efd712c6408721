/// `meshmser init`: a commented configuration that fits a scan or a mesh.

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string>

#include "pipeline/formats/geometry_file.hpp"
#include "pipeline/formats/output_file.hpp"
#include "pipeline/formats/stanford_conf.hpp"
#include "pipeline/stage/command.hpp"
#include "stages/load/load_scan.hpp"

namespace meshmser {
namespace {

/// As a value in a YAML flow map.
std::string yaml_text(const std::string& text) {
  const bool plain = std::all_of(text.begin(), text.end(), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.' || c == '/' || c == '-';
  });
  if (plain && !text.empty() && text.front() != '-') return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("''") : std::string(1, c);
  return quoted + "'";
}

LoadedScan load_file(const std::filesystem::path& path, const Execution& execution) {
  std::vector<PosedScan> scans;
  if (path.extension() == ".conf") {
    for (const PosedFile& file : read_stanford_conf(read_file_bytes(path)))
      scans.push_back({read_geometry_file(file.path).front(), file.world_from_file, {}});
  } else {
    for (Geometry& geometry : read_geometry_file(path))
      scans.push_back({std::move(geometry), Eigen::Isometry3d::Identity(), {}});
  }
  return load_scan(std::move(scans), {}, execution);
}

/// A property that is no colour, normal or identity: what a user may want as the scalar.
std::string likely_scalar(const std::vector<Property>& properties) {
  constexpr const char* kKnown[] = {"quality", "scalar", "curvature", "mean_curvature", "value"};
  for (const char* name : kKnown)
    for (const Property& property : properties)
      if (property.name == name) return name;
  return "";
}

std::string config_for(const LoadedScan& loaded, const std::string& path_in_config, const std::string& given_units) {
  const PointCloud& points = loaded.points;
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : points.positions) box.extend(p);
  const Eigen::Vector3d size = box.sizes();
  // A scanned thing of less than five metres in metres, or millimetres.
  const bool guessed = given_units.empty();
  const std::string units = !guessed ? given_units : size.norm() < 5 ? "m" : "mm";
  const double h = points.spacing;
  auto line = [](const std::string& stage, const std::string& comment) {
    return comment.empty() ? fmt::format("  {}\n", stage) : fmt::format("  {:<58} # {}\n", stage, comment);
  };
  std::string text = "version: 1\n";
  text += fmt::format("units: {:<54} # of the coordinates{}\n", units,
                      guessed ? ": a guess from their size, change it if it is wrong" : "");
  text += "stages:\n";
  text +=
      fmt::format("  # {} points{}, {:.4g} {} apart (one spacing), in a box of {:.4g} x {:.4g} x {:.4g} {}\n",
                  points.num_points(), points.scans.size() > 1 ? fmt::format(" of {} scans", points.scans.size()) : "",
                  h, units, size.x(), size.y(), size.z(), units);
  if (!points.properties.empty()) {
    std::string names;
    for (const Property& property : points.properties) names += " " + property.name;
    text += fmt::format("  # properties of the file:{}\n", names);
  }
  text += line(fmt::format("- load:      {{path: {}}}", path_in_config), "");
  std::string scalar;
  if (loaded.mesh) {
    scalar = likely_scalar(points.properties);
    if (scalar.empty())
      text += line("- curvature: {radius: 4 spacing, steps: 4}",
                   fmt::format("radius {:.3g} {}: features narrower than two radii merge", 4 * h, units));
  } else {
    const bool scanner = std::all_of(points.scans.begin(), points.scans.end(),
                                     [](const Scan& s) { return s.scanner_position.has_value(); });
    text += line("- orient:    {}", scanner ? "outside is toward the scanner"
                                            : "outside of an open sheet is a guess: see orient.viewpoint, orient.flip");
    text += line("- curvature: {radius: 4 spacing, steps: 4}",
                 fmt::format("radius {:.3g} {}: features narrower than two radii merge", 4 * h, units));
    text += line("- mesh:      {max_edge: 5 spacing}", fmt::format("{:.3g} {}: wider gaps stay holes", 5 * h, units));
  }
  text += line(fmt::format("- tree:      {{scalar: {}, polarity: both}}", scalar.empty() ? "mean_curvature" : scalar),
               "upper: ridges; lower: grooves");
  text += line("- mser:      {}", "min_area, min_persistence: what is too small or too weak");
  text += line("- borders:   {}", "");
  text += line("- export:    {}", "");
  return text;
}

int run_init(const CommandArguments& arguments, CommandHost& host) {
  const std::filesystem::path scan = arguments.get("SCAN");
  const std::filesystem::path config = arguments.get("--out", scan.stem().string() + ".yaml");
  const std::string units = arguments.get("--units");
  if (std::filesystem::exists(config))
    throw UsageError(
        fmt::format("init: {} exists already; name another file with --out, or remove it", config.string()));
  const LoadedScan loaded = load_file(scan, host.execution());
  std::error_code failed;
  std::filesystem::path relative =
      std::filesystem::relative(scan, std::filesystem::absolute(config).parent_path(), failed);
  if (failed || relative.empty()) relative = std::filesystem::absolute(scan);
  OutputFile file(config);
  file.text(config_for(loaded, yaml_text(relative.string()), units));
  file.finish();
  fmt::print("{}\n", config.string());
  return static_cast<int>(ExitCode::kOk);
}

CommandDefinition definition() {
  return {"init",
          "Writes a commented configuration that fits a scan or a mesh.",
          {{"SCAN", "a file that the stage load reads", true},
           {"--out", "the configuration to write (the scan's name with .yaml, in this folder)"},
           {"--units", "unit of the coordinates: mm, m, in ... (guessed from their size)"}},
          run_init,
          "meshmser init scan.xyz --units mm"};
}

MESHMSER_COMMAND(init, definition());

}  // namespace
}  // namespace meshmser
