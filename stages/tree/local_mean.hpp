#pragma once
/// A scalar's slow part, to be taken off it (definitions 5, `detrend`).

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/execution/execution.hpp"

namespace meshmser {

/// A third of the area of each triangle at every corner of it. #V. Triangles with excluded[t] != 0 (may be empty) count
/// nothing. Linear time; the same on any number of threads.
std::vector<double> vertex_areas(std::span<const std::array<std::int32_t, 3>> triangles, std::span<const double> areas,
                                 std::span<const std::uint8_t> excluded, std::size_t num_vertices);

/// The mean of the values around every vertex, weighted by area, within a Euclidean ball of `radius`.
///
/// `positions`, `values`, `weights` (areas, >= 0): #V; vertices whose value is not finite or whose weight is 0 count
/// nothing. `radius` > 0, in coordinate units. Returns #V means; NaN where the ball holds no weight.
///
/// The vertices are gathered in cubes of side max(radius / 8, the size that holds one vertex or so), each standing for
/// its vertices at their centre of mass, and the ball's surface is a ramp one cube wide: on smooth data the mean
/// is within 1 % of the values' spread of the exact one (tested). Time: about 300 cubes a vertex, whatever the radius;
/// deterministic on any number of threads.
std::vector<double> local_means(std::span<const Eigen::Vector3d> positions, std::span<const double> values,
                                std::span<const double> weights, double radius, const Execution& execution = {});

/// The level of the ground: the local mean of values that are clipped where they differ by more than `clip` median
/// deviations from the median of all, then twice from the local mean before (the deviation: the median of |value -
/// mean| over the vertices with weight). Lines that take less than half of the surface, and sharp edges, hardly tilt
/// it, while a mean they do. As local_means otherwise, three times its cost.
std::vector<double> clipped_local_means(std::span<const Eigen::Vector3d> positions, std::span<const double> values,
                                        std::span<const double> weights, double radius, double clip,
                                        const Execution& execution = {});

}  // namespace meshmser
