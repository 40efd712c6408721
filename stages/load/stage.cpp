#include "pipeline/stage/stage.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/formats/geometry_file.hpp"
#include "pipeline/formats/stanford_conf.hpp"
#include "stages/load/load_scan.hpp"
#include "stages/load/pass_distance.hpp"
#include "stages/load/pose.hpp"

namespace meshmser {

enum class FileFormat { kAuto, kPly, kXyz, kPcd, kOff, kObj, kStl, kPtx };
template <>
struct EnumNames<FileFormat> {
  static constexpr std::pair<FileFormat, const char*> values[] = {
      {FileFormat::kAuto, "auto"}, {FileFormat::kPly, "ply"}, {FileFormat::kXyz, "xyz"}, {FileFormat::kPcd, "pcd"},
      {FileFormat::kOff, "off"},   {FileFormat::kObj, "obj"}, {FileFormat::kStl, "stl"}, {FileFormat::kPtx, "ptx"}};
};
template <>
struct EnumNames<OutlierMethod> {
  static constexpr std::pair<OutlierMethod, const char*> values[] = {
      {OutlierMethod::kNone, "none"}, {OutlierMethod::kStatistical, "statistical"}, {OutlierMethod::kRadius, "radius"}};
};
template <>
struct EnumNames<MeshRepair> {
  static constexpr std::pair<MeshRepair, const char*> values[] = {
      {MeshRepair::kNone, "none"}, {MeshRepair::kSplit, "split"}, {MeshRepair::kDrop, "drop"}};
};
template <>
struct EnumNames<MergeVertices> {
  static constexpr std::pair<MergeVertices, const char*> values[] = {
      {MergeVertices::kAuto, "auto"}, {MergeVertices::kNo, "no"}, {MergeVertices::kYes, "yes"}};
};
enum class FaceUse { kUse, kIgnore };
template <>
struct EnumNames<FaceUse> {
  static constexpr std::pair<FaceUse, const char*> values[] = {{FaceUse::kUse, "use"}, {FaceUse::kIgnore, "ignore"}};
};

namespace {

/// One of several files.
struct LoadFile {
  InputPath path;
  std::vector<double> pose;
  std::optional<std::array<double, 3>> scanner;

  static void declare(Schema& schema) {
    schema.parameter("path", &LoadFile::path, "The file.");
    schema.parameter(
        "pose", &LoadFile::pose,
        "Where it stands: 16 numbers, a 4 x 4 matrix row by row; or 7, a translation x y z and a quaternion "
        "x y z w.");
    schema.parameter("scanner", &LoadFile::scanner, "Where the scanner stood, in the file's own frame.");
  }
};

/// An axis-parallel box.
struct Box {
  std::array<double, 3> min{0, 0, 0}, max{1, 1, 1};

