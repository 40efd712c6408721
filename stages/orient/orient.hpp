#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/artifacts/point_cloud.hpp"
#include "pipeline/artifacts/point_normals.hpp"
#include "pipeline/execution/execution.hpp"

namespace meshmser {

/// Where a component's sign comes from. kAuto: the viewpoint where one is set, else the scanner's position where known,
/// else the enclosed volume, else a guess.
enum class SignChoice { kAuto, kGiven, kScanner, kViewpoint, kVolume };
/// Where the normals' directions come from.
enum class NormalChoice { kEstimated, kGiven };

struct OrientOptions {
  int neighbors = 12;  ///< in the regression and in the propagation graph
  double max_gap = 0;  ///< longest edge of the graph in coordinate units; 0: 8 times the cloud's spacing
  NormalChoice normals = NormalChoice::kEstimated;
  SignChoice sign = SignChoice::kAuto;
  std::optional<Eigen::Vector3d> viewpoint;  ///< in the frame of the raw scan; normals turn toward it
  bool flip_all = false;
  std::vector<int> flip;  ///< components to turn over, 1 the largest
};

struct OrientReport {
  std::int64_t num_unoriented = 0;       ///< points without a plane; their normal is zero
  std::int64_t num_edges = 0;            ///< of the graph, those across which the surface bends by less than 45 degrees
  std::int64_t num_disagreeing = 0;      ///< of these, whose two signs contradict each other
  std::vector<Eigen::Vector3d> centers;  ///< of the components, in the frame of the raw scan
};

struct Orientation {
  PointNormals normals;
  OrientReport report;
};

/// Gives every point of the cloud the normal of the least-squares plane of its neighbours, with signs that agree along
/// the surface and point outward.
///
/// Signs: edges of the graph of nearest neighbours (not longer than max_gap, not across a thin wall) are taken in order
/// of falling agreement of *smoothed* normals and joined by a union-find that carries the parity of signs (Kruskal's
/// form of Hoppe 1992). Each component is then turned as a whole: see SignChoice; a component that encloses no volume
/// is turned away from the cloud's centroid and its source is kGuess. With known scanner positions every point whose
/// normal is less than 80 degrees from the line of sight is turned toward its own scanner.
/// Components are ordered by falling size, then least point id. Points whose neighbours define no plane keep a zero
/// normal and are counted. Throws StageError where the options ask for what the cloud does not have. O(n k log n); the
/// same for any number of threads.
Orientation orient(const PointCloud& cloud, const OrientOptions& options, const Execution& execution = {});

}  // namespace meshmser
