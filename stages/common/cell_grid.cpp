#include "stages/common/cell_grid.hpp"

#include <cmath>

#include "pipeline/execution/error.hpp"

namespace meshmser {
namespace {

constexpr int kRowBits = 22;
constexpr double kMaxCells = 1 << 21;

struct Keyed {
  std::uint64_t key;
  std::int32_t id;
};

// Stable sort by key, least significant digits first; only the digits that occur are visited.
void radix_sort(std::vector<Keyed>& items, std::uint64_t max_key) {
  constexpr int kDigitBits = 11;
  std::vector<Keyed> other(items.size());
  for (int shift = 0; shift < 64 && (max_key >> shift) != 0; shift += kDigitBits) {
    std::array<std::size_t, 1 << kDigitBits> place{};
    const auto digit = [&](const Keyed& item) { return (item.key >> shift) & ((1u << kDigitBits) - 1); };
    for (const Keyed& item : items) ++place[digit(item)];
    std::size_t sum = 0;
    for (std::size_t& entry : place) {
      const std::size_t count = entry;
      entry = sum;
      sum += count;
    }
    for (const Keyed& item : items) other[place[digit(item)]++] = item;
    items.swap(other);
  }
}

}  // namespace

CellGrid::CellGrid(std::span<const Eigen::Vector3d> points, double cell) {
  if (!(cell > 0) || !std::isfinite(cell)) throw StageError("internal: a cell grid needs a positive cell size");
  const std::size_t n = points.size();
  Eigen::Vector3d low = Eigen::Vector3d::Zero(), high = Eigen::Vector3d::Zero();
  if (n > 0) low = high = points.front();
  for (const Eigen::Vector3d& p : points) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const Eigen::Vector3d extent = (high - low) / cell;
  if (!(extent.maxCoeff() < kMaxCells))
    throw StageError("the points extend over more than 2 million cells of " + std::to_string(cell) +
                     " units along an axis: crop the cloud, remove far-away outliers, or use a larger radius");
  const auto nx = static_cast<std::uint64_t>(extent.x()) + 1, ny = static_cast<std::uint64_t>(extent.y()) + 1;
  const auto nz = static_cast<std::uint64_t>(extent.z()) + 1;

  std::vector<Keyed> items(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector3d c = (points[i] - low) / cell;
    const auto x = static_cast<std::uint64_t>(c.x()), y = static_cast<std::uint64_t>(c.y());
    const auto z = static_cast<std::uint64_t>(c.z());
    items[i] = {(z * ny + y) * nx + x, static_cast<std::int32_t>(i)};
  }
  radix_sort(items, nx * ny * nz - 1);

  ids_.resize(n);
  x_.resize(n);
  y_.resize(n);
  z_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const auto& [key, id] = items[i];
    const Eigen::Vector3d& p = points[static_cast<std::size_t>(id)];
    ids_[i] = id;
    x_[i] = p.x();
    y_[i] = p.y();
    z_[i] = p.z();
    if (i > 0 && key == items[i - 1].key) continue;
    const std::uint64_t row = key / nx;
    const auto row_key = static_cast<std::int64_t>(((row / ny) << kRowBits) + row % ny);
    if (rows_.empty() || rows_.back().key != row_key)
      rows_.push_back({row_key, static_cast<std::int32_t>(cells_.size())});
    cells_.push_back({static_cast<std::int32_t>(key % nx), static_cast<std::int32_t>(i)});
  }
  rows_.push_back({-1, static_cast<std::int32_t>(cells_.size())});
  cells_.push_back({-1, static_cast<std::int32_t>(n)});
}

void CellSweep::start_row(std::int64_t row_index) {
  windows_.clear();
  const auto all = grid_.rows();
  const std::int64_t key = all[static_cast<std::size_t>(row_index)].key;
  for (std::int64_t dz = -reach_; dz <= reach_; ++dz) {
    // The rows y - reach .. y + reach of one layer are neighbours in the list.
    const std::int64_t first = key + (dz * (std::int64_t{1} << kRowBits)) - reach_, last = first + 2 * reach_;
    auto row = std::lower_bound(all.begin(), all.end(), first,
                                [](const CellGrid::Row& r, std::int64_t value) { return r.key < value; });
    for (; row != all.end() && row->key <= last; ++row) {
      const std::size_t index = static_cast<std::size_t>(row - all.begin());
      windows_.push_back({row->first_cell, row->first_cell, grid_.rows_[index + 1].first_cell, row->key == key});
    }
  }
}

void CellSweep::gather(std::int32_t cell) {
  const auto& cells = grid_.cells_;
  const std::int32_t x = cells[static_cast<std::size_t>(cell)].x;
  std::int64_t count = 0;
  for (Window& w : windows_) {
    while (w.lo < w.end && cells[static_cast<std::size_t>(w.lo)].x < x - reach_) ++w.lo;
    w.hi = std::max(w.hi, w.lo);
    while (w.hi < w.end && cells[static_cast<std::size_t>(w.hi)].x <= x + reach_) ++w.hi;
    count += cells[static_cast<std::size_t>(w.hi)].first_point - cells[static_cast<std::size_t>(w.lo)].first_point;
  }
  block_.num_candidates = count;
  block_.padded = (count + kLanes - 1) / kLanes * kLanes;
  if (block_.x.size() < static_cast<std::size_t>(block_.padded)) {
    const std::size_t room = static_cast<std::size_t>(block_.padded) * 2;
    block_.x.resize(room), block_.y.resize(room), block_.z.resize(room), block_.ids.resize(room);
  }
  const auto own_first = static_cast<std::size_t>(cells[static_cast<std::size_t>(cell)].first_point);
  const double cx = grid_.x_[own_first], cy = grid_.y_[own_first], cz = grid_.z_[own_first];
  std::size_t out = 0;
  for (const Window& w : windows_) {
    const auto begin = static_cast<std::size_t>(cells[static_cast<std::size_t>(w.lo)].first_point);
    const auto end = static_cast<std::size_t>(cells[static_cast<std::size_t>(w.hi)].first_point);
    if (w.own) {
      block_.own_begin = static_cast<std::int64_t>(out + own_first - begin);
      block_.own_end = block_.own_begin + cells[static_cast<std::size_t>(cell) + 1].first_point -
                       cells[static_cast<std::size_t>(cell)].first_point;
    }
    for (std::size_t i = begin; i < end; ++i, ++out) {
      block_.x[out] = grid_.x_[i] - cx;
      block_.y[out] = grid_.y_[i] - cy;
      block_.z[out] = grid_.z_[i] - cz;
      block_.ids[out] = grid_.ids_[i];
    }
  }
  for (; out < static_cast<std::size_t>(block_.padded); ++out) {
    block_.x[out] = block_.y[out] = block_.z[out] = 1e150;  // its square is still finite
    block_.ids[out] = block_.ids[0];
  }
}

}  // namespace meshmser