  static void declare(Schema& schema) {
    schema.parameter("min", &Box::min, "Least x, y, z.");
    schema.parameter("max", &Box::max, "Greatest x, y, z.");
  }
};

struct LoadParameters {
  std::optional<InputPath> path;
  std::vector<LoadFile> files;
  FileFormat format = FileFormat::kAuto;
  std::vector<std::string> columns;
  bool decimal_comma = false;
  bool skip_bad_lines = false;
  std::optional<Box> crop;
  OutlierMethod outliers = OutlierMethod::kNone;
  AutoOr<int> outlier_neighbors;
  double outlier_deviations = OutlierOptions{}.deviations;
  double outlier_radius = OutlierOptions{}.radius_spacings;
  FaceUse faces = FaceUse::kUse;
  bool turn_faces = false;
  MeshRepair repair = MeshRepair::kNone;
  MergeVertices merge_vertices = MergeVertices::kAuto;
};

bool is_conf(const std::filesystem::path& path) {
  return path.extension() == ".conf";
}

std::string name_of(FileFormat format) {
  return ParameterType<FileFormat>::format(format);
}

/// A file to read, with all that is said of it.
struct Source {
  std::filesystem::path path;
  Eigen::Isometry3d world_from_file = Eigen::Isometry3d::Identity();
  std::optional<Eigen::Vector3d> scanner;
};

Eigen::Vector3d vector_of(const std::array<double, 3>& v) {
  return {v[0], v[1], v[2]};
}

/// Files in order; a .conf stands for the files it names, moved by its own pose.
std::vector<Source> sources_of(const LoadParameters& p) {
  std::vector<Source> sources;
  auto add = [&](const std::string& path, const Eigen::Isometry3d& pose,
                 const std::optional<Eigen::Vector3d>& scanner) {
    if (!is_conf(path)) {
      sources.push_back({path, pose, scanner});
      return;
    }
    for (const PosedFile& file : read_stanford_conf(read_file_bytes(path)))
      sources.push_back({file.path, pose * file.world_from_file, {}});
  };
  std::string problem;
  if (p.path) add(p.path->resolved, Eigen::Isometry3d::Identity(), {});
  for (const LoadFile& file : p.files)
    add(file.path.resolved, pose_from_numbers(file.pose, problem),
        file.scanner ? std::optional(vector_of(*file.scanner)) : std::nullopt);
  return sources;
}

void tell_of_points(const LoadedScan& loaded, RunContext& context) {
  const PointCloud& points = loaded.points;
  const LoadReport& r = loaded.report;
  context.report("num_raw_points", points.num_raw_points);
  context.report("num_points", static_cast<std::int64_t>(points.num_points()));
  context.report("num_scans", static_cast<std::int64_t>(points.scans.size()));
  context.report("spacing", points.spacing, context.units());
  context.report("num_duplicates", r.num_duplicates);
  context.report("num_non_finite", r.num_non_finite);
  if (r.num_cropped > 0) context.report("num_cropped", r.num_cropped);
  if (r.num_outliers > 0) context.report("num_outliers", r.num_outliers);
  if (r.num_empty_cells > 0) context.report("num_empty_cells", r.num_empty_cells);
  const auto known = std::count_if(points.scans.begin(), points.scans.end(),
                                   [](const Scan& s) { return s.scanner_position.has_value(); });
  context.report("num_scanner_positions", static_cast<std::int64_t>(known));
  if (!points.origin.isZero(0))
    context.report("origin", fmt::format("{} {} {}", points.origin.x(), points.origin.y(), points.origin.z()));
  std::string names;
  for (const Property& property : points.properties) names += (names.empty() ? "" : " ") + property.name;
  if (!names.empty()) context.report("properties", names);
  if (r.num_skipped_lines > 0) {
    context.report("num_skipped_lines", r.num_skipped_lines);
    context.warn(
        fmt::format("{} lines were not points and were skipped, as load.skip_bad_lines says", r.num_skipped_lines));
  }
  if (points.spacing == 0)
    context.warn(
        fmt::format("{} points are too few to measure a spacing; lengths in spacings are zero", points.num_points()));
  // A step of a twentieth of the spacing is as large as the noise of a good scanner.
  constexpr double kCoarse = 0.05;
  if (r.float_step > kCoarse * points.spacing && points.spacing > 0)
    context.warn(
        fmt::format("coordinates are single-precision floats in steps of {:.2g} {}, {:.2g} spacings: curvature will "
                    "show the steps; save the scan with "
                    "doubles, or nearer to the origin",
                    r.float_step, context.units(), r.float_step / points.spacing));
}

void tell_of_passes(const PointCloud& points, RunContext& context) {
  constexpr double kMisregistered = 0.5;  // spacings: edges begin to blur
  constexpr std::size_t kTold = 5;
  constexpr std::int64_t kSure = 100;  // samples of a pair
  const PassDistances distances = measure_pass_distances(points, context.execution());
  if (distances.pairs.empty()) return;
  context.report("pass_distance", distances.median_distance / points.spacing, "spacing");
  std::vector<PassPair> apart;
  for (const PassPair& pair : distances.pairs)
    if (pair.median_distance >= kMisregistered * points.spacing && pair.num_samples >= kSure) apart.push_back(pair);
  context.report("num_overlapping_pairs", static_cast<std::int64_t>(distances.pairs.size()));
  context.report("num_misregistered_pairs", static_cast<std::int64_t>(apart.size()));
  if (apart.empty()) return;
  std::stable_sort(apart.begin(), apart.end(),
                   [](const PassPair& a, const PassPair& b) { return a.median_distance > b.median_distance; });
  std::string list;
  for (std::size_t i = 0; i < std::min(apart.size(), kTold); ++i)
    list += fmt::format("{}{} and {} lie {:.2f} spacings apart", i == 0 ? "" : ", ", points.scans[apart[i].first].name,
                        points.scans[apart[i].second].name, apart[i].median_distance / points.spacing);
  if (apart.size() > kTold) list += fmt::format(", and {} more pairs", apart.size() - kTold);
  context.warn(
      fmt::format("overlapping scans are misregistered: {} (medians along the normal); edges blur from half a spacing "
                  "on: register them again, or "
                  "raise curvature.radius",
                  list));
}

void tell_of_mesh(const LoadedScan& loaded, RunContext& context) {
  const GivenMeshReport& r = loaded.report.mesh;
  context.report("num_vertices", static_cast<std::int64_t>(loaded.mesh->num_vertices()));
  context.report("num_triangles", static_cast<std::int64_t>(loaded.mesh->num_triangles()));
  context.report("num_components", static_cast<std::int64_t>(loaded.normals->components.size()));
  for (const auto& [name, count] :
       {std::pair("num_polygons_cut", r.num_polygons_cut), std::pair("num_degenerate_triangles", r.num_degenerate),
        std::pair("num_cropped_triangles", r.num_cropped),
        std::pair("num_non_manifold_edges", r.num_non_manifold_edges),
        std::pair("num_inconsistent_edges", r.num_inconsistent_edges), std::pair("num_turned_triangles", r.num_turned),
        std::pair("num_dropped_triangles", r.num_dropped), std::pair("num_split_vertices", r.num_split_vertices),
        std::pair("num_unused_vertices", r.num_unused_vertices)})
    if (count > 0) context.report(name, count);
  if (r.num_non_manifold_edges + r.num_inconsistent_edges > 0)
    context.warn(fmt::format(
        "the mesh was repaired: {} non-manifold and {} inconsistently oriented edges, {} triangles turned, {} dropped",
        r.num_non_manifold_edges, r.num_inconsistent_edges, r.num_turned, r.num_dropped));
  if (r.num_coincident_vertices > 0)
    context.warn(fmt::format(
        "{} vertices lie at the place of another: the mesh is cut there; 'load.merge_vertices: yes' joins them",
        r.num_coincident_vertices));
  if (r.num_inside_out > 0)
    context.warn(
        fmt::format("{} closed component{} of the mesh face{} inward: a hollow space, or the mesh is inside out and "
                    "'load.turn_faces: true' turns it; until then the sign of its curvature is wrong",
                    r.num_inside_out, r.num_inside_out == 1 ? "" : "s", r.num_inside_out == 1 ? "s" : ""));
}

struct LoadStage {
  static constexpr StageInfo info{"load", 2,
                                  "Reads scans or a mesh into points in canonical order and measures their spacing."};
  using Parameters = LoadParameters;

