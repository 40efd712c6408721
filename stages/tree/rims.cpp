#include "stages/tree/rims.hpp"

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

/// Segments in cubes by their middle; a point asks the 27 cubes around it.
class SegmentGrid {
 public:
  using Cell = std::array<std::int64_t, 3>;

  SegmentGrid(std::span<const RimSegment> segments, double distance) : distance_(distance) {
    double longest = 0;
    low_ = segments.front().first;
    for (const auto& [from, to] : segments) {
      longest = std::max(longest, (to - from).norm());
      low_ = low_.cwiseMin(from).cwiseMin(to);
    }
    size_ = distance + longest / 2;
    for (const auto& [from, to] : segments) entries_.push_back({key(cell((from + to) / 2)), {from, to}});
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

LongRims find_long_rims(std::span<const Eigen::Vector3d> positions,
                        std::span<const std::array<std::int32_t, 3>> triangles, std::span<const std::int32_t> twins,
                        double min_rim) {
  LongRims result;
  std::vector<std::int32_t> rim;
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
      rim.push_back(half_edge);
      length += (corner(next_half_edge(half_edge)) - corner(half_edge)).norm();
      half_edge = next_half_edge(half_edge);
      while (twins[static_cast<std::size_t>(half_edge)] >= 0)
        half_edge = next_half_edge(twins[static_cast<std::size_t>(half_edge)]);
    } while (half_edge != static_cast<std::int32_t>(h));
    if (length <= min_rim) continue;
    ++result.num_rims;
    for (const std::int32_t edge : rim) result.segments.emplace_back(corner(edge), corner(next_half_edge(edge)));
    result.half_edges.insert(result.half_edges.end(), rim.begin(), rim.end());
  }
  return result;
}

std::vector<std::uint8_t> points_near(std::span<const Eigen::Vector3d> points, std::span<const RimSegment> segments,
                                      double distance, const Execution& execution) {
  std::vector<std::uint8_t> near(points.size(), 0);
  if (segments.empty() || !(distance > 0)) return near;
  const SegmentGrid grid(segments, distance);
  parallel_chunks(static_cast<std::int64_t>(points.size()), 1 << 12, "rims", execution,
                  [&](std::int64_t begin, std::int64_t end) {
                    SegmentGrid::Nearby nearby;
                    for (auto p = static_cast<std::size_t>(begin); p < static_cast<std::size_t>(end); ++p)
                      near[p] = grid.is_near(points[p], nearby);
                  });
  return near;
}

}  // namespace meshmser
