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

  /// Appends the loops of one region to `loops`. `border`: its border half-edges, ascending; where one of a rim is left
  /// out, the whole rim is. `inside(triangle)`: whether a triangle is in the region. The next half-edge is found by
  /// rotating inside the region about the end vertex.
  template <class Inside>
  void trace(std::span<const std::int32_t> border, std::int32_t owner, Inside&& inside,
             std::span<const std::int32_t> number_behind, BorderLoops& loops) {
    for (const std::int32_t half_edge : border) word(half_edge) |= bit(half_edge);
    found_.clear();
    edges_.clear();
    for (const std::int32_t first : border) {
      if ((word(first) & bit(first)) == 0) continue;
      const std::size_t begin = edges_.size();
      bool has_level_edge = false;
      std::int32_t half_edge = first;
      do {
        word(half_edge) &= ~bit(half_edge);
        edges_.push_back(half_edge);
        has_level_edge |= surface_.twins[static_cast<std::size_t>(half_edge)] >= 0;
        half_edge = next_half_edge(half_edge);
        while (true) {
          const std::int32_t twin = surface_.twins[static_cast<std::size_t>(half_edge)];
          if (twin < 0 || !inside(triangle_of_half_edge(twin))) break;
          half_edge = next_half_edge(twin);
        }
      } while (half_edge != first);
      if (has_level_edge) {
        found_.push_back(measured(begin));
      } else {
        ++loops.num_hole_loops_dropped;
        edges_.resize(begin);
      }
    }
    std::sort(found_.begin(), found_.end(), [&](const Loop& a, const Loop& b) {
      const double length_a = a.level_length + a.hole_length, length_b = b.level_length + b.hole_length;
      return length_a != length_b ? length_a > length_b : edges_[a.begin] < edges_[b.begin];
    });
    for (const Loop& loop : found_) {
      loops.owner_of_loop.push_back(owner);
      loops.level_length_of_loop.push_back(loop.level_length);
      loops.hole_length_of_loop.push_back(loop.hole_length);
      for (std::size_t i = loop.begin; i < loop.end; ++i) {
        const std::int32_t twin = surface_.twins[static_cast<std::size_t>(edges_[i])];
        loops.half_edges.push_back(edges_[i]);
        loops.kinds.push_back(twin < 0 ? EdgeKind::kHole : EdgeKind::kLevel);
        loops.neighbours.push_back(twin < 0 ? -1
                                            : number_behind[static_cast<std::size_t>(triangle_of_half_edge(twin))]);
      }
      loops.first_edge_of_loop.push_back(static_cast<std::int64_t>(loops.half_edges.size()));
    }
  }

 private:
  struct Loop {
    std::size_t begin, end;
    double level_length, hole_length;
  };

  std::uint64_t& word(std::int32_t half_edge) { return pending_[static_cast<std::size_t>(half_edge) / 64]; }
  static std::uint64_t bit(std::int32_t half_edge) {
    return std::uint64_t{1} << (static_cast<std::size_t>(half_edge) % 64);
  }

  /// Turns the loop that begins at `begin` to its smallest level half-edge, then adds its lengths up from there.
  Loop measured(std::size_t begin) {
    const auto first = edges_.begin() + static_cast<std::ptrdiff_t>(begin);
    auto smallest = edges_.end();
    for (auto i = first; i != edges_.end(); ++i)
      if (surface_.twins[static_cast<std::size_t>(*i)] >= 0 && (smallest == edges_.end() || *i < *smallest))
        smallest = i;
    std::rotate(first, smallest, edges_.end());
    Loop loop{begin, edges_.size(), 0, 0};
    for (std::size_t i = begin; i < edges_.size(); ++i) {
      const std::int32_t half_edge = edges_[i];
      const auto& c = surface_.triangles[static_cast<std::size_t>(half_edge) / 3];
      const Eigen::Vector3d& from =
          surface_.positions[static_cast<std::size_t>(c[static_cast<std::size_t>(half_edge % 3)])];
      const Eigen::Vector3d& to =
          surface_.positions[static_cast<std::size_t>(c[static_cast<std::size_t>((half_edge + 1) % 3)])];
      const double length = (to - from).norm();
      (surface_.twins[static_cast<std::size_t>(half_edge)] < 0 ? loop.hole_length : loop.level_length) += length;
    }
    return loop;
  }

  SurfaceView surface_;
  std::vector<std::uint64_t> pending_;  ///< a bit a half-edge; all clear between regions
  std::vector<std::int32_t> edges_;
  std::vector<Loop> found_;
};

}  // namespace meshmser