  static void declare(StageSchema& schema) {
    schema.parameter("path", &Parameters::path,
                     "The scan or mesh: PLY, XYZ, TXT, CSV, ASC, PTS, PCD, PTX, OFF, OBJ or STL, or a Stanford .conf "
                     "that names range maps.");
    schema.parameter("files", &Parameters::files,
                     "In place of path: several files, each with an optional pose and scanner position.");
    schema.parameter("format", &Parameters::format,
                     "The files' format; auto: by content and name; xyz: any text of one point a line.");
    schema.parameter("columns", &Parameters::columns,
                     "Names of a text file's columns, x, y and z among them; _ leaves one out; empty: by its header, "
                     "else x y z first.");
    schema.parameter("decimal_comma", &Parameters::decimal_comma,
                     "Numbers in text are written 1,5; columns are then separated by blanks or semicolons.");
    schema.parameter("skip_bad_lines", &Parameters::skip_bad_lines,
                     "Leaves out and counts lines of text that are no points, in place of an error.");
    schema.parameter("crop", &Parameters::crop, "Only points within this box are kept, in the frame of the scan.");
    schema.parameter("outliers", &Parameters::outliers,
                     "Removes points that belong to no surface: by the statistics of neighbour distances, or by a "
                     "least number of neighbours within a radius.");
    schema.parameter("outlier_neighbors", &Parameters::outlier_neighbors, range(1, 1000), "points",
                     "Statistical: neighbours whose mean distance is looked at (auto: 16); radius: the least number of "
                     "them (auto: 4).");
    schema.parameter("outlier_deviations", &Parameters::outlier_deviations, range(0, 100), "standard deviations",
                     "Statistical: how far above the mean a point's mean distance may be.");
    schema.parameter("outlier_radius", &Parameters::outlier_radius, range(0.1, 1000), "spacings",
                     "Radius: how far to look for neighbours.");
    schema.parameter("faces", &Parameters::faces,
                     "use: files with faces give a mesh and its normals; ignore: their vertices are a scan.");
    schema.parameter("turn_faces", &Parameters::turn_faces,
                     "Turns every face of a given mesh around: for a mesh that is inside out.");
    schema.parameter("repair", &Parameters::repair,
                     "Non-manifold and inconsistently oriented edges of a given mesh: none: an error; split: turn "
                     "triangles and cut; drop: turn triangles and drop the smallest.");
    schema.parameter("merge_vertices", &Parameters::merge_vertices,
                     "Makes vertices of a given mesh at the same place one; auto: those of STL.");
    schema.output<PointCloud>("points");
    schema.output<PointNormals>("normals");
    schema.output<TriangleMesh>("mesh");
  }

