#include "stages/common/adjacency.hpp"

#include <algorithm>
#include <atomic>
#include <limits>
#include <string>
#include <utility>

#include "stages/common/large_pages.hpp"
#include "stages/common/parallel.hpp"

namespace meshmser {
namespace {

using Triangles = std::span<const std::array<std::int32_t, 3>>;

constexpr std::int32_t kNone = -1;
// Measured: far enough for memory to answer, near enough to still be in the first-level cache.
constexpr std::size_t kPrefetchTriangles = 12;

void check_corners(Triangles triangles, std::size_t num_vertices, const Execution& execution) {
  if (triangles.size() > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()) / 3)
    throw StageError("a mesh of " + std::to_string(triangles.size()) +
                     " triangles is too large: half-edge ids end at 715827882 triangles; split the mesh");
  parallel_chunks(
      static_cast<std::int64_t>(triangles.size()), 1 << 16, "", execution, [&](std::int64_t begin, std::int64_t end) {
        // One flag a chunk keeps the loop free of branches; the culprit is looked for only if there is one.
        bool bad = false;
        const auto limit = static_cast<std::uint32_t>(num_vertices);
        for (std::int64_t t = begin; t < end; ++t) {
          const auto& c = triangles[static_cast<std::size_t>(t)];
          bad |= static_cast<std::uint32_t>(c[0]) >= limit || static_cast<std::uint32_t>(c[1]) >= limit ||
                 static_cast<std::uint32_t>(c[2]) >= limit || c[0] == c[1] || c[1] == c[2] || c[2] == c[0];
        }
        if (!bad) return;
        for (std::int64_t t = begin; t < end; ++t) {
          const auto& c = triangles[static_cast<std::size_t>(t)];
          for (int k = 0; k < 3; ++k)
            if (static_cast<std::uint32_t>(c[k]) >= limit)
              throw StageError("triangle " + std::to_string(t) + " names vertex " + std::to_string(c[k]) +
                               ", but there are " + std::to_string(num_vertices) + " vertices, from 0");
          if (c[0] == c[1] || c[1] == c[2] || c[2] == c[0])
            throw StageError("triangle " + std::to_string(t) + " names one vertex twice (" + std::to_string(c[0]) +
                             ", " + std::to_string(c[1]) + ", " + std::to_string(c[2]) + "); remove it from the mesh");
        }
      });
}

[[noreturn]] void throw_repeated(std::int32_t from, std::int32_t to, std::int32_t first, std::int32_t second) {
  throw StageError("the edge from vertex " + std::to_string(from) + " to " + std::to_string(to) +
                   " runs in the same direction in triangles " + std::to_string(std::min(first, second)) + " and " +
                   std::to_string(std::max(first, second)) +
                   ": the mesh is not an oriented manifold; repair it first (load.repair: split or drop)");
}

/// Half-edges that wait for their twin hang in a list at their smaller vertex, linked through the result itself: a
/// waiting entry holds -2 - (the next waiting one), or -1 at the end. Fast where neighbouring triangles have near ids,
/// since then the lists are short and in cache. Takes the edges whose smaller vertex is in [first_vertex, last_vertex).
/// Gives up and returns false where the lists turn out long (a hub of many triangles in shuffled order).
bool pair_through_lists(Triangles triangles, std::int32_t first_vertex, std::int32_t last_vertex,
                        std::span<std::int32_t> head_of_vertex, std::span<std::int32_t> twins,
                        const Execution& execution) {
  const std::size_t n = triangles.size();
  const std::int32_t* corners = n == 0 ? nullptr : triangles[0].data();
  std::int64_t steps_left = 64 * static_cast<std::int64_t>(n) + 4096;
  for (std::size_t t = 0; t < n; ++t) {
    if (t % (1 << 16) == 0) execution.check();
    if (steps_left < 0) return false;
    if (t + kPrefetchTriangles < n) {
      const auto& ahead = triangles[t + kPrefetchTriangles];
      __builtin_prefetch(&head_of_vertex[static_cast<std::size_t>(std::min(ahead[0], ahead[1]))], 1);
      __builtin_prefetch(&head_of_vertex[static_cast<std::size_t>(std::min(ahead[1], ahead[2]))], 1);
    }
    const auto& c = triangles[t];
    for (int k = 0; k < 3; ++k) {
      const std::int32_t from = c[static_cast<std::size_t>(k)], to = c[static_cast<std::size_t>(k == 2 ? 0 : k + 1)];
      const std::int32_t smaller = std::min(from, to);
      if (smaller < first_vertex || smaller >= last_vertex) continue;
      const auto half_edge = static_cast<std::int32_t>(3 * t) + k;
      std::int32_t& head = head_of_vertex[static_cast<std::size_t>(smaller)];
      std::int32_t before = kNone, waiting = head;
      while (waiting != kNone) {
        const std::int32_t waiting_from = corners[waiting], waiting_to = corners[next_half_edge(waiting)];
        if (waiting_from == to && waiting_to == from) break;
        if (waiting_from == from && waiting_to == to) throw_repeated(from, to, waiting / 3, half_edge / 3);
        before = waiting;
        --steps_left;
        const std::int32_t link = twins[static_cast<std::size_t>(waiting)];
        waiting = link == kNone ? kNone : -2 - link;
      }
      if (waiting == kNone) {
        twins[static_cast<std::size_t>(half_edge)] = head == kNone ? kNone : -2 - head;
        head = half_edge;
        continue;
      }
      const std::int32_t link = twins[static_cast<std::size_t>(waiting)];
      if (before == kNone)
        head = link == kNone ? kNone : -2 - link;
      else
        twins[static_cast<std::size_t>(before)] = link;
      twins[static_cast<std::size_t>(waiting)] = half_edge;
      twins[static_cast<std::size_t>(half_edge)] = waiting;
    }
  }
  return true;
}

struct BucketEntry {
  std::int32_t greater_vertex;
  std::int32_t half_edge;
};

/// Half-edges sorted by their smaller vertex (counting sort), then compared within each bucket: for ids without order.
void pair_in_buckets(Triangles triangles, std::int32_t first_vertex, std::int32_t last_vertex,
                     std::span<std::int32_t> twins, const Execution& execution) {
  const std::size_t n = triangles.size(), width = static_cast<std::size_t>(last_vertex - first_vertex);
  std::vector<std::int32_t> next_place(width + 1, 0);
  auto for_each = [&](auto&& body) {
    for (std::size_t t = 0; t < n; ++t) {
      if (t % (1 << 16) == 0) execution.check();
      if (t + kPrefetchTriangles < n) {
        const auto& ahead = triangles[t + kPrefetchTriangles];
        for (int k = 0; k < 3; ++k) {
          const auto smaller = static_cast<std::uint32_t>(
              std::min(ahead[static_cast<std::size_t>(k)], ahead[static_cast<std::size_t>((k + 1) % 3)]) -
              first_vertex);
          if (smaller < width) __builtin_prefetch(&next_place[smaller], 1);
        }
      }
      const auto& c = triangles[t];
      for (int k = 0; k < 3; ++k) {
        const std::int32_t from = c[static_cast<std::size_t>(k)], to = c[static_cast<std::size_t>(k == 2 ? 0 : k + 1)];
        const auto smaller = static_cast<std::uint32_t>(std::min(from, to) - first_vertex);
        if (smaller < width) body(smaller, std::max(from, to), static_cast<std::int32_t>(3 * t) + k);
      }
    }
  };
  for_each([&](std::size_t smaller, std::int32_t, std::int32_t) { ++next_place[smaller]; });
  std::int32_t sum = 0;
  for (std::int32_t& place : next_place) sum += std::exchange(place, sum);
  std::vector<BucketEntry> entries;
  reserve_on_large_pages(entries, static_cast<std::size_t>(sum));
  entries.resize(static_cast<std::size_t>(sum));
  for_each([&](std::size_t smaller, std::int32_t greater, std::int32_t half_edge) {
    entries[static_cast<std::size_t>(next_place[smaller]++)] = {greater, half_edge};
  });
  // next_place[v] is now the end of bucket v, that is the beginning of bucket v + 1.
  const std::int32_t* corners = n == 0 ? nullptr : triangles[0].data();
  std::size_t begin = 0;
  for (std::size_t v = 0; v < width; ++v) {
    const auto end = static_cast<std::size_t>(next_place[v]);
    if (end - begin > 64)  // a hub: equal ends side by side, so that the search below stays short
      std::sort(entries.begin() + static_cast<std::ptrdiff_t>(begin),
                entries.begin() + static_cast<std::ptrdiff_t>(end), [](const BucketEntry& a, const BucketEntry& b) {
                  return std::pair(a.greater_vertex, a.half_edge) < std::pair(b.greater_vertex, b.half_edge);
                });
    for (std::size_t i = begin; i < end; ++i) {
      if (entries[i].half_edge == kNone) continue;
      const std::int32_t greater = entries[i].greater_vertex, half_edge = entries[i].half_edge;
      std::size_t j = i + 1;
      const bool sorted = end - begin > 64;
      while (j < end && entries[j].greater_vertex != greater) {
        if (sorted) {
          j = end;
          break;
        }
        ++j;
      }
      if (j >= end || entries[j].greater_vertex != greater) continue;
      const std::int32_t other = entries[j].half_edge;
      if (corners[half_edge] == corners[other])
        throw_repeated(corners[half_edge], corners[next_half_edge(half_edge)], half_edge / 3, other / 3);
      twins[static_cast<std::size_t>(half_edge)] = other;
      twins[static_cast<std::size_t>(other)] = half_edge;
      entries[j].half_edge = kNone;
    }
    begin = end;
  }
}

/// Whether neighbouring triangles mostly have near ids: the median jump of the first corner over a fixed sample is
/// small.
bool has_local_ids(Triangles triangles) {
  if (triangles.size() < 4096) return true;
  const std::size_t stride = triangles.size() / 1024;
  std::size_t near = 0, seen = 0;
  for (std::size_t t = 1; t < triangles.size(); t += stride, ++seen)
    near += std::abs(static_cast<std::int64_t>(triangles[t][0]) - triangles[t - 1][0]) < 4096;
  return 2 * near > seen;
}

}  // namespace

