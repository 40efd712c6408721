#pragma once
/// Border half-edges of one region linked into closed loops. Internal to the borders stage.

#include <algorithm>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "stages/borders/borders.hpp"
#include "stages/common/adjacency.hpp"

namespace meshmser {

class LoopTracer {
 public:
  explicit LoopTracer(const SurfaceView& surface) : surface_(surface) {}

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
    find_next(half_edges, inside, number_behind);
    found_.clear();
    std::int64_t num_dropped = 0;
    walk_.clear();
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      if (edges_[i].walked) continue;
      // The first in order is the smallest level half-edge; edges are ascending.
      Loop loop{walk_.size(), walk_.size(), walk_.size(), 0, 0};
      std::int32_t least_level = -1;
      for (auto at = static_cast<std::int32_t>(i); !edge(at).walked; at = edge(at).next) {
        edge(at).walked = true;
        if (edge(at).twin >= 0 && (least_level < 0 || at < least_level)) {
          least_level = at;
          loop.first = walk_.size();
        }
        walk_.push_back(at);
      }
      if (least_level < 0) {
        ++num_dropped;
        walk_.resize(loop.begin);
        continue;
      }
      loop.end = walk_.size();
      // Added up from the loop's first half-edge on, so that lengths do not depend on where the walk began.
      for_each_edge(loop, [&](const Edge& e) { (e.twin < 0 ? loop.hole_length : loop.level_length) += e.length; });
      found_.push_back(loop);
    }
    if (found_.size() > 1)
      std::sort(found_.begin(), found_.end(), [&](const Loop& a, const Loop& b) {
        const double length_a = a.level_length + a.hole_length, length_b = b.level_length + b.hole_length;
        return length_a != length_b ? length_a > length_b : walk_[a.first] < walk_[b.first];
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
    double length;
    std::int32_t half_edge, twin;
    std::int32_t start;  ///< vertex
    std::int32_t next;   ///< index of the edge that follows
    bool shares_start;   ///< with a later edge
    bool walked;
  };
  /// walk_[begin] .. walk_[end]; the first in order is `first`, the smallest level half-edge.
  struct Loop {
    std::size_t begin, end, first;
    double level_length, hole_length;
  };
  static constexpr std::size_t kAhead = 16;

  /// The edges, each with the one that follows: the one that starts where it ends. Only where several start there, the
  /// region pinches and one has to rotate. Here no edge waits for the one before, as a walk along a loop would, so that
  /// the processor looks at several places of the mesh at a time.
  template <class Inside>
  void find_next(std::span<const std::int32_t> half_edges, Inside&& inside,
                 std::span<const std::int32_t> number_behind) {
    const std::size_t n = half_edges.size();
    edges_.resize(n);
    clear_places(n);
    const std::int32_t *twins = surface_.twins.data(), *corners = surface_.triangles.front().data();
    const Eigen::Vector3d* positions = surface_.positions.data();
    for (std::size_t i = 0; i < n; ++i) {
      if (i + kAhead < n) {
        __builtin_prefetch(&twins[half_edges[i + kAhead]]);
        __builtin_prefetch(&corners[half_edges[i + kAhead]]);
      }
      const std::int32_t half_edge = half_edges[i], twin = twins[half_edge], start = corners[half_edge];
      edges_[i] = {0, half_edge, twin, start, corners[next_half_edge(half_edge)], false, false};
      __builtin_prefetch(&positions[start]);
      if (twin >= 0) __builtin_prefetch(&number_behind[static_cast<std::size_t>(triangle_of_half_edge(twin))]);
      put_place(start, static_cast<std::int32_t>(i));
    }
    for (Edge& e : edges_) {
      e.next = place_of(e.next);
      if (edge(e.next).shares_start) e.next = rotate(e.half_edge, inside);
      e.length = (positions[edge(e.next).start] - positions[e.start]).norm();
    }
  }

  /// The index of the edge that follows a half-edge, found by rotating inside the region about its end.
  template <class Inside>
  std::int32_t rotate(std::int32_t half_edge, Inside&& inside) const {
    std::int32_t after = next_half_edge(half_edge);
    for (std::int32_t twin = twin_of(after); twin >= 0 && inside(triangle_of_half_edge(twin)); twin = twin_of(after))
      after = next_half_edge(twin);
    const auto place = std::lower_bound(edges_.begin(), edges_.end(), after,
                                        [](const Edge& e, std::int32_t than) { return e.half_edge < than; });
    return static_cast<std::int32_t>(place - edges_.begin());
  }
  std::int32_t twin_of(std::int32_t half_edge) const { return surface_.twins[static_cast<std::size_t>(half_edge)]; }

  Edge& edge(std::int32_t i) { return edges_[static_cast<std::size_t>(i)]; }

  template <class Body>
  void for_each_edge(const Loop& loop, Body&& body) const {
    const auto edge_at = [&](std::size_t i) { return edges_[static_cast<std::size_t>(walk_[i])]; };
    for (std::size_t i = loop.first; i < loop.end; ++i) body(edge_at(i));
    for (std::size_t i = loop.begin; i < loop.first; ++i) body(edge_at(i));
  }

  // The first edge that starts at a vertex, by open addressing: at most half of the slots are taken.
  void clear_places(std::size_t num_edges) {
    const int bits = std::bit_width(num_edges) + 1;
    slots_.assign(std::size_t{1} << bits, -1);
    shift_ = 32 - bits;
  }
  /// The slot of a vertex, or the free one where it belongs.
  std::size_t slot_of(std::int32_t vertex) const {
    std::size_t slot = static_cast<std::uint32_t>(vertex) * 0x9E3779B1U >> shift_;
    while (slots_[slot] >= 0 && edges_[static_cast<std::size_t>(slots_[slot])].start != vertex)
      slot = (slot + 1) % slots_.size();
    return slot;
  }
  void put_place(std::int32_t vertex, std::int32_t index) {
    std::int32_t& place = slots_[slot_of(vertex)];
    if (place >= 0)
      edge(place).shares_start = true;
    else
      place = index;
  }
  std::int32_t place_of(std::int32_t vertex) const { return slots_[slot_of(vertex)]; }

  SurfaceView surface_;
  std::vector<Edge> edges_;          ///< of the region, by half-edge
  std::vector<std::int32_t> slots_;  ///< a power of two, indices or -1
  int shift_ = 0;
  std::vector<std::int32_t> walk_;  ///< indices, loop by loop
  std::vector<Loop> found_;
};

}  // namespace meshmser
