#include "data/scanner/virtual_scanner.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "data/scanner/random.hpp"
#include "stages/common/parallel.hpp"
#include "stages/common/ray_scene.hpp"

namespace meshmser::scanner {
namespace {

using Eigen::Vector3d;

/// Independent streams of random numbers; each pass adds its number to those that are per pass.
enum Stream : std::uint64_t { kHoles = 1, kOutliers, kShuffle, kPose = 1 << 10, kRange = 1 << 20, kDropout = 1 << 21 };

/// Unit vector, evenly spread; uses the numbers 3 n .. 3 n + 2 of the stream's normal ones.
Vector3d random_direction(const RandomStream& random, std::uint64_t n) {
  return Vector3d(random.normal(3 * n), random.normal(3 * n + 1), random.normal(3 * n + 2)).normalized();
}

struct Measurement {
  Vector3d point;
  Eigen::Vector3f normal;
  std::int32_t face;
  std::uint16_t pass;
};

Vector3d triangle_normal(const TriangleMesh& mesh, std::int32_t triangle) {
  const auto& [a, b, c] = mesh.triangles[static_cast<std::size_t>(triangle)];
  const Vector3d& p = mesh.positions[static_cast<std::size_t>(a)];
  return (mesh.positions[static_cast<std::size_t>(b)] - p)
      .cross(mesh.positions[static_cast<std::size_t>(c)] - p)
      .normalized();
}

/// The grid of rays of one pass: from the scanner through a square grid in the plane of the target.
struct RayGrid {
  Vector3d from, corner, u, v;  ///< u, v: steps of one spacing
  std::int64_t side = 0;        ///< rays along a side