std::vector<std::int32_t> twin_half_edges(Triangles triangles, std::size_t num_vertices, const Execution& execution) {
  check_corners(triangles, num_vertices, execution);
  std::vector<std::int32_t> twins;
  reserve_on_large_pages(twins, 3 * triangles.size());
  twins.assign(3 * triangles.size(), kNone);
  // Every edge belongs to its smaller vertex, so that ranges of vertices are independent of each other; each part reads
  // all triangles, which pays for few parts only.
  const std::int64_t parts = triangles.size() < (1 << 17) ? 1 : std::min(4, thread_count(execution));
  const auto vertices = static_cast<std::int64_t>(num_vertices);
  const std::int64_t grain = std::max<std::int64_t>(1, (vertices + parts - 1) / parts);
  std::atomic<bool> paired{false};
  if (has_local_ids(triangles)) {
    paired = true;
    std::vector<std::int32_t> head_of_vertex(num_vertices, kNone);
    parallel_chunks(vertices, grain, "", execution, [&](std::int64_t begin, std::int64_t end) {
      if (!pair_through_lists(triangles, static_cast<std::int32_t>(begin), static_cast<std::int32_t>(end),
                              head_of_vertex, twins, execution))
        paired = false;
    });
    // What still waits is a rim.
    for (std::int32_t waiting : head_of_vertex)
      while (waiting != kNone) {
        const std::int32_t link = std::exchange(twins[static_cast<std::size_t>(waiting)], kNone);
        waiting = link == kNone ? kNone : -2 - link;
      }
  }
  if (!paired) {
    std::fill(twins.begin(), twins.end(), kNone);
    parallel_chunks(vertices, grain, "", execution, [&](std::int64_t begin, std::int64_t end) {
      pair_in_buckets(triangles, static_cast<std::int32_t>(begin), static_cast<std::int32_t>(end), twins, execution);
    });
  }
  return twins;
}

