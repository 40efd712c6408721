#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "data/scanner/shape.hpp"
#include "pipeline/execution/execution.hpp"

namespace meshmser::scanner {

/// Where a pass is taken from.
struct Pose {
  Eigen::Vector3d position, target;  ///< of the scanner, and what it looks at; in the shape's coordinates
};

/// `count` poses, evenly spread (Fibonacci spiral) over the directions within `cone` degrees of `toward`, at `distance`
/// from `target`. The first looks straight against `toward`.
std::vector<Pose> poses_around(const Eigen::Vector3d& target, double distance, int count, double cone,
                               const Eigen::Vector3d& toward);

struct ScanOptions {
  double spacing = 0.2;       ///< of one pass, at the distance of the target, facing the scanner; in coordinate units
  double noise = 0.3;         ///< standard deviation along the ray, in spacings of one pass
  double registration = 0;    ///< root mean square by which a pass is displaced as a whole, in spacings
  double dropouts = 0.01;     ///< share of the measurements that are lost
  double outliers = 0;        ///< share of the points that are anywhere in the (slightly larger) bounding box
  double max_incidence = 78;  ///< degrees between ray and normal beyond which nothing is measured
  int holes = 0;              ///< places where nothing is measured
  double hole_radius = 0;     ///< 0: 12 spacings
  bool shuffle = true;
  std::uint64_t seed = 1;
};

/// A place where nothing was measured: all of the surface that faces as it does there and lies within the radius.
struct ScanHole {
  Eigen::Vector3d centre, normal;
  double radius;
};

/// What the scanner measured, with the truth beside it. Points in the order in which they are to be written.
struct SimulatedScan {
  std::vector<Eigen::Vector3d> points;             ///< #P, minus the shape's origin
  std::vector<std::int32_t> face_of_point;         ///< #P; 0: an outlier
  std::vector<Eigen::Vector3f> true_normals;       ///< #P; of the true surface, outward; zero for outliers
  std::vector<std::uint16_t> pass_of_point;        ///< #P, from 0
  std::vector<Eigen::Vector3d> scanner_positions;  ///< of each pass; as displaced as the pass is
  std::vector<ScanHole> holes;
  std::int64_t num_rays = 0;
};

/// Scans a shape. From each pose a square grid of rays, turned at random about the line of sight, is shot so that rays
/// are one spacing apart at the target; the first surface met is measured (line of sight), moved along the ray by
/// Gaussian noise; grazing hits and drop-outs are lost. Each pass is then turned and shifted at random by the
/// registration error. Holes are centred on measured points at least 3 radii apart. Throws StageError when nothing is
/// seen, UsageError for options out of range. The same result for a seed on any number of threads. About 1 us a ray and
/// core; 40 bytes a point.
SimulatedScan scan_shape(const Shape& shape, const std::vector<Pose>& poses, const ScanOptions& options,
                         const Execution& execution = {});

/// The spacing of one pass with which scan_shape measures about `num_points` points: found by a coarse scan.
double spacing_for_points(const Shape& shape, const std::vector<Pose>& poses, ScanOptions options,
                          std::int64_t num_points, const Execution& execution = {});

}  // namespace meshmser::scanner
