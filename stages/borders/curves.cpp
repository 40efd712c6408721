#include "stages/borders/curves.hpp"

#include <algorithm>
#include <atomic>
#include <string>

#include "stages/common/adjacency.hpp"
#include "stages/common/parallel.hpp"

namespace meshmser {
namespace {

/// Rounds of averaging; more change nothing that can be seen, since a wave of ten points is flat after them.
constexpr int kSmoothingRounds = 30;

/// So many points an edge, and this many more, are more than any mesh has but one with a hub: about three an edge are
/// usual.
constexpr std::int64_t kPointsPerEdge = 64, kMorePoints = std::int64_t{1} << 22;

/// The vertex at which most triangles meet is to blame: a curve runs through all of those outside each time.
[[noreturn]] void refuse_hub(const SurfaceView& surface, std::int64_t most) {
  std::vector<std::int32_t> num_triangles(surface.positions.size(), 0);
  for (const auto& corners : surface.triangles)
    for (const std::int32_t v : corners) ++num_triangles[static_cast<std::size_t>(v)];
  const std::int32_t hub = *std::max_element(num_triangles.begin(), num_triangles.end());
  throw StageError("interpolated borders would have more than " + std::to_string(most) +
                   " points: " + std::to_string(hub) +
                   " triangles meet at one vertex, and the curve of every region there runs through those outside it; "
                   "set borders.interpolate to false, or leave small regions out (mser.min_area)");
}

struct Point {
  Eigen::Vector3d position;
  EdgeKind kind;  ///< of the piece that begins here
};

/// The curve of one loop.
class CurveWalk {
 public:
  CurveWalk(const SurfaceView& surface, std::span<const double> values, const BorderRegion& region)
      : surface_(surface),
        values_(values),
        tree_(*region.tree),
        node_(region.node),
        first_node_(tree_.first_node_of_subtree[static_cast<std::size_t>(region.node)]),
        sign_(tree_.sign(region.node)),
        level_(sign_ * tree_.value(region.node)),
        is_open_(tree_.polarity == Polarity::kShapes && sign_ < 0) {}

  std::vector<Point> run(std::span<const std::int32_t> loop) {
    for (std::size_t i = 0; i < loop.size(); ++i) turn(loop[i], loop[(i + 1) % loop.size()]);
    // The last point's piece leads to the first point.
    while (points_.size() > 1 && points_.back().position == points_.front().position) points_.pop_back();
    return std::move(points_);
  }

 private:
  bool inside(std::int32_t half_edge) const {
    const std::int32_t node = tree_.node_of_triangle[static_cast<std::size_t>(half_edge) / 3];
    return node >= first_node_ && node <= node_;
  }
  std::int32_t twin(std::int32_t half_edge) const { return surface_.twins[static_cast<std::size_t>(half_edge)]; }
  std::int32_t start(std::int32_t half_edge) const {
    return surface_.triangles[static_cast<std::size_t>(half_edge) / 3][static_cast<std::size_t>(half_edge) % 3];
  }
  const Eigen::Vector3d& position(std::int32_t vertex) const {
    return surface_.positions[static_cast<std::size_t>(vertex)];
  }

  void add(const Eigen::Vector3d& point, EdgeKind kind) {
    if (!points_.empty() && points_.back().position == point)
      points_.back().kind = kind;
    else
      points_.push_back({point, kind});
  }

  /// Where S falls to the level on the edge from a border vertex to an outside one; the border vertex where it does
  /// not.
  Eigen::Vector3d crossing(std::int32_t border, std::int32_t outside) const {
    const double high = sign_ * values_[static_cast<std::size_t>(border)];
    const double low = sign_ * values_[static_cast<std::size_t>(outside)];
    if (!(is_open_ ? low <= level_ : low < level_)) return position(border);
    return position(border) + (high - level_) / (high - low) * (position(outside) - position(border));
  }

  enum class FanEnd { kNextEdge, kRim, kPinch };

  /// Outside vertices of the fan on the right of `in` about its end, in order; where the fan ends.
  FanEnd fan_after(std::int32_t in, std::int32_t out, std::vector<std::int32_t>& vertices) const {
    std::int32_t from_centre = twin(in);
    while (true) {
      const std::int32_t to_centre = previous_half_edge(from_centre);
      const std::int32_t across = twin(to_centre);
      if (across >= 0 && inside(across)) return across == out ? FanEnd::kNextEdge : FanEnd::kPinch;
      vertices.push_back(start(to_centre));
      if (across < 0) return FanEnd::kRim;
      from_centre = across;
    }
  }

  /// The same on the right of `out` about its start, backward; it ends at a rim or at another part of the region.
  FanEnd fan_before(std::int32_t out, std::vector<std::int32_t>& vertices) const {
    std::int32_t to_centre = twin(out);
    while (true) {
      const std::int32_t from_centre = next_half_edge(to_centre);
      const std::int32_t across = twin(from_centre);
      if (across >= 0 && inside(across)) return FanEnd::kPinch;
      vertices.push_back(start(next_half_edge(from_centre)));
      if (across < 0) return FanEnd::kRim;
      to_centre = across;
    }
  }