  Vector3d direction(std::int64_t i, std::int64_t j) const {
    return (corner + u * static_cast<double>(i) + v * static_cast<double>(j) - from).normalized();
  }
};

RayGrid ray_grid(const Pose& pose, const Extent& extent, const ScanOptions& options, std::size_t pass) {
  const RandomStream random(options.seed, kPose + pass);
  const Vector3d ahead = (pose.target - pose.position).normalized();
  const double angle = 2 * std::numbers::pi * random.uniform(0);
  const Vector3d side = ahead.unitOrthogonal(), across = ahead.cross(side);
  RayGrid grid;
  grid.from = pose.position;
  grid.u = (side * std::cos(angle) + across * std::sin(angle)) * options.spacing;
  grid.v = ahead.cross(grid.u);
  // Wide enough for the bounding sphere seen from where the scanner stands.
  const double distance = (pose.target - pose.position).norm(), to_centre = (extent.centre - pose.position).norm();
  const double reach =
      (extent.radius + (extent.centre - pose.target).norm()) * distance /
      std::sqrt(std::max(to_centre * to_centre - extent.radius * extent.radius, 0.04 * to_centre * to_centre));
  const auto half = static_cast<std::int64_t>(std::ceil(reach / options.spacing));
  grid.side = 2 * half + 1;
  const double shift_u = random.uniform(1) - 0.5, shift_v = random.uniform(2) - 0.5;
  grid.corner =
      pose.target - grid.u * (static_cast<double>(half) + shift_u) - grid.v * (static_cast<double>(half) + shift_v);
  return grid;
}

/// Rotation about the centre and shift that together displace points by the root mean square `size`.
Eigen::Isometry3d registration_error(const RandomStream& random, const Extent& extent, double size) {
  const double each = size / std::sqrt(2.0);
  // Points of the object lie about 0.6 of the radius of its bounding sphere from the centre, and a random axis moves
  // them by sqrt(2 / 3) of that times the angle.
  const double angle = each / (0.6 * std::sqrt(2.0 / 3.0) * extent.radius);
  Eigen::Isometry3d error = Eigen::Isometry3d::Identity();
  error.translate(extent.centre + random_direction(random, 10) * each);
  error.rotate(Eigen::AngleAxisd(angle, random_direction(random, 20)));
  error.translate(-extent.centre);
  return error;
}

std::vector<Measurement> measure_pass(const Shape& shape, const RayScene& scene, const RayGrid& grid,
                                      const Extent& extent, const ScanOptions& options, std::size_t pass,
                                      const Execution& execution) {
  const RandomStream range(options.seed, kRange + pass), dropout(options.seed, kDropout + pass);
  const double least_cosine = std::cos(options.max_incidence * std::numbers::pi / 180);
  constexpr std::int64_t kRows = 16;
  std::vector<std::vector<Measurement>> blocks(static_cast<std::size_t>((grid.side + kRows - 1) / kRows));
  parallel_chunks(grid.side, kRows, "scan", execution, [&](std::int64_t begin, std::int64_t end) {
    std::vector<Measurement>& block = blocks[static_cast<std::size_t>(begin / kRows)];
    for (std::int64_t j = begin; j < end; ++j)
      for (std::int64_t i = 0; i < grid.side; ++i) {
        const Vector3d direction = grid.direction(i, j);
        // A ray that misses the bounding sphere costs nothing.
        const Vector3d to_centre = extent.centre - grid.from;
        const double along = to_centre.dot(direction);
        if (to_centre.squaredNorm() - along * along > extent.radius * extent.radius * 1.0001) continue;
        const RayScene::Hit hit = scene.intersect(grid.from, direction);
        if (hit.triangle < 0) continue;
        const Vector3d normal = triangle_normal(shape.mesh, hit.triangle);
        const double cosine = normal.dot(direction);
        if (std::abs(cosine) < least_cosine) continue;
        const auto ray = static_cast<std::uint64_t>(j * grid.side + i);
        if (dropout.uniform(ray) < options.dropouts) continue;
        // The exact distance, in double precision, to the plane of the triangle.
        const Vector3d& corner =
            shape.mesh
                .positions[static_cast<std::size_t>(shape.mesh.triangles[static_cast<std::size_t>(hit.triangle)][0])];
        const double distance =
            normal.dot(corner - grid.from) / cosine + options.noise * options.spacing * range.normal(ray);
        block.push_back({grid.from + direction * distance, normal.cast<float>(),
                         shape.face_of_triangle[static_cast<std::size_t>(hit.triangle)],
                         static_cast<std::uint16_t>(pass)});
      }
  });
  std::vector<Measurement> all;
  for (std::vector<Measurement>& block : blocks) {
    all.insert(all.end(), block.begin(), block.end());
    block = {};
  }
  return all;
}

/// Places for holes: measured points, at least three radii apart.
std::vector<ScanHole> choose_holes(const std::vector<Measurement>& measured, const ScanOptions& options) {
  const RandomStream random(options.seed, kHoles);
  const double radius = options.hole_radius > 0 ? options.hole_radius : 12 * options.spacing;
  std::vector<ScanHole> holes;
  for (std::uint64_t attempt = 0; static_cast<int>(holes.size()) < options.holes; ++attempt) {
    if (attempt == 10000)
      throw StageError(
          fmt::format("scan: only {} of {} holes of radius {:g} fit three radii apart; ask for fewer or smaller ones",
                      holes.size(), options.holes, radius));
    const Measurement& at = measured[random.bits(attempt) % measured.size()];
    const bool free = std::none_of(holes.begin(), holes.end(),
                                   [&](const ScanHole& hole) { return (hole.centre - at.point).norm() < 3 * radius; });
    if (free) holes.push_back({at.point, at.normal.cast<double>(), radius});
  }
  return holes;
}

void check_options(const std::vector<Pose>& poses, const ScanOptions& options) {
  auto require = [](bool holds, const char* what, double value, const char* expected) {
    if (!holds) throw UsageError(fmt::format("scan: {} = {:g} must be {}", what, value, expected));
  };
  require(std::isfinite(options.spacing) && options.spacing > 0, "spacing", options.spacing, "above 0");
  require(options.noise >= 0 && options.noise < 10, "noise", options.noise, "from 0 to 10 spacings");
  require(options.registration >= 0 && options.registration < 100, "registration", options.registration,
          "from 0 to 100 spacings");
  require(options.dropouts >= 0 && options.dropouts < 1, "dropouts", options.dropouts, "from 0 to below 1");
  require(options.outliers >= 0 && options.outliers < 1, "outliers", options.outliers, "from 0 to below 1");
  require(options.max_incidence > 0 && options.max_incidence <= 90, "max-incidence", options.max_incidence,
          "above 0, at most 90 degrees");
  require(options.holes >= 0, "holes", options.holes, "0 or more");
  require(options.hole_radius >= 0, "hole-radius", options.hole_radius, "0 or more");
  require(!poses.empty() && poses.size() < 65536, "number of poses", static_cast<double>(poses.size()),
          "from 1 to 65535");
}

}  // namespace

std::vector<Pose> poses_around(const Vector3d& target, double distance, int count, double cone,
                               const Vector3d& toward) {
  const Vector3d axis = toward.normalized(), u = axis.unitOrthogonal(), v = axis.cross(u);
  const double lowest = std::cos(std::min(cone, 180.0) * std::numbers::pi / 180);
  std::vector<Pose> poses;
  for (int i = 0; i < count; ++i) {
    const double z = count > 1 ? 1 - (1 - lowest) * i / (count - 1) : 1;
    const double r = std::sqrt(std::max(0.0, 1 - z * z)), angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
    poses.push_back({target + (axis * z + (u * std::cos(angle) + v * std::sin(angle)) * r) * distance, target});
  }
  return poses;
}

SimulatedScan scan_shape(const Shape& shape, const std::vector<Pose>& poses, const ScanOptions& options,
                         const Execution& execution) {
  check_options(poses, options);
  const Extent extent = extent_of(shape.mesh);
  const RayScene scene(shape.mesh.positions, shape.mesh.triangles);
  SimulatedScan scan;
  std::vector<Measurement> measured;
  std::vector<Eigen::Isometry3d> errors;
  for (std::size_t pass = 0; pass < poses.size(); ++pass) {
    const RayGrid grid = ray_grid(poses[pass], extent, options, pass);
    scan.num_rays += grid.side * grid.side;
    const std::vector<Measurement> seen = measure_pass(shape, scene, grid, extent, options, pass, execution);
    measured.insert(measured.end(), seen.begin(), seen.end());
    errors.push_back(
        registration_error(RandomStream(options.seed, kPose + pass), extent, options.registration * options.spacing));
    scan.scanner_positions.push_back(errors.back() * poses[pass].position);
  }
  if (measured.empty()) throw StageError("scan: no ray meets the object; check the poses, or take a smaller spacing");

  scan.holes = choose_holes(measured, options);
  std::erase_if(measured, [&](const Measurement& one) {
    return std::any_of(scan.holes.begin(), scan.holes.end(), [&](const ScanHole& hole) {
      return (one.point - hole.centre).squaredNorm() < hole.radius * hole.radius &&
             one.normal.cast<double>().dot(hole.normal) > 0;
    });
  });
  for (Measurement& one : measured) one.point = errors[one.pass] * one.point;

  const RandomStream random(options.seed, kOutliers);
  const auto num_outliers = static_cast<std::uint64_t>(
      std::llround(options.outliers / (1 - options.outliers) * static_cast<double>(measured.size())));
  const Vector3d size = (extent.high - extent.low) * 1.1 + Vector3d::Constant(0.02 * extent.radius);
  for (std::uint64_t i = 0; i < num_outliers; ++i) {
    const Vector3d share(random.uniform(4 * i) - 0.5, random.uniform(4 * i + 1) - 0.5, random.uniform(4 * i + 2) - 0.5);
    measured.push_back({extent.centre + share.cwiseProduct(size), Eigen::Vector3f::Zero(), 0,
                        static_cast<std::uint16_t>(random.bits(4 * i + 3) % poses.size())});
  }

  std::vector<std::uint32_t> order(measured.size());
  std::iota(order.begin(), order.end(), 0u);
  if (options.shuffle) {
    const RandomStream shuffle(options.seed, kShuffle);
    for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[shuffle.bits(i) % i]);
  }
  scan.points.reserve(order.size());
  for (std::uint32_t i : order) {
    scan.points.push_back(measured[i].point);
    scan.face_of_point.push_back(measured[i].face);
    scan.true_normals.push_back(measured[i].normal);
    scan.pass_of_point.push_back(measured[i].pass);
  }
  return scan;
}

double spacing_for_points(const Shape& shape, const std::vector<Pose>& poses, ScanOptions options,
                          std::int64_t num_points, const Execution& execution) {
  if (num_points < 1) throw UsageError(fmt::format("scan: points = {} must be 1 or more", num_points));
  options.spacing = extent_of(shape.mesh).radius / 100;
  options.holes = 0;
  options.outliers = 0;
  const auto coarse = static_cast<double>(scan_shape(shape, poses, options, execution).points.size());
  return options.spacing * std::sqrt(coarse / static_cast<double>(num_points));
}

}  // namespace meshmser::scanner
