#pragma once
/// Points sorted into cubic cells, and a sweep over the cells that hands out each cell's surroundings as one block of
/// contiguous coordinates: all points of a cell share one gathering of candidates.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "stages/common/parallel.hpp"
#include "stages/common/simd.hpp"

namespace meshmser {

/// Cells are ordered by z, y, x; points within a cell by id. Nothing is stored for empty cells, so that far-away strays
/// cost nothing.
class CellGrid {
 public:
  /// Sorts the points into cells of edge length `cell` > 0. Throws StageError where the points extend over more than
  /// 2^21 cells along an axis. O(n); keeps 32 bytes a point.
  CellGrid(std::span<const Eigen::Vector3d> points, double cell);

  struct Cell {
    std::int32_t x = 0;
    std::int32_t first_point = 0;  ///< position in the sorted order; the next cell's is the end
  };
  struct Row {
    std::int64_t key = 0;  ///< z 2^22 + y
    std::int32_t first_cell = 0;
  };

  std::span<const std::int32_t> ids() const { return ids_; }  ///< point of each place in the sorted order
  std::span<const Row> rows() const { return {rows_.data(), rows_.size() - 1}; }
  std::int64_t num_points() const { return static_cast<std::int64_t>(ids_.size()); }

 private:
  friend class CellSweep;
  std::vector<std::int32_t> ids_;
  std::vector<double> x_, y_, z_;  // in sorted order, as given
  std::vector<Cell> cells_;        // and a sentinel
  std::vector<Row> rows_;          // and a sentinel
};

/// The points of one cell with everything around them. Coordinates are relative to the cell's first point. Places
/// num_candidates .. padded are filled with points too far away to count, so that whole groups of lanes can be read.
struct CellBlock {
  std::vector<double> x, y, z;    ///< padded to a multiple of kLanes
  std::vector<std::int32_t> ids;  ///< padded with the first candidate's
  std::int64_t num_candidates = 0;
  std::int64_t padded = 0;
  std::int64_t own_begin = 0, own_end = 0;  ///< the cell's own points among the candidates
};

/// Walks along rows of cells and gathers blocks.
class CellSweep {
 public:
  CellSweep(const CellGrid& grid, int reach) : grid_(grid), reach_(reach) {}

  /// Calls body(block) for every cell of the row with the points of all cells at most `reach` cells away.
  template <class Body>
  void row(std::int64_t row_index, Body&& body) {
    start_row(row_index);
    const auto first = grid_.rows_[static_cast<std::size_t>(row_index)].first_cell;
    const auto last = grid_.rows_[static_cast<std::size_t>(row_index) + 1].first_cell;
    for (std::int32_t cell = first; cell < last; ++cell) {
      gather(cell);
      body(static_cast<const CellBlock&>(block_));
    }
  }

 private:
  void start_row(std::int64_t row_index);
  void gather(std::int32_t cell);

  struct Window {
    std::int32_t lo, hi, end;  // cells
    bool own;
  };
  const CellGrid& grid_;
  int reach_;
  std::vector<Window> windows_;
  CellBlock block_;
};

/// Calls body(block) once for every occupied cell of the grid, from several threads; what a block holds, and in which
/// order, does not depend on the threads. `reach` is in cells: a ball of radius reach * cell about any point of the
/// block's own cell lies within the block.
template <class Body>
void for_each_cell(const CellGrid& grid, int reach, std::string_view what, const Execution& execution, Body&& body) {
  const std::int64_t num_rows = static_cast<std::int64_t>(grid.rows().size());
  if (num_rows == 0) return;
  const std::int64_t grain = std::max<std::int64_t>(1, num_rows * 2048 / grid.num_points());
  parallel_chunks(num_rows, grain, what, execution, [&](std::int64_t begin, std::int64_t end) {
    CellSweep sweep(grid, reach);
    for (std::int64_t row = begin; row < end; ++row) sweep.row(row, body);
  });
}

}  // namespace meshmser
