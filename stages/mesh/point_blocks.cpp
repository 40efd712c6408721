#include "stages/mesh/point_blocks.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace meshmser {
namespace {

constexpr int kBits = 21;
constexpr std::uint64_t kAxisMask = (std::uint64_t{1} << kBits) - 1;

std::uint64_t hash(std::uint64_t key) {
  key *= 0x9E3779B97F4A7C15u;
  return key ^ (key >> 29);
}

}  // namespace

PointBlocks::PointBlocks(const std::vector<Eigen::Vector3d>& positions, double size) : size_(size), first_(1, 0) {
  if (positions.empty()) return;
  Eigen::Vector3d low = positions[0], high = positions[0];
  for (const Eigen::Vector3d& p : positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  size_ = std::max(size, (high - low).maxCoeff() / (1 << (kBits - 1)));

  std::vector<std::pair<std::uint64_t, std::int32_t>> keyed(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    // Blocks count from 1 along each axis.
    const Eigen::Vector3d cell = (positions[i] - low) / size_;
    const auto axis = [&](int a) { return static_cast<std::uint64_t>(cell[a]) + 1; };
    keyed[i] = {axis(2) << (2 * kBits) | axis(1) << kBits | axis(0), static_cast<std::int32_t>(i)};
  }
  std::sort(keyed.begin(), keyed.end());
  points_.reserve(keyed.size());
  for (const auto& [key, point] : keyed) {
    if (keys_.empty() || keys_.back() != key) {
      if (!keys_.empty()) first_.push_back(static_cast<std::int64_t>(points_.size()));
      keys_.push_back(key);
    }
    points_.push_back(point);
  }
  first_.push_back(static_cast<std::int64_t>(points_.size()));

  hash_mask_ = std::bit_ceil(2 * keys_.size()) - 1;
  hashed_block_.assign(hash_mask_ + 1, -1);
  for (std::size_t block = 0; block < keys_.size(); ++block) {
    std::uint64_t place = hash(keys_[block]) & hash_mask_;
    while (hashed_block_[place] >= 0) place = (place + 1) & hash_mask_;
    hashed_block_[place] = static_cast<std::int32_t>(block);
  }
}

std::int64_t PointBlocks::find(std::uint64_t key) const {
  for (std::uint64_t place = hash(key) & hash_mask_; hashed_block_[place] >= 0; place = (place + 1) & hash_mask_)
    if (keys_[static_cast<std::size_t>(hashed_block_[place])] == key) return hashed_block_[place];
  return -1;
}

void PointBlocks::gather(std::int64_t block, int rings, std::vector<std::int32_t>& points) const {
  const std::uint64_t key = keys_[static_cast<std::size_t>(block)];
  const auto axis = [&](int a) { return static_cast<std::int64_t>(key >> (a * kBits) & kAxisMask); };
  const auto in_range = [](std::int64_t i) { return i > 0 && i <= static_cast<std::int64_t>(kAxisMask); };
  for (std::int64_t z = axis(2) - rings; z <= axis(2) + rings; ++z) {
    for (std::int64_t y = axis(1) - rings; y <= axis(1) + rings; ++y) {
      if (!in_range(z) || !in_range(y)) continue;
      for (std::int64_t x = axis(0) - rings; x <= axis(0) + rings; ++x) {
        if (!in_range(x)) continue;
        const auto u = [](std::int64_t i) { return static_cast<std::uint64_t>(i); };
        const std::int64_t found = find(u(z) << (2 * kBits) | u(y) << kBits | u(x));
        if (found >= 0) points.insert(points.end(), begin(found), end(found));
      }
    }
  }
}

}  // namespace meshmser