std::vector<EdgeDefect> find_edge_defects(Triangles triangles, std::size_t num_vertices) {
  std::vector<std::int64_t> first_of_vertex(num_vertices + 1, 0);
  for (const auto& c : triangles)
    for (std::size_t k = 0; k < 3; ++k) ++first_of_vertex[static_cast<std::size_t>(std::min(c[k], c[(k + 1) % 3])) + 1];
  for (std::size_t v = 0; v < num_vertices; ++v) first_of_vertex[v + 1] += first_of_vertex[v];
  struct Entry {
    std::int32_t greater;
    bool backward;
  };
  std::vector<Entry> entries(3 * triangles.size());
  std::vector<std::int64_t> place(first_of_vertex.begin(), first_of_vertex.end() - 1);
  for (const auto& c : triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t from = c[k], to = c[(k + 1) % 3];
      entries[static_cast<std::size_t>(place[static_cast<std::size_t>(std::min(from, to))]++)] = {std::max(from, to),
                                                                                                  from > to};
    }
  std::vector<EdgeDefect> defects;
  for (std::size_t v = 0; v < num_vertices; ++v) {
    const auto begin = entries.begin() + first_of_vertex[v], end = entries.begin() + first_of_vertex[v + 1];
    std::sort(begin, end, [](const Entry& a, const Entry& b) { return a.greater < b.greater; });
    for (auto i = begin; i != end;) {
      EdgeDefect edge{static_cast<std::int32_t>(v), i->greater, 0, 0};
      for (; i != end && i->greater == edge.greater_vertex; ++i) ++(i->backward ? edge.num_backward : edge.num_forward);
      if (edge.num_forward > 1 || edge.num_backward > 1) defects.push_back(edge);
    }
  }
  return defects;
}

void cut_out_triangles(std::span<std::int32_t> twins, std::span<const std::uint8_t> excluded) {
  for (std::size_t t = 0; t < excluded.size(); ++t) {
    if (excluded[t] == 0) continue;
    for (std::size_t h = 3 * t; h < 3 * t + 3; ++h) {
      if (twins[h] >= 0) twins[static_cast<std::size_t>(twins[h])] = kNone;
      twins[h] = kNone;
    }
  }
}

}  // namespace meshmser
