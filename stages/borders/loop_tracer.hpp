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

  /// Fetches what tracing these half-edges will look at first.
  void prefetch(std::span<const std::int32_t> half_edges) const {
    for (const std::int32_t h : half_edges.first(std::min(half_edges.size(), kAhead))) {
      __builtin_prefetch(&surface_.twins[static_cast<std::size_t>(h)]);
      __builtin_prefetch(surface_.triangles.front().data() + h);
    }
  }

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
    walked_.resize(std::max(walked_.size(), edges_.size()));
    Walked* end = walked_.data();
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      if (edges_[i].walked) continue;
      // Edges are ascending, so a level edge that comes first is the smallest of its loop.
      auto first = static_cast<std::int32_t>(i);
      if (edges_[i].twin < 0) first = smallest_level_edge(first);
      if (first < 0) {
        ++num_dropped;
        for (first = static_cast<std::int32_t>(i); !edge(first).walked; first = edge(first).next)
          edge(first).walked = true;
        continue;
      }
      Loop loop{end, end, first, 0, 0};
      for (std::int32_t at = first; !edge(at).walked; at = edge(at).next) {
        Edge& e = edge(at);
        e.walked = true;
        if (e.twin < 0) {
          *end++ = {e.half_edge, -1, EdgeKind::kHole};
          loop.hole_length += e.length;
        } else {
          *end++ = {e.half_edge, number_behind[static_cast<std::size_t>(triangle_of_half_edge(e.twin))],
                    EdgeKind::kLevel};
          loop.level_length += e.length;
        }
      }
      loop.end = end;
      found_.push_back(loop);
    }
    if (found_.size() > 1)
      std::sort(found_.begin(), found_.end(), [&](const Loop& a, const Loop& b) {
        const double length_a = a.level_length + a.hole_length, length_b = b.level_length + b.hole_length;
        return length_a != length_b ? length_a > length_b : a.first < b.first;
      });
    std::size_t place = 0;
    for (const Loop& loop : found_) {
      loops.push_back({loop.end - loop.begin, loop.level_length, loop.hole_length});
      for (const Walked* at = loop.begin; at != loop.end; ++at, ++place) {
        half_edges[place] = at->half_edge;
        kinds[place] = at->kind;
        neighbours[place] = at->neighbour;
      }
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
  /// What is put out of an edge.
  struct Walked {
    std::int32_t half_edge, neighbour;
    EdgeKind kind;
  };
  struct Loop {
    const Walked *begin, *end;
    std::int32_t first;  ///< index of the smallest level half-edge, where it begins
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

  /// Of the loop of an edge; -1: none.
  std::int32_t smallest_level_edge(std::int32_t of) const {
    std::int32_t least = -1, at = of;
    do {
      const Edge& e = edges_[static_cast<std::size_t>(at)];
      if (e.twin >= 0 && (least < 0 || at < least)) least = at;
      at = e.next;
    } while (at != of);
    return least;
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
  std::vector<Walked> walked_;  ///< loop by loop
  std::vector<Loop> found_;
};

}  // namespace meshmser
