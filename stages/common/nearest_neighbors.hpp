#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/execution/execution.hpp"

namespace meshmser {

/// For each point the ids of its nearest other points, nearest first.
struct NearestNeighbors {
  std::int64_t num_points = 0;
  std::int32_t num_neighbors = 0;  ///< the same for every point
  std::vector<std::int32_t> ids;   ///< num_points by num_neighbors

  std::span<const std::int32_t> of(std::int64_t point) const {
    return {ids.data() + point * num_neighbors, static_cast<std::size_t>(num_neighbors)};
  }
};

/// The `num_neighbors` nearest other points of every point (fewer where the cloud has fewer points). Equal distances
/// are ordered by the search tree, which depends on the points and their order alone. Searches are several times faster
/// when neighbours in space are neighbours in the array. O(n log n); the same for any number of threads. Uses FLANN's
/// single k-d tree (Muja and Lowe 2014), exact search.
NearestNeighbors nearest_neighbors(std::span<const Eigen::Vector3d> points, int num_neighbors,
                                   const Execution& execution = {});

}  // namespace meshmser
