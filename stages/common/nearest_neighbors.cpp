#include "stages/common/nearest_neighbors.hpp"

#include <algorithm>
#include <flann/flann.hpp>

#include "stages/common/parallel.hpp"

namespace meshmser {

NearestNeighbors nearest_neighbors(std::span<const Eigen::Vector3d> points, int num_neighbors,
                                   const Execution& execution) {
  NearestNeighbors result;
  result.num_points = static_cast<std::int64_t>(points.size());
  result.num_neighbors = static_cast<std::int32_t>(
      std::clamp<std::int64_t>(num_neighbors, 0, std::max<std::int64_t>(0, result.num_points - 1)));
  if (result.num_neighbors == 0) return result;
  result.ids.resize(static_cast<std::size_t>(result.num_points * result.num_neighbors));

  static_assert(sizeof(Eigen::Vector3d) == 3 * sizeof(double));
  // FLANN takes a pointer to mutable data but does not write through it.
  const flann::Matrix<double> data(const_cast<double*>(points.front().data()), points.size(), 3);
  flann::KDTreeSingleIndex<flann::L2_3D<double>> tree(data, flann::KDTreeSingleIndexParams(12, true));
  tree.buildIndex();
  execution.check();

  const std::size_t found = static_cast<std::size_t>(result.num_neighbors) + 1;  // the point itself is among them
  flann::SearchParams exact(flann::FLANN_CHECKS_UNLIMITED);
  exact.cores = 1;
  exact.sorted = true;
  parallel_chunks(result.num_points, 2048, "neighbours", execution, [&](std::int64_t begin, std::int64_t end) {
    const std::size_t count = static_cast<std::size_t>(end - begin);
    std::vector<int> ids(count * found);
    std::vector<double> distances(count * found);
    const flann::Matrix<double> queries(data[static_cast<std::size_t>(begin)], count, 3);
    flann::Matrix<int> id_matrix(ids.data(), count, found);
    flann::Matrix<double> distance_matrix(distances.data(), count, found);
    tree.knnSearch(queries, id_matrix, distance_matrix, found, exact);
    for (std::int64_t point = begin; point < end; ++point) {
      const int* row = ids.data() + static_cast<std::size_t>(point - begin) * found;
      std::int32_t* out = result.ids.data() + point * result.num_neighbors;
      std::int32_t written = 0;
      for (std::size_t k = 0; k < found && written < result.num_neighbors; ++k)
        if (row[k] != point) out[written++] = row[k];
    }
  });
  return result;
}

}  // namespace meshmser
