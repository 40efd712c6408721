#include "stages/tree/exclusion.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "stages/common/adjacency.hpp"
#include "stages/common/parallel.hpp"

namespace meshmser {
namespace {

struct Segment {
  Eigen::Vector3d from, to;
};

/// Edges of the rims longer than `min_rim`.
std::vector<Segment> long_rims(std::span<const Eigen::Vector3d> positions,
                               std::span<const std::array<std::int32_t, 3>> triangles,
                               std::span<const std::int32_t> twins, double min_rim, std::int64_t& num_rims) {
  std::vector<Segment> result, rim;
  std::vector<std::uint8_t> walked(twins.size(), 0);
  auto corner = [&](std::int32_t half_edge) -> const Eigen::Vector3d& {
    return positions[static_cast<std::size_t>(
        triangles[static_cast<std::size_t>(half_edge) / 3][static_cast<std::size_t>(half_edge) % 3])];
  };
  for (std::size_t h = 0; h < twins.size(); ++h) {
    if (twins[h] >= 0 || walked[h]) continue;
    rim.clear();
    double length = 0;
    auto half_edge = static_cast<std::int32_t>(h);
    do {
      walked[static_cast<std::size_t>(half_edge)] = 1;
      rim.push_back({corner(half_edge), corner(next_half_edge(half_edge))});
      length += (rim.back().to - rim.back().from).norm();
      half_edge = next_half_edge(half_edge);
      while (twins[static_cast<std::size_t>(half_edge)] >= 0)
        half_edge = next_half_edge(twins[static_cast<std::size_t>(half_edge)]);
    } while (half_edge != static_cast<std::int32_t>(h));
    if (length <= min_rim) continue;
    ++num_rims;
    result.insert(result.end(), rim.begin(), rim.end());
  }
  return result;
}

/// Segments in cubes by their middle; a point asks the 27 cubes around it.
class SegmentGrid {
 public:
  using Cell = std::array<std::int64_t, 3>;

  SegmentGrid(std::vector<Segment> segments, double distance) : distance_(distance) {
    double longest = 0;
    low_ = segments.front().from;
    for (const Segment& s : segments) {
      longest = std::max(longest, (s.to - s.from).norm());
      low_ = low_.cwiseMin(s.from).cwiseMin(s.to);
    }
    size_ = distance + longest / 2;
    for (const Segment& s : segments) entries_.push_back({key(cell((s.from + s.to) / 2)), s});
    std::stable_sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) { return a.key < b.key; });
  }

  /// The segments that may be near a point of the cell, for several points of one cell in a row.
  struct Nearby {
    std::optional<Cell> cell;
    std::vector<Segment> segments;
  };

  bool is_near(const Eigen::Vector3d& point, Nearby& nearby) const {
    const Cell c = cell(point);
    if (nearby.cell != c) find_nearby(c, nearby);
    return std::any_of(nearby.segments.begin(), nearby.segments.end(),
                       [&](const Segment& segment) { return distance_to(point, segment) < distance_; });
  }

 private:
  void find_nearby(const Cell& c, Nearby& nearby) const {
    nearby.cell = c;
    nearby.segments.clear();
    for (std::int64_t z = c[2] - 1; z <= c[2] + 1; ++z)
      for (std::int64_t y = c[1] - 1; y <= c[1] + 1; ++y) {
        const Key from = key({c[0] - 1, y, z}), to = key({c[0] + 1, y, z});
        auto i = std::lower_bound(entries_.begin(), entries_.end(), from,
                                  [](const Entry& entry, const Key& k) { return entry.key < k; });
        for (; i != entries_.end() && i->key <= to; ++i) nearby.segments.push_back(i->segment);
      }
  }

  using Key = std::array<std::int64_t, 3>;  ///< z, y, x
  struct Entry {
    Key key;
    Segment segment;
  };

  Cell cell(const Eigen::Vector3d& point) const {
    const Eigen::Vector3d scaled = (point - low_) / size_;
    return {static_cast<std::int64_t>(std::floor(scaled[0])), static_cast<std::int64_t>(std::floor(scaled[1])),
            static_cast<std::int64_t>(std::floor(scaled[2]))};
  }
  static Key key(const Cell& c) { return {c[2], c[1], c[0]}; }

  static double distance_to(const Eigen::Vector3d& point, const Segment& s) {
    const Eigen::Vector3d along = s.to - s.from;
    const double square = along.squaredNorm();
    const double place = square > 0 ? std::clamp((point - s.from).dot(along) / square, 0.0, 1.0) : 0.0;
    return (point - s.from - place * along).norm();
  }

  double distance_, size_ = 1;
  Eigen::Vector3d low_;
  std::vector<Entry> entries_;
};

}  // namespace

Exclusion exclude_triangles(std::span<const Eigen::Vector3d> positions,
                            std::span<const std::array<std::int32_t, 3>> triangles, std::span<const std::int32_t> twins,
                            std::span<const double> values, double rim_distance, double min_rim,
                            const Execution& execution) {
  Exclusion result;
  std::vector<std::uint8_t> near(positions.size(), 0);
  if (rim_distance > 0) {
    std::vector<Segment> rims = long_rims(positions, triangles, twins, min_rim, result.num_rims);
    if (!rims.empty()) {
      const SegmentGrid grid(std::move(rims), rim_distance);
      parallel_chunks(static_cast<std::int64_t>(positions.size()), 1 << 12, "rims", execution,
                      [&](std::int64_t begin, std::int64_t end) {
                        SegmentGrid::Nearby nearby;
                        for (auto v = static_cast<std::size_t>(begin); v < static_cast<std::size_t>(end); ++v)
                          near[v] = grid.is_near(positions[v], nearby);
                      });
    }
  }
  result.excluded_of_triangle.assign(triangles.size(), 0);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    bool nan = false, rim = false;
    for (const std::int32_t corner : triangles[t]) {
      nan |= !std::isfinite(values[static_cast<std::size_t>(corner)]);
      rim |= near[static_cast<std::size_t>(corner)] != 0;
    }
    result.excluded_of_triangle[t] = nan || rim;
    result.num_nan += nan;
    result.num_near_rim += !nan && rim;
  }
  return result;
}

}  // namespace meshmser