  static std::vector<ParameterProblem> check(const Parameters& p) {
    std::vector<ParameterProblem> problems;
    if (!p.path && p.files.empty())
      problems.emplace_back("path", "no file to load; give 'path: scan.ply', or a list under 'files'");
    if (p.path && !p.files.empty())
      problems.emplace_back("files", "both 'path' and 'files' are given; keep one of them");
    for (const LoadFile& file : p.files) {
      std::string problem;
      pose_from_numbers(file.pose, problem);
      if (!problem.empty()) problems.emplace_back("files", problem);
      if (file.path.text.empty())
        problems.emplace_back("files", "an entry has no 'path'; expected {path: scan.ply, pose: [...]}");
      if (file.scanner && is_conf(file.path.text))
        problems.emplace_back("files", "a .conf has no single scanner position; leave 'scanner' out");
    }
    if (!p.columns.empty())
      for (const char* axis : {"x", "y", "z"})
        if (std::find(p.columns.begin(), p.columns.end(), axis) == p.columns.end())
          problems.emplace_back("columns",
                                fmt::format("the columns do not name '{}'; expected x, y and z among them", axis));
    if (p.crop)
      for (std::size_t axis = 0; axis < 3; ++axis)
        if (!(p.crop->min[axis] < p.crop->max[axis]))
          problems.emplace_back("crop", fmt::format("the box is empty along {}: min {} is not below max {}",
                                                    "xyz"[axis], p.crop->min[axis], p.crop->max[axis]));
    return problems;
  }

  static std::vector<std::filesystem::path> files(const Parameters& p) {
    std::vector<std::filesystem::path> all;
    if (p.path && is_conf(p.path->resolved)) all.push_back(p.path->resolved);
    for (const LoadFile& file : p.files)
      if (is_conf(file.path.resolved)) all.push_back(file.path.resolved);
    for (const Source& source : sources_of(p)) all.push_back(source.path);
    return all;
  }

  static std::vector<std::string> made_outputs(const Parameters& p) {
    if (p.faces == FaceUse::kUse)
      for (const Source& source : sources_of(p))
        if (announces_faces(source.path, name_of(p.format))) return {"points", "normals", "mesh"};
    return {"points"};
  }

  static Outputs run(const Parameters& p, const Inputs&, RunContext& context) {
    ReadOptions read;
    read.format = name_of(p.format);
    read.text = {p.columns, p.decimal_comma, p.skip_bad_lines};
    std::vector<PosedScan> scans;
    const std::vector<Source> sources = sources_of(p);
    for (std::size_t i = 0; i < sources.size(); ++i) {
      context.execution().report("read", static_cast<std::int64_t>(i), static_cast<std::int64_t>(sources.size()));
      for (Geometry& geometry : read_geometry_file(sources[i].path, read))
        scans.push_back({std::move(geometry), sources[i].world_from_file, sources[i].scanner});
    }
    LoadScanOptions options;
    if (p.crop) options.crop = Eigen::AlignedBox3d(vector_of(p.crop->min), vector_of(p.crop->max));
    const int least = p.outliers == OutlierMethod::kRadius ? 4 : 16;
    options.outliers = {p.outliers, p.outlier_neighbors.automatic ? least : p.outlier_neighbors.value,
                        p.outlier_deviations, p.outlier_radius};
    options.use_faces = p.faces == FaceUse::kUse;
    options.turn_faces = p.turn_faces;
    options.repair = p.repair;
    options.merge_vertices = p.merge_vertices;
    LoadedScan loaded = load_scan(std::move(scans), options, context.execution());
    tell_of_points(loaded, context);
    Outputs outputs;
    if (loaded.mesh) {
      tell_of_mesh(loaded, context);
      outputs.set("normals", std::move(*loaded.normals));
      outputs.set("mesh", std::move(*loaded.mesh));
    } else {
      tell_of_passes(loaded.points, context);
    }
    outputs.set("points", std::move(loaded.points));
    return outputs;
  }
};
MESHMSER_STAGE(LoadStage);

}  // namespace
}  // namespace meshmser
