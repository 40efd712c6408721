#include "stages/mesh/close_loops.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "stages/common/adjacency.hpp"
#include "stages/mesh/voronoi_stars.hpp"

namespace meshmser {
namespace {

using Eigen::Vector3d;

std::size_t at(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

/// The rim of a mesh: half-edges without twin, by the points they leave and enter.
class Rim {
 public:
  Rim(const std::vector<Triangle>& triangles, const std::vector<Vector3d>& positions,
      const std::vector<Vector3d>& normals)
      : triangles_(triangles), positions_(positions), normals_(normals) {
    const std::vector<std::int32_t> twins = twin_half_edges(triangles, positions.size());
    for (std::size_t h = 0; h < twins.size(); ++h)
      if (twins[h] < 0) half_edges_.push_back(static_cast<std::int32_t>(h));
    link();
  }

  std::int32_t from(std::int32_t h) const { return triangles_[at(h / 3)][at(h % 3)]; }
  std::int32_t to(std::int32_t h) const { return from(next_half_edge(h)); }

  /// The points around each gap, counter-clockwise as triangles in the gap would run, of at most `max_edges` edges;
  /// shorter ones first, then by least half-edge.
  std::vector<std::vector<std::int32_t>> short_loops(int max_edges) const {
    std::vector<std::vector<std::int32_t>> loops;
    std::vector<std::uint8_t> seen(half_edges_.size(), 0);
    std::vector<std::int32_t> loop;
    for (std::size_t start = 0; start < half_edges_.size(); ++start) {
      loop.clear();
      for (std::size_t i = start; !seen[i]; i = next_[i]) {
        seen[i] = 1;
        loop.push_back(from(half_edges_[i]));
      }
      if (loop.size() >= 3 && loop.size() <= static_cast<std::size_t>(max_edges)) loops.push_back(loop);
    }
    std::stable_sort(loops.begin(), loops.end(), [](const auto& a, const auto& b) { return a.size() < b.size(); });
    return loops;
  }

 private:
  /// After half-edge v -> u, whose gap side runs u -> v, the gap goes on along v -> w, where the half-edge w -> v ends
  /// the fan that is nearest clockwise from u.
  void link() {
    const std::size_t n = half_edges_.size();
    std::vector<std::size_t> leaving(n), entering(n);
    for (std::size_t i = 0; i < n; ++i) leaving[i] = entering[i] = i;
    std::stable_sort(leaving.begin(), leaving.end(),
                     [&](std::size_t a, std::size_t b) { return from(half_edges_[a]) < from(half_edges_[b]); });
    std::stable_sort(entering.begin(), entering.end(),
                     [&](std::size_t a, std::size_t b) { return to(half_edges_[a]) < to(half_edges_[b]); });
    next_.resize(n);
    // As many half-edges of the rim enter a point as leave it: the two lists run in step.
    for (std::size_t begin = 0, end = 0; begin < n; begin = end) {
      const std::int32_t v = from(half_edges_[leaving[begin]]);
      for (end = begin; end < n && from(half_edges_[leaving[end]]) == v;) ++end;
      if (end - begin == 1) {
        next_[leaving[begin]] = entering[begin];
      } else {
        match(
            v,
            {leaving.begin() + static_cast<std::ptrdiff_t>(begin), leaving.begin() + static_cast<std::ptrdiff_t>(end)},
            {entering.begin() + static_cast<std::ptrdiff_t>(begin),
             entering.begin() + static_cast<std::ptrdiff_t>(end)});
      }
    }
  }

  /// Pairs the fans that begin with those that end at v, least gap first.
  void match(std::int32_t v, const std::vector<std::size_t>& leaving, const std::vector<std::size_t>& entering) {
    Vector3d e, f;
    tangent_frame(normals_[at(v)].isZero(0) ? Vector3d::UnitZ() : normals_[at(v)], e, f);
    const auto direction = [&](std::int32_t q) {
      const Vector3d offset = positions_[at(q)] - positions_[at(v)];
      return std::atan2(offset.dot(f), offset.dot(e));
    };
    struct Gap {
      double angle;
      std::size_t leaving, entering;
    };
    std::vector<Gap> gaps;
    for (const std::size_t i : leaving) {
      const double begin = direction(to(half_edges_[i]));
      for (const std::size_t j : entering) {
        const double angle = begin - direction(from(half_edges_[j]));
        gaps.push_back({angle >= 0 ? angle : angle + 2 * std::numbers::pi, i, j});
      }
    }
    std::stable_sort(gaps.begin(), gaps.end(), [](const Gap& a, const Gap& b) { return a.angle < b.angle; });
    std::vector<std::size_t> used_leaving, used_entering;
    const auto contains = [](const std::vector<std::size_t>& list, std::size_t i) {
      return std::find(list.begin(), list.end(), i) != list.end();
    };
    for (const Gap& gap : gaps) {
      if (contains(used_leaving, gap.leaving) || contains(used_entering, gap.entering)) continue;
      next_[gap.leaving] = gap.entering;
      used_leaving.push_back(gap.leaving);
      used_entering.push_back(gap.entering);
    }
  }

  const std::vector<Triangle>& triangles_;
  const std::vector<Vector3d>& positions_;
  const std::vector<Vector3d>& normals_;
  std::vector<std::int32_t> half_edges_;  ///< ascending
  std::vector<std::size_t> next_;         ///< around the gap, as places in half_edges_
};

/// The edges of the mesh at the points of the loops, in either direction.
class Edges {
 public:
  Edges(const std::vector<Triangle>& triangles, const std::vector<std::vector<std::int32_t>>& loops,
        std::size_t num_points)
      : list_of_point_(num_points, -1) {
    for (const auto& loop : loops)
      for (const std::int32_t p : loop)
        if (list_of_point_[at(p)] < 0) {
          list_of_point_[at(p)] = static_cast<std::int32_t>(lists_.size());
          lists_.emplace_back();
        }
    for (const Triangle& t : triangles) add(t);
  }
  void add(const Triangle& t) {
    for (std::size_t k = 0; k < 3; ++k) {
      add(t[k], t[(k + 1) % 3]);
      add(t[(k + 1) % 3], t[k]);
    }
  }
  bool contains(std::int32_t p, std::int32_t q) const {
    const auto& list = lists_[at(list_of_point_[at(p)])];
    return std::find(list.begin(), list.end(), q) != list.end();
  }

 private:
  void add(std::int32_t p, std::int32_t q) {
    if (list_of_point_[at(p)] < 0) return;
    auto& list = lists_[at(list_of_point_[at(p)])];
    if (std::find(list.begin(), list.end(), q) == list.end()) list.push_back(q);
  }

  std::vector<std::int32_t> list_of_point_;
  std::vector<std::vector<std::int32_t>> lists_;
};

/// The triangulation of one polygon.
class Filler {
 public:
  Filler(const std::vector<Vector3d>& positions, const std::vector<Vector3d>& normals,
         const std::vector<Vector3d>* other_positions, double max_edge, const Edges& edges)
      : positions_(positions),
        normals_(normals),
        other_(other_positions),
        squared_max_edge_(max_edge * max_edge),
        edges_(edges) {}

  /// The triangles of least weight in `loop`, none against its corners' normals; if there are no such, the triangles of
  /// least weight, provided that the loop as a whole runs with its points' normals. Empty where none are valid.
  std::vector<Triangle> fill(const std::vector<std::int32_t>& loop) {
    std::vector<Triangle> triangles = fill(loop, true);
    if (triangles.empty() && runs_with_normals(loop)) triangles = fill(loop, false);
    return triangles;
  }

 private:
  std::vector<Triangle> fill(const std::vector<std::int32_t>& loop, bool along_normals) {
    const std::size_t n = loop.size();
    constexpr double kInvalid = std::numeric_limits<double>::infinity();
    weight_.assign(n * n, kInvalid);
    split_.assign(n * n, 0);
    for (std::size_t i = 0; i + 1 < n; ++i) weight_[i * n + i + 1] = 0;
    for (std::size_t span = 2; span < n; ++span) {
      for (std::size_t i = 0; i + span < n; ++i) {
        const std::size_t j = i + span;
        const bool is_side = span + 1 == n;  // the polygon's last side
        if (!is_side && !may_join(loop[i], loop[j])) continue;
        const double length = is_side ? 0 : (positions_[at(loop[i])] - positions_[at(loop[j])]).norm();
        for (std::size_t k = i + 1; k < j; ++k) {
          const double weight = weight_[i * n + k] + weight_[k * n + j] + length;
          if (weight < weight_[i * n + j] && may_fill(loop[i], loop[k], loop[j], along_normals)) {
            weight_[i * n + j] = weight;
            split_[i * n + j] = k;
          }
        }
      }
    }
    std::vector<Triangle> triangles;
    if (weight_[n - 1] == kInvalid) return triangles;
    std::vector<std::pair<std::size_t, std::size_t>> open{{0, n - 1}};
    while (!open.empty()) {
      const auto [i, j] = open.back();
      open.pop_back();
      if (j - i < 2) continue;
      const std::size_t k = split_[i * n + j];
      triangles.push_back({loop[i], loop[k], loop[j]});
      open.push_back({i, k});
      open.push_back({k, j});
    }
    if (repeats_an_edge(triangles)) triangles.clear();
    return triangles;
  }

  bool runs_with_normals(const std::vector<std::int32_t>& loop) const {
    Vector3d area = Vector3d::Zero(), normal = Vector3d::Zero();
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const std::int32_t next = loop[i + 1 == loop.size() ? 0 : i + 1];
      area += (positions_[at(loop[i])] - positions_[at(loop[0])]).cross(positions_[at(next)] - positions_[at(loop[0])]);
      normal += normals_[at(loop[i])];
    }
    return area.dot(normal) > 0;
  }
  bool may_join(std::int32_t a, std::int32_t b) const {
    if (a == b || edges_.contains(a, b)) return false;
    if ((positions_[at(a)] - positions_[at(b)]).squaredNorm() > squared_max_edge_) return false;
    return other_ == nullptr || (((*other_)[at(a)] - (*other_)[at(b)]).squaredNorm() <= squared_max_edge_);
  }
  bool may_fill(std::int32_t a, std::int32_t b, std::int32_t c, bool along_normals) const {
    if (a == b || b == c || c == a) return false;
    if (!along_normals) return true;
    const Vector3d normal = (positions_[at(b)] - positions_[at(a)]).cross(positions_[at(c)] - positions_[at(a)]);
    return normal.dot(normals_[at(a)] + normals_[at(b)] + normals_[at(c)]) > 0;
  }
  /// A loop that passes a point twice may ask for one diagonal twice.
  static bool repeats_an_edge(const std::vector<Triangle>& triangles) {
    std::vector<std::pair<std::int32_t, std::int32_t>> half_edges;
    for (const Triangle& t : triangles)
      for (std::size_t k = 0; k < 3; ++k) half_edges.emplace_back(t[k], t[(k + 1) % 3]);
    std::sort(half_edges.begin(), half_edges.end());
    return std::adjacent_find(half_edges.begin(), half_edges.end()) != half_edges.end();
  }

  const std::vector<Vector3d>& positions_;
  const std::vector<Vector3d>& normals_;
  const std::vector<Vector3d>* other_;
  double squared_max_edge_;
  const Edges& edges_;
  std::vector<double> weight_;
  std::vector<std::size_t> split_;
};

}  // namespace

LoopCounts close_loops(std::vector<Triangle>& triangles, const std::vector<Vector3d>& positions,
                       const std::vector<Vector3d>& normals, const std::vector<Vector3d>* other_positions,
                       double max_edge, int max_loop_edges, const Execution& execution) {
  LoopCounts counts;
  execution.report("close short loops", 0, 0);
  const std::vector<std::vector<std::int32_t>> loops = Rim(triangles, positions, normals).short_loops(max_loop_edges);
  const std::size_t num_before = triangles.size();
  Edges edges(triangles, loops, positions.size());
  Filler filler(positions, normals, other_positions, max_edge, edges);
  for (std::size_t l = 0; l < loops.size(); ++l) {
    if (l % 1024 == 0)
      execution.report("close short loops", static_cast<std::int64_t>(l), static_cast<std::int64_t>(loops.size()));
    const std::vector<Triangle> fill = filler.fill(loops[l]);
    ++(fill.empty() ? counts.left_open : counts.closed);
    counts.triangles += static_cast<std::int64_t>(fill.size());
    for (const Triangle& t : fill) edges.add(t);
    triangles.insert(triangles.end(), fill.begin(), fill.end());
  }
  sort_added_triangles(triangles, num_before);
  return counts;
}

}  // namespace meshmser
