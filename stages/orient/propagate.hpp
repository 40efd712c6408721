#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/execution/execution.hpp"
#include "stages/common/nearest_neighbors.hpp"

namespace meshmser {

/// Signs for unsigned normals, component by component.
struct Propagation {
  std::vector<std::int8_t> signs;  ///< #P: +1 or -1; 0 for points with a zero normal
  std::vector<std::int32_t>
      component_of_point;  ///< #P; -1 for points with a zero normal; by falling size, then least id
  std::int32_t num_components = 0;
  std::int64_t num_edges = 0;
  std::int64_t num_disagreeing = 0;  ///< of these, whose two signs contradict each other
};

struct PropagationParameters {
  double max_gap = 0;   ///< longest edge
  double max_step = 0;  ///< an edge that rises more than this above both its points' planes runs between two sheets
};

/// Makes signs agree along the edges of the neighbour graph, best edges first.
///
/// Two normals agree along an edge e if n' equals n turned as a circle's through both points would be: n' is compared
/// with n - 2 (n.e) e where the edge bends, with n itself where it is too short against the noise to tell (Hoppe 1992;
/// Koenig and Gumhold 2009 for the turn). Edges are sorted into 4,096 classes of |cosine|, within a class by point id.
Propagation propagate_signs(std::span<const Eigen::Vector3d> points, std::span<const Eigen::Vector3d> normals,
                            std::span<const double> clarity, const NearestNeighbors& neighbors,
                            const PropagationParameters& parameters, const Execution& execution = {});

}  // namespace meshmser
