#include "stages/load/canonical_order.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "stages/common/parallel.hpp"

namespace meshmser {
namespace {

/// Moves bit i of the lowest 21 bits to bit 3 i.
std::uint64_t spread(std::uint64_t bits) {
  bits &= 0x1fffff;
  bits = (bits | bits << 32) & 0x001f00000000ffff;
  bits = (bits | bits << 16) & 0x001f0000ff0000ff;
  bits = (bits | bits << 8) & 0x100f00f00f00f00f;
  bits = (bits | bits << 4) & 0x10c30c30c30c30c3;
  return (bits | bits << 2) & 0x1249249249249249;
}

}  // namespace

std::uint64_t interleave(std::uint64_t x, std::uint64_t y, std::uint64_t z) {
  return spread(x) << 2 | spread(y) << 1 | spread(z);
}

std::int64_t MortonGrid::cell_along(int axis, double coordinate) const {
  const double at = (coordinate - corner[axis]) / cell;
  return static_cast<std::int64_t>(std::clamp(at, 0.0, static_cast<double>(kCells - 1)));
}

std::uint64_t MortonGrid::code(const Eigen::Vector3d& position) const {
  return interleave(static_cast<std::uint64_t>(cell_along(0, position.x())),
                    static_cast<std::uint64_t>(cell_along(1, position.y())),
                    static_cast<std::uint64_t>(cell_along(2, position.z())));
}

MortonGrid morton_grid(std::span<const Eigen::Vector3d> positions) {
  MortonGrid grid;
  if (positions.empty()) return grid;
  Eigen::Vector3d low = positions[0], high = positions[0];
  for (const Eigen::Vector3d& p : positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  grid.corner = low;
  const double extent = (high - low).maxCoeff();
  grid.cell = extent > 0 ? extent / static_cast<double>(MortonGrid::kCells) : 1;
  // Coordinates so small that a cell would vanish: one cell holds them all.
  if (!(grid.cell > std::numeric_limits<double>::min())) grid.cell = 1;
  return grid;
}

std::pair<std::int64_t, std::int64_t> MortonIndex::cell_range(std::int64_t x, std::int64_t y, std::int64_t z,
                                                              int level) const {
  const std::uint64_t prefix =
      interleave(static_cast<std::uint64_t>(x), static_cast<std::uint64_t>(y), static_cast<std::uint64_t>(z));
  const std::uint64_t first = prefix << (3 * level), last = first + ((std::uint64_t{1} << (3 * level)) - 1);
  const auto begin = std::lower_bound(codes_.begin(), codes_.end(), first);
  const auto end = std::upper_bound(begin, codes_.end(), last);
  return {begin - codes_.begin(), end - codes_.begin()};
}

int MortonIndex::level_for(double radius) const {
  int level = 0;
  while (level < MortonGrid::kBits && grid_.cell * static_cast<double>(std::int64_t{1} << level) < radius) ++level;
  return level;
}

double MortonIndex::squared_distance_to_neighbor(std::int64_t query, int k, int& level) const {
  const Eigen::Vector3d& centre = positions_[static_cast<std::size_t>(query)];
  std::vector<double> found;
  level = std::clamp(level, 0, MortonGrid::kBits);
  for (;; ++level) {
    found.clear();
    visit_block(centre, level, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i)
        if (i != query) found.push_back((positions_[static_cast<std::size_t>(i)] - centre).squaredNorm());
    });
    const bool enough = found.size() >= static_cast<std::size_t>(k);
    if (enough) std::nth_element(found.begin(), found.begin() + (k - 1), found.end());
    // Every point nearer than one cell's edge lies in the block; half a finest cell is left for rounding.
    const double sure = grid_.cell * (static_cast<double>(std::int64_t{1} << level) - 0.5);
    if (enough && found[static_cast<std::size_t>(k - 1)] <= sure * sure) break;
    if (level == MortonGrid::kBits) break;  // the block is everything
  }
  if (found.size() < static_cast<std::size_t>(k)) return std::numeric_limits<double>::infinity();
  const double squared = found[static_cast<std::size_t>(k - 1)];
  if (found.size() > static_cast<std::size_t>(16 * k) && level > 0) --level;
  return squared;
}

double measure_spacing(const MortonIndex& index, std::int64_t num_points, const Execution& execution) {
  constexpr int kNeighbor = 16;
  constexpr std::int64_t kSample = 20'000;
  if (num_points <= kNeighbor) return 0;
  const std::int64_t step = std::max<std::int64_t>(1, num_points / kSample);
  const std::int64_t sampled = (num_points + step - 1) / step;
  std::vector<double> squared(static_cast<std::size_t>(sampled));
  parallel_chunks(sampled, 500, "spacing", execution, [&](std::int64_t begin, std::int64_t end) {
    int level = 8;
    for (std::int64_t i = begin; i < end; ++i)
      squared[static_cast<std::size_t>(i)] = index.squared_distance_to_neighbor(i * step, kNeighbor, level);
  });
  const auto middle = squared.begin() + static_cast<std::ptrdiff_t>(squared.size() / 2);
  std::nth_element(squared.begin(), middle, squared.end());
  return std::sqrt(*middle) * std::sqrt(std::numbers::pi / (kNeighbor + 0.5));
}

}  // namespace meshmser
