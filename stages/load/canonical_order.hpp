#pragma once
/// The order that gives points their ids, and searches that live off it.

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/execution/execution.hpp"

namespace meshmser {

/// A cube cut into 2^21 cells along each axis; a cell's code interleaves the bits of its three numbers (Morton 1966),
/// so that the codes of each coarser cell are consecutive.
struct MortonGrid {
  Eigen::Vector3d corner = Eigen::Vector3d::Zero();
  double cell = 1;  ///< edge of the finest cells

  static constexpr int kBits = 21;
  static constexpr std::int64_t kCells = std::int64_t{1} << kBits;

  /// Number of the finest cell along one axis; positions outside the cube count as in its outermost cells.
  std::int64_t cell_along(int axis, double coordinate) const;
  std::uint64_t code(const Eigen::Vector3d& position) const;
};

/// The smallest cube at the least corner of the points' box. Depends on the set of points only.
MortonGrid morton_grid(std::span<const Eigen::Vector3d> positions);

/// Interleaves the lowest 21 bits of x, y and z; x is the most significant.
std::uint64_t interleave(std::uint64_t x, std::uint64_t y, std::uint64_t z);

/// Exact neighbour searches among points sorted by their Morton code, without any further structure: the points of each
/// cell of each size are a range that binary search finds. Good for a sample of queries; building costs nothing.
class MortonIndex {
 public:
  /// Both spans must outlive the index; codes ascend and codes[i] = grid.code(positions[i]).
  MortonIndex(const MortonGrid& grid, std::span<const std::uint64_t> codes, std::span<const Eigen::Vector3d> positions)
      : grid_(grid), codes_(codes), positions_(positions) {}

  /// Squared distance from point `query` to its k-th nearest other point; infinite when there are fewer. `level` is a
  /// guess of the size of cells (0 .. 21) that serves best, bettered for the next query nearby; the result does not
  /// depend on it.
  double squared_distance_to_neighbor(std::int64_t query, int k, int& level) const;

  /// Calls visit(point) for each point within `radius` of `centre`, in ascending order within each of up to 27 cells.
  template <class Visit>
  void for_each_within(const Eigen::Vector3d& centre, double radius, Visit&& visit) const {
    const int level = level_for(radius);
    visit_block(centre, level, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i)
        if ((positions_[static_cast<std::size_t>(i)] - centre).squaredNorm() <= radius * radius) visit(i);
    });
  }

 private:
  /// Calls visit(begin, end) for the ranges of points in the cells of edge cell * 2^level around the one of `centre`.
  template <class Visit>
  void visit_block(const Eigen::Vector3d& centre, int level, Visit&& visit) const {
    const std::int64_t last = (MortonGrid::kCells - 1) >> level;
    std::int64_t at[3];
    for (int axis = 0; axis < 3; ++axis) at[axis] = grid_.cell_along(axis, centre[axis]) >> level;
    for (std::int64_t x = at[0] - 1; x <= at[0] + 1; ++x)
      for (std::int64_t y = at[1] - 1; y <= at[1] + 1; ++y)
        for (std::int64_t z = at[2] - 1; z <= at[2] + 1; ++z) {
          if (x < 0 || y < 0 || z < 0 || x > last || y > last || z > last) continue;
          const auto [begin, end] = cell_range(x, y, z, level);
          if (begin < end) visit(begin, end);
        }
  }
  std::pair<std::int64_t, std::int64_t> cell_range(std::int64_t x, std::int64_t y, std::int64_t z, int level) const;
  int level_for(double radius) const;

  const MortonGrid& grid_;
  std::span<const std::uint64_t> codes_;
  std::span<const Eigen::Vector3d> positions_;
};

/// Spacing h of definitions 1 for points in canonical order: the median, over every (n / 20,000)-th point, of
/// d16 sqrt(pi / 16.5), d16 the distance to the 16th neighbour. 0 for fewer than 17 points. Same for any number of
/// threads. About 0.1 s at 2.5 million points.
double measure_spacing(const MortonIndex& index, std::int64_t num_points, const Execution& execution = {});

}  // namespace meshmser
