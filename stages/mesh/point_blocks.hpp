#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <vector>

namespace meshmser {

/// Points sorted into cubes of one size, so that the points of a cube and of the cubes around it are found at once. One
/// look-up serves all points of a cube: much cheaper than a search for each point where every point needs its
/// neighbours.
class PointBlocks {
 public:
  /// `positions` finite; `size` > 0, made larger where the points' extent would need more than 2^20 cubes along an
  /// axis. n log n, deterministic.
  PointBlocks(const std::vector<Eigen::Vector3d>& positions, double size);

  double size() const { return size_; }
  std::int64_t num_blocks() const { return static_cast<std::int64_t>(keys_.size()); }
  /// The points of a block, ascending.
  const std::int32_t* begin(std::int64_t block) const {
    return points_.data() + first_[static_cast<std::size_t>(block)];
  }
  const std::int32_t* end(std::int64_t block) const {
    return points_.data() + first_[static_cast<std::size_t>(block) + 1];
  }

  /// Appends the points of the block and of those within `rings` blocks of it along each axis, by block, then
  /// ascending. Every point nearer than rings * size() to a point of the block is among them.
  void gather(std::int64_t block, int rings, std::vector<std::int32_t>& points) const;

 private:
  std::int64_t find(std::uint64_t key) const;

  double size_;
  std::vector<std::uint64_t> keys_;         ///< of each block, ascending: z, y, x in 21 bits each
  std::vector<std::int64_t> first_;         ///< #blocks + 1
  std::vector<std::int32_t> points_;        ///< #P
  std::vector<std::int32_t> hashed_block_;  ///< open addressing, -1 empty
  std::uint64_t hash_mask_ = 0;
};

/// A side for the blocks of a cloud of this spacing (0: not known): three spacings, so that a block and those around it
/// hold the points that matter to nearly all of its points.
inline double block_size(double spacing, double max_edge) {
  return spacing > 0 ? 3 * std::min(spacing, max_edge) : max_edge;
}

}  // namespace meshmser
