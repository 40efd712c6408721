/// meshmser-scan: a virtual laser scanner.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <nlohmann/json.hpp>
#include <numeric>

#include "data/scanner/scan_files.hpp"
#include "data/scanner/shapes.hpp"
#include "pipeline/formats/output_file.hpp"

namespace meshmser::scanner {
namespace {

struct Arguments {
  std::string object;
  std::filesystem::path output;
  std::vector<std::string> settings;
  std::string poses_file, unit = "mm";
  std::vector<double> toward = {0, 0, 1}, origin = {0, 0, 0};
  int views = 0, threads = 0;
  double cone = -1, distance = 5, face_angle = 30;
  std::int64_t points = 0;
  ScanOptions scan;
  bool spacing_given = false, keep_order = false, list = false, per_pass = false, double_precision = false;
  bool labels = false, edges = false, normals = false, passes = false, summary = false, truth = false;
  std::filesystem::path mesh_file;
};

/// A built-in shape or a mesh file, and how it is usually scanned.
struct ScannedObject {
  Shape shape;
  double spacing = 0, cone = 180;
  int views = 14;
};

ShapeParameters parse_settings(const std::vector<std::string>& settings) {
  ShapeParameters parameters;
  for (const std::string& setting : settings) {
    const std::size_t equals = setting.find('=');
    std::size_t used = 0;
    double value = 0;
    try {
      if (equals != std::string::npos) value = std::stod(setting.substr(equals + 1), &used);
    } catch (const std::exception&) {
      used = 0;
    }
    if (equals == std::string::npos || equals + 1 + used != setting.size() || used == 0)
      throw UsageError(fmt::format("--set {}: expected name=number", setting));
    parameters[setting.substr(0, equals)] = value;
  }
  return parameters;
}

ScannedObject make_object(const Arguments& arguments) {
  ScannedObject object;
  const bool built_in = std::any_of(shape_catalogue().begin(), shape_catalogue().end(),
                                    [&](const ShapeInfo& info) { return info.name == arguments.object; });
  if (!built_in && arguments.object.find_first_of("./") != std::string::npos) {
    if (!arguments.settings.empty()) throw UsageError("--set is for built-in shapes; a mesh file has no parameters");
    object.shape = read_shape(arguments.object, arguments.face_angle);
    object.spacing = extent_of(object.shape.mesh).radius / 150;
    return object;
  }
  const ShapeInfo& info = shape_info(arguments.object);
  object.shape = make_shape(arguments.object, parse_settings(arguments.settings));
  object.spacing = info.spacing;
  object.views = info.views;
  object.cone = info.cone;
  return object;
}

void list_shapes() {
  for (const ShapeInfo& info : shape_catalogue()) {
    fmt::print("{}: {}\n  usually scanned in {} passes from within {:g} degrees of +z, {:g} apart\n", info.name,
               info.meaning, info.views, info.cone, info.spacing);
    for (const ShapeParameter& parameter : info.parameters)
      fmt::print("  --set {}={:g}  {}\n", parameter.name, parameter.default_value, parameter.meaning);
  }
}

nlohmann::ordered_json to_json(const Eigen::Vector3d& vector) {
  return {vector.x(), vector.y(), vector.z()};
}

void write_summary(const std::filesystem::path& path, const Arguments& arguments, const SimulatedScan& scan,
                   const Eigen::Vector3d& origin) {
  nlohmann::ordered_json summary;
  const ScanOptions& options = arguments.scan;
  summary["object"] = arguments.object;
  summary["settings"] = arguments.settings;
  summary["unit"] = arguments.unit;
  summary["num_points"] = scan.points.size();
  summary["spacing_of_a_pass"] = options.spacing;
  summary["noise"] = options.noise;
  summary["registration"] = options.registration;
  summary["dropouts"] = options.dropouts;
  summary["outliers"] = options.outliers;
  summary["max_incidence"] = options.max_incidence;
  summary["seed"] = options.seed;
  for (const Eigen::Vector3d& position : scan.scanner_positions)
    summary["scanner_positions"].push_back(to_json(position + origin));
  summary["holes"] = nlohmann::ordered_json::array();
  for (const ScanHole& hole : scan.holes)
    summary["holes"].push_back(
        {{"centre", to_json(hole.centre + origin)}, {"normal", to_json(hole.normal)}, {"radius", hole.radius}});
  OutputFile file(path);
  file.text(summary.dump(2) + "\n");
  file.finish();
}

void run(Arguments arguments) {
  if (arguments.list) return list_shapes();
  if (arguments.object.empty() || arguments.output.empty())
    throw UsageError(
        "give an object and an output file, for example: meshmser-scan tablet tablet.ply (or --list, --help)");
  const ScannedObject object = make_object(arguments);
  const Extent extent = extent_of(object.shape.mesh);
  const Eigen::Vector3d origin(arguments.origin[0], arguments.origin[1], arguments.origin[2]);
  const Eigen::Vector3d toward(arguments.toward[0], arguments.toward[1], arguments.toward[2]);
  if (toward.norm() == 0) throw UsageError("--toward 0,0,0 is no direction");
  if (arguments.distance < 1.2)
    throw UsageError("--distance must be at least 1.2 radii, else the scanner stands in the object");
  const std::vector<Pose> poses = arguments.poses_file.empty()
                                      ? poses_around(extent.centre, arguments.distance * extent.radius,
                                                     arguments.views > 0 ? arguments.views : object.views,
                                                     arguments.cone >= 0 ? arguments.cone : object.cone, toward)
                                      : read_poses(arguments.poses_file, extent.centre);
  Execution execution;
  execution.threads = arguments.threads;
  ScanOptions& options = arguments.scan;
  options.shuffle = !arguments.keep_order;
  if (!arguments.spacing_given) options.spacing = object.spacing;
  if (arguments.points > 0)
    options.spacing = spacing_for_points(object.shape, poses, options, arguments.points, execution);
  const SimulatedScan scan = scan_shape(object.shape, poses, options, execution);

  PointFileOptions file;
  file.double_precision = arguments.double_precision || origin.norm() > 100 * extent.radius;
  file.origin = origin;
  file.spacing = options.spacing;
  file.comment = fmt::format("simulated laser scan of {}, unit {}",
                             std::filesystem::path(arguments.object).filename().string(), arguments.unit);
  const std::filesystem::path stem = arguments.output.parent_path() / arguments.output.stem();
  auto beside = [&](const std::string& ending) { return std::filesystem::path(stem.string() + ending); };
  std::vector<std::uint32_t> selected(scan.points.size());
  std::iota(selected.begin(), selected.end(), 0u);
  if (arguments.per_pass) {
    for (std::size_t pass = 0; pass < poses.size(); ++pass) {
      std::vector<std::uint32_t> of_pass;
      for (std::uint32_t i : selected)
        if (scan.pass_of_point[i] == pass) of_pass.push_back(i);
      if (of_pass.empty()) continue;
      file.viewpoint = scan.scanner_positions[pass];
      write_points(beside(fmt::format("-{:02d}{}", pass, arguments.output.extension().string())), scan.points, of_pass,
                   file);
    }
  } else {
    write_points(arguments.output, scan.points, selected, file);
  }
  if (arguments.truth || arguments.labels) write_faces_npy(beside("-labels.npy"), scan.face_of_point);
  if (arguments.truth || arguments.normals) write_normals_npy(beside("-normals.npy"), scan.true_normals);
  if (arguments.truth || arguments.passes) write_passes_npy(beside("-passes.npy"), scan.pass_of_point);
  if (arguments.truth || arguments.edges)
    write_edges_npy(beside("-edges.npy"), true_edges(object.shape, options.spacing / 2), origin);
  if (arguments.truth || arguments.summary) write_summary(beside("-scan.json"), arguments, scan, origin);
  if (!arguments.mesh_file.empty()) write_shape(arguments.mesh_file, object.shape, origin, file.comment);
  fmt::print("{}: {} points from {} passes, {:.4g} {} apart in each\n", arguments.output.string(), scan.points.size(),
             poses.size(), options.spacing, arguments.unit);
}

int main_of(int argc, char** argv) {
  Arguments a;
  CLI::App app("A virtual laser scanner: raw points of a known surface, as a scanner would deliver them.",
               "meshmser-scan");
  app.set_version_flag("--version", MESHMSER_VERSION);
  app.add_option("OBJECT", a.object, "a built-in shape (see --list) or a file with a triangle mesh");
  app.add_option("OUT", a.output, "points: .ply, .pcd (with viewpoint) or .xyz");
  app.add_flag("--list", a.list, "tell the built-in shapes and their parameters");
  app.add_option("--set", a.settings, "name=number: a parameter of a built-in shape");
  app.add_option("--views", a.views, "number of passes, spread evenly around the object")->check(CLI::Range(1, 65535));
  app.add_option("--cone", a.cone, "degrees about --toward from within which passes are taken; 180: from all around")
      ->check(CLI::Range(0.0, 180.0));
  app.add_option("--toward", a.toward, "x,y,z: direction from the object to the first pass")
      ->delimiter(',')
      ->expected(3);
  app.add_option("--distance", a.distance, "of the scanner from the centre, in radii of the object");
  app.add_option("--poses", a.poses_file, "file with a pose a line: x y z of the scanner [x y z of its target]");
  auto* spacing = app.add_option("--spacing", a.scan.spacing, "of the points of one pass, in coordinate units");
  app.add_option("--points", a.points, "about so many points; sets the spacing")
      ->check(CLI::PositiveNumber)
      ->excludes(spacing);
  app.add_option("--noise", a.scan.noise, "standard deviation along the ray, in spacings of one pass")
      ->capture_default_str();
  app.add_option("--registration", a.scan.registration, "error of each pass's place, in spacings of one pass")
      ->capture_default_str();
  app.add_option("--dropouts", a.scan.dropouts, "share of measurements lost")->capture_default_str();
  app.add_option("--outliers", a.scan.outliers, "share of points that lie anywhere")->capture_default_str();
  app.add_option("--max-incidence", a.scan.max_incidence, "degrees from the normal beyond which nothing is seen")
      ->capture_default_str();
  app.add_option("--holes", a.scan.holes, "places left out")->capture_default_str();
  app.add_option("--hole-radius", a.scan.hole_radius, "of each, in coordinate units; 0: 12 spacings")
      ->capture_default_str();
  app.add_flag("--keep-order", a.keep_order, "pass by pass and row by row instead of shuffled");
  app.add_option("--seed", a.scan.seed, "of all that is random")->capture_default_str();
  app.add_option("--origin", a.origin, "x,y,z: added to every coordinate")->delimiter(',')->expected(3);
  app.add_flag("--double", a.double_precision, "write double precision (always so with a far origin)");
  app.add_flag("--per-pass", a.per_pass, "one file a pass: OUT-00, OUT-01 ...");
  app.add_option("--unit", a.unit, "of the coordinates, as written in comments")->capture_default_str();
  app.add_flag("--labels", a.labels, "write OUT-labels.npy: the true face of each point (0: outlier)");
  app.add_flag("--edges", a.edges, "write OUT-edges.npy: points on true edges, with the angle there");
  app.add_flag("--normals", a.normals, "write OUT-normals.npy");
  app.add_flag("--passes", a.passes, "write OUT-passes.npy: the pass of each point");
  app.add_flag("--summary", a.summary, "write OUT-scan.json: options, scanner positions, holes");
  app.add_flag("--truth", a.truth, "write all of these");
  app.add_option("--mesh-out", a.mesh_file, "write the exact mesh, as PLY with the true faces as labels");
  app.add_option("--face-angle", a.face_angle, "of a mesh file: degrees at which faces part")->capture_default_str();
  app.add_option("--threads", a.threads, "0: every core; never changes the result")->capture_default_str();
  try {
    app.parse(argc, argv);
    a.spacing_given = spacing->count() > 0;
    run(std::move(a));
    return static_cast<int>(ExitCode::kOk);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? static_cast<int>(ExitCode::kOk) : static_cast<int>(ExitCode::kUsage);
  } catch (const Error& error) {
    fmt::print(stderr, "meshmser-scan: {}\n", error.what());
    return static_cast<int>(error.code());
  } catch (const std::exception& error) {
    fmt::print(stderr, "meshmser-scan: internal error: {}\n", error.what());
    return static_cast<int>(ExitCode::kInternal);
  }
}

}  // namespace
}  // namespace meshmser::scanner

int main(int argc, char** argv) {
  return meshmser::scanner::main_of(argc, argv);
}