  /// The curve's part about the vertex between two half-edges of the loop.
  void turn(std::int32_t in, std::int32_t out) {
    const std::int32_t vertex = start(out);
    const EdgeKind kind_of_out = twin(out) < 0 ? EdgeKind::kHole : EdgeKind::kLevel;
    bool through_vertex = twin(in) < 0 || twin(out) < 0;
    if (twin(in) >= 0) {
      fan_.clear();
      const FanEnd end = fan_after(in, out, fan_);
      if (end != FanEnd::kPinch)
        for (const std::int32_t outside : fan_) add(crossing(vertex, outside), EdgeKind::kLevel);
      if (end == FanEnd::kNextEdge) return;
      if (end == FanEnd::kRim) points_.back().kind = EdgeKind::kHole;
      through_vertex = true;
    }
    if (through_vertex) add(position(vertex), kind_of_out);
    if (twin(out) >= 0) {
      fan_.clear();
      if (fan_before(out, fan_) == FanEnd::kPinch) return;
      points_.back().kind = EdgeKind::kHole;
      for (std::size_t i = fan_.size(); i-- > 0;) add(crossing(vertex, fan_[i]), EdgeKind::kLevel);
    }
  }

  SurfaceView surface_;
  std::span<const double> values_;
  const ComponentTree& tree_;
  std::int32_t node_, first_node_;
  double sign_, level_;
  bool is_open_;  ///< inside S is less than the level, not equal to it
  std::vector<Point> points_;
  std::vector<std::int32_t> fan_;
};

}  // namespace

BorderCurves interpolate_borders(const SurfaceView& surface, std::span<const double> values, const BorderLoops& loops,
                                 std::span<const BorderRegion> regions, const Execution& execution) {
  for (const std::int32_t owner : loops.owner_of_loop)
    if (owner < 1 || static_cast<std::size_t>(owner) > regions.size())
      throw StageError("a border loop belongs to region " + std::to_string(owner) + ", but there are " +
                       std::to_string(regions.size()) + " regions");
  std::vector<std::vector<Point>> curves(loops.num_loops());
  const std::int64_t most = kPointsPerEdge * static_cast<std::int64_t>(loops.half_edges.size()) + kMorePoints;
  std::atomic<std::int64_t> num_points{0};
  parallel_chunks(
      static_cast<std::int64_t>(loops.num_loops()), 64, "curves", execution, [&](std::int64_t begin, std::int64_t end) {
        for (auto l = static_cast<std::size_t>(begin); l < static_cast<std::size_t>(end); ++l) {
          if (num_points > most) return;
          const std::int64_t first = loops.first_edge_of_loop[l];
          CurveWalk walk(surface, values, regions[static_cast<std::size_t>(loops.owner_of_loop[l] - 1)]);
          curves[l] = walk.run(
              {loops.half_edges.data() + first, static_cast<std::size_t>(loops.first_edge_of_loop[l + 1] - first)});
          num_points += static_cast<std::int64_t>(curves[l].size());
        }
      });
  if (num_points > most) refuse_hub(surface, most);
  BorderCurves result;
  result.first_point_of_curve.push_back(0);
  for (const std::vector<Point>& curve : curves) {
    for (const Point& point : curve) {
      result.points.push_back(point.position);
      result.kinds.push_back(point.kind);
    }
    result.first_point_of_curve.push_back(static_cast<std::int64_t>(result.points.size()));
  }
  return result;
}

BorderCurves smooth_curves(const BorderCurves& curves, double tolerance, const Execution& execution) {
  BorderCurves result = curves;
  const auto num_curves = static_cast<std::int64_t>(curves.first_point_of_curve.size()) - 1;
  parallel_chunks(num_curves, 64, "curves", execution, [&](std::int64_t begin, std::int64_t end) {
    std::vector<Eigen::Vector3d> next;
    for (auto c = static_cast<std::size_t>(begin); c < static_cast<std::size_t>(end); ++c) {
      const auto first = static_cast<std::size_t>(curves.first_point_of_curve[c]);
      const std::size_t n = static_cast<std::size_t>(curves.first_point_of_curve[c + 1]) - first;
      next.resize(n);
      for (int round = 0; round < kSmoothingRounds; ++round) {
        for (std::size_t i = 0; i < n; ++i) {
          const std::size_t before = first + (i + n - 1) % n, here = first + i, after = first + (i + 1) % n;
          next[i] = result.points[here];
          if (curves.kinds[before] == EdgeKind::kHole || curves.kinds[here] == EdgeKind::kHole) continue;
          const Eigen::Vector3d goal =
              0.5 * result.points[here] + 0.25 * (result.points[before] + result.points[after]);
          const Eigen::Vector3d moved = goal - curves.points[here];
          const double distance = moved.norm();
          next[i] = distance > tolerance ? curves.points[here] + moved * (tolerance / distance) : goal;
        }
        std::copy(next.begin(), next.end(), result.points.begin() + static_cast<std::ptrdiff_t>(first));
      }
    }
  });
  return result;
}

}  // namespace meshmser
