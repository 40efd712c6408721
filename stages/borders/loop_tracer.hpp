#pragma once
/// Border half-edges of one region linked into closed loops. Internal to the borders stage.

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "stages/borders/borders.hpp"
#include "stages/common/adjacency.hpp"

namespace meshmser {

class LoopTracer {
 public:
  explicit LoopTracer(const SurfaceView& surface) : surface_(surface), pending_(surface.twins.size() / 64 + 1, 0) {}

  /// What is told of a loop beside its edges.
  struct Traced {
    std::int64_t num_edges;
    double level_length, hole_length;
  };

  /// Appends the loops of one region to `loops` and writes their edges, loop by loop, from the beginning of the three
  /// lists on. `half_edges` holds the region's border half-edges before, ascending; where one of a rim is left out, the
  /// whole rim is. `inside(triangle)`: whether a triangle is in the region. The next half-edge is found by rotating
  /// inside the region about the end vertex. Returns the number of loops of hole edges alone, which are dropped.
  template <class Inside>
  std::int64_t trace(std::span<std::int32_t> half_edges, std::span<EdgeKind> kinds, std::span<std::int32_t> neighbours,
                     Inside&& inside, std::span<const std::int32_t> number_behind, std::vector<Traced>& loops) {
    // The walk along a loop waits for every place on its way; here, where none waits for another, they come sooner.
    for (const std::int32_t half_edge : half_edges) {
      word(half_edge) |= bit(half_edge);
      __builtin_prefetch(&start_of(half_edge));
      __builtin_prefetch(&surface_.twins[static_cast<std::size_t>(half_edge)]);
    }
    found_.clear();
    edges_.clear();
    std::int64_t num_dropped = 0;
    for (const std::int32_t first : half_edges) {
      if ((word(first) & bit(first)) == 0) continue;
      Loop loop{edges_.size(), edges_.size(), edges_.size(), 0, 0};
      std::int32_t half_edge = first;
      std::int32_t twin = twin_of(half_edge);
      const Eigen::Vector3d* from = &start_of(half_edge);
      bool has_level_edge = false;
      do {
        word(half_edge) &= ~bit(half_edge);
        const std::int32_t after = next_half_edge(half_edge);
        const Eigen::Vector3d* to = &start_of(after);
        if (twin >= 0 && (!has_level_edge || half_edge < edges_[loop.first].half_edge)) loop.first = edges_.size();
        has_level_edge |= twin >= 0;
        edges_.push_back({half_edge, twin, (*to - *from).norm()});
        from = to;
        half_edge = after;
        twin = twin_of(half_edge);
        while (twin >= 0 && inside(triangle_of_half_edge(twin))) {
          half_edge = next_half_edge(twin);
          twin = twin_of(half_edge);
        }
      } while (half_edge != first);
      if (!has_level_edge) {
        ++num_dropped;
        edges_.resize(loop.begin);
        continue;
      }
      loop.end = edges_.size();
      // Added up from the loop's first half-edge on, so that lengths do not depend on where the walk began.
      for_each_edge(loop, [&](const Edge& e) { (e.twin < 0 ? loop.hole_length : loop.level_length) += e.length; });
      found_.push_back(loop);
    }
    if (found_.size() > 1)
      std::sort(found_.begin(), found_.end(), [&](const Loop& a, const Loop& b) {
        const double length_a = a.level_length + a.hole_length, length_b = b.level_length + b.hole_length;
        return length_a != length_b ? length_a > length_b : edges_[a.first].half_edge < edges_[b.first].half_edge;
      });
    std::size_t place = 0;
    for (const Loop& loop : found_) {
      loops.push_back({static_cast<std::int64_t>(loop.end - loop.begin), loop.level_length, loop.hole_length});
      for_each_edge(loop, [&](const Edge& e) {
        half_edges[place] = e.half_edge;
        kinds[place] = e.twin < 0 ? EdgeKind::kHole : EdgeKind::kLevel;
        neighbours[place] = e.twin < 0 ? -1 : number_behind[static_cast<std::size_t>(triangle_of_half_edge(e.twin))];
        ++place;
      });
    }
    return num_dropped;
  }

 private:
  struct Edge {
    std::int32_t half_edge, twin;
    double length;
  };
  /// Edges begin .. end of edges_; the first in order is `first`, the smallest level half-edge.
  struct Loop {
    std::size_t begin, end, first;
    double level_length, hole_length;
  };

  template <class Body>
  void for_each_edge(const Loop& loop, Body&& body) const {
    for (std::size_t i = loop.first; i < loop.end; ++i) body(edges_[i]);
    for (std::size_t i = loop.begin; i < loop.first; ++i) body(edges_[i]);
  }

  std::int32_t twin_of(std::int32_t half_edge) const { return surface_.twins[static_cast<std::size_t>(half_edge)]; }
  const Eigen::Vector3d& start_of(std::int32_t half_edge) const {
    const std::int32_t* corners = surface_.triangles.front().data();
    return surface_.positions[static_cast<std::size_t>(corners[half_edge])];
  }
  std::uint64_t& word(std::int32_t half_edge) { return pending_[static_cast<std::size_t>(half_edge) / 64]; }
  static std::uint64_t bit(std::int32_t half_edge) {
    return std::uint64_t{1} << (static_cast<std::size_t>(half_edge) % 64);
  }

  SurfaceView surface_;
  std::vector<std::uint64_t> pending_;  ///< a bit a half-edge; all clear between regions
  std::vector<Edge> edges_;
  std::vector<Loop> found_;
};

}  // namespace meshmser
