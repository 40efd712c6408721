#include "stages/borders/borders.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <mutex>
#include <numeric>
#include <utility>

#include "stages/borders/loop_tracer.hpp"
#include "stages/common/adjacency.hpp"
#include "stages/common/gather_by_owner.hpp"
#include "stages/common/owned_edges.hpp"
#include "stages/common/parallel.hpp"

namespace meshmser {
namespace {

constexpr std::int32_t kNone = -1;
/// Small enough to share out, large enough to cost nothing.
constexpr std::int64_t kEdgesPerGroup = 1 << 15;
constexpr std::int64_t kTrianglesPerChunk = 1 << 16;
constexpr std::size_t kAlwaysTaken = 1 << 20;  ///< labels up to here, however few triangles there are

std::size_t at(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

/// For each hole half-edge, the least level around its rim: over the whole fans between one rim edge and the next, so
/// that a region whose lo is not above it holds all of them, and its loop there is the rim alone. 0 for other
/// half-edges.
struct RimLevels {
  std::vector<std::int32_t> half_edges;  ///< hole half-edges, ascending
  std::vector<std::int32_t> least;       ///< same length
  std::int64_t num_loops_dropped = 0;    ///< pairs of a region and a rim it holds whole
};

/// 0 for what is in no node.
std::int32_t level_of_triangle(const ComponentTree& tree, std::size_t t) {
  const std::int32_t node = tree.node_of_triangle[t];
  return node < 0 ? 0 : tree.hi_of_node[at(node)];
}

RimLevels walk_rims(const SurfaceView& surface, const ComponentTree& tree, const NodePlaces& places,
                    std::span<const std::int32_t> depth_of_place, const Execution& execution) {
  RimLevels rims;
  const std::size_t num_triangles = surface.triangles.size();
  std::vector<std::vector<std::int32_t>> of_chunk((num_triangles + kTrianglesPerChunk - 1) / kTrianglesPerChunk);
  parallel_chunks(static_cast<std::int64_t>(num_triangles), kTrianglesPerChunk, "", execution,
                  [&](std::int64_t begin, std::int64_t end) {
                    std::vector<std::int32_t>& own = of_chunk[static_cast<std::size_t>(begin / kTrianglesPerChunk)];
                    for (auto h = 3 * static_cast<std::size_t>(begin); h < 3 * static_cast<std::size_t>(end); ++h)
                      if (surface.twins[h] < 0 && level_of_triangle(tree, h / 3) > 0)
                        own.push_back(static_cast<std::int32_t>(h));
                  });
  for (const std::vector<std::int32_t>& own : of_chunk)
    rims.half_edges.insert(rims.half_edges.end(), own.begin(), own.end());
  rims.least.assign(rims.half_edges.size(), kNone);
  auto index_of = [&](std::int32_t half_edge) {
    return static_cast<std::size_t>(std::lower_bound(rims.half_edges.begin(), rims.half_edges.end(), half_edge) -
                                    rims.half_edges.begin());
  };
  std::vector<std::size_t> loop;
  for (std::size_t i = 0; i < rims.half_edges.size(); ++i) {
    if (rims.least[i] != kNone) continue;
    loop.clear();
    std::int32_t least = std::numeric_limits<std::int32_t>::max(), least_triangle = kNone;
    std::int32_t half_edge = rims.half_edges[i];
    do {
      // A rim may run past triangles below the least level; their own rim edges are not listed.
      const std::size_t place = index_of(half_edge);
      if (place < rims.half_edges.size() && rims.half_edges[place] == half_edge) loop.push_back(place);
      std::int32_t out = next_half_edge(half_edge);
      while (true) {
        const std::int32_t level = level_of_triangle(tree, at(triangle_of_half_edge(out)));
        if (level < least) {
          least = level;
          least_triangle = triangle_of_half_edge(out);
        }
        const std::int32_t twin = surface.twins[at(out)];
        if (twin < 0) break;
        out = next_half_edge(twin);
      }
      half_edge = out;
    } while (half_edge != rims.half_edges[i]);
    for (const std::size_t place : loop) rims.least[place] = least;
    if (least <= 0) continue;
    const std::uint32_t place = places.of_triangle[at(least_triangle)];
    if (place != kNoPlace) rims.num_loops_dropped += depth_of_place[place];
  }
  return rims;
}

/// The loops of owners from their border half-edges. Owners are traced in the order given, which is to go from place to
/// near place on the surface, in groups of about as many half-edges each; every owner's edges are written where its
/// border half-edges were, so that neither order nor threads matter.
template <class NumberOf, class InsideOf>
BorderLoops trace_all(const SurfaceView& surface, HalfEdgesByOwner edges, std::span<const std::int32_t> order,
                      NumberOf&& number_of, InsideOf&& inside_of, std::span<const std::int32_t> number_behind,
                      const Execution& execution) {
  const auto edges_of = [&](std::int32_t owner) {
    return edges.first_of_owner[at(owner) + 1] - edges.first_of_owner[at(owner)];
  };
  std::vector<std::size_t> first_of_group{0};
  std::int64_t size = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    size += edges_of(order[i]);
    if (size < kEdgesPerGroup && i + 1 < order.size()) continue;
    first_of_group.push_back(i + 1);
    size = 0;
  }
  const std::size_t num_groups = first_of_group.size() - 1;
  BorderLoops all;
  all.half_edges = std::move(edges.half_edges);
  all.kinds.resize(all.half_edges.size());
  all.neighbours.resize(all.half_edges.size());
  std::vector<std::vector<LoopTracer::Traced>> loops_of_group(num_groups);
  std::vector<std::int64_t> dropped_of_group(num_groups, 0);
  // Of every owner: its group, and where its loops begin and end there.
  struct Found {
    std::int32_t group = 0, begin = 0, end = 0;
  };
  std::vector<Found> found(order.size());
  // A tracer holds a bit a half-edge: as many are made as threads work at a time.
  std::mutex mutex;
  std::vector<std::unique_ptr<LoopTracer>> idle;
  parallel_chunks(static_cast<std::int64_t>(num_groups), 1, "borders", execution,
                  [&](std::int64_t begin, std::int64_t) {
                    const auto group = static_cast<std::size_t>(begin);
                    std::unique_ptr<LoopTracer> tracer;
                    {
                      const std::lock_guard lock(mutex);
                      if (!idle.empty()) {
                        tracer = std::move(idle.back());
                        idle.pop_back();
                      }
                    }
                    if (!tracer) tracer = std::make_unique<LoopTracer>(surface);
                    std::vector<LoopTracer::Traced>& loops = loops_of_group[group];
                    const auto edges_of_place = [&](std::size_t i) {
                      return std::span(all.half_edges)
                          .subspan(static_cast<std::size_t>(edges.first_of_owner[at(order[i])]),
                                   static_cast<std::size_t>(edges_of(order[i])));
                    };
                    for (std::size_t i = first_of_group[group]; i < first_of_group[group + 1]; ++i) {
                      const auto owner = at(order[i]);
                      // Most regions are small: the next one's mesh is fetched while this one is traced.
                      if (i + 2 < order.size()) __builtin_prefetch(edges_of_place(i + 2).data());
                      if (i + 1 < first_of_group[group + 1]) tracer->prefetch(edges_of_place(i + 1));
                      const auto first = static_cast<std::size_t>(edges.first_of_owner[owner]);
                      const auto count = static_cast<std::size_t>(edges_of(order[i]));
                      Found& of = found[owner];
                      of.group = static_cast<std::int32_t>(group);
                      of.begin = static_cast<std::int32_t>(loops.size());
                      dropped_of_group[group] +=
                          tracer->trace({all.half_edges.data() + first, count}, {all.kinds.data() + first, count},
                                        {all.neighbours.data() + first, count}, inside_of(owner), number_behind, loops);
                      of.end = static_cast<std::int32_t>(loops.size());
                    }
                    const std::lock_guard lock(mutex);
                    idle.push_back(std::move(tracer));
                  });
  idle.clear();
  all.first_edge_of_loop.push_back(0);
  std::int64_t end = 0;
  for (std::size_t owner = 0; owner < found.size(); ++owner) {
    const std::int64_t begin = end;
    for (std::int32_t l = found[owner].begin; l < found[owner].end; ++l) {
      const LoopTracer::Traced& loop = loops_of_group[at(found[owner].group)][at(l)];
      all.owner_of_loop.push_back(number_of(owner));
      all.level_length_of_loop.push_back(loop.level_length);
      all.hole_length_of_loop.push_back(loop.hole_length);
      all.first_edge_of_loop.push_back(end += loop.num_edges);
    }
    // Dropped loops leave a gap at the end of their owner's edges.
    const std::int64_t from = edges.first_of_owner[owner];
    const auto close_gap = [&](auto& items) {
      std::copy(items.begin() + from, items.begin() + from + (end - begin), items.begin() + begin);
    };
    if (from == begin) continue;
    close_gap(all.half_edges);
    close_gap(all.kinds);
    close_gap(all.neighbours);
  }
  all.half_edges.resize(static_cast<std::size_t>(end));
  all.kinds.resize(static_cast<std::size_t>(end));
  all.neighbours.resize(static_cast<std::size_t>(end));
  all.num_hole_loops_dropped = std::accumulate(dropped_of_group.begin(), dropped_of_group.end(), std::int64_t{0});
  return all;
}

}  // namespace

BorderLoops extract_borders(const SurfaceView& surface, const ComponentTree& tree,
                            std::span<const std::int32_t> number_of_node, std::span<const std::int32_t> number_behind,
                            const Execution& execution) {
  const std::size_t num_nodes = tree.num_nodes(), num_triangles = surface.triangles.size();
  if (number_of_node.size() != num_nodes || number_behind.size() != num_triangles ||
      tree.node_of_triangle.size() != num_triangles || surface.twins.size() != 3 * num_triangles)
    throw StageError("borders need one number a node and a triangle, and one twin a half-edge of the tree's own mesh");
  // Regions have places in the order of their nodes, where children come before parents, and are put out by number.
  std::vector<std::int32_t> node_of_place;
  for (std::size_t node = 0; node < num_nodes; ++node)
    if (number_of_node[node] > 0) node_of_place.push_back(static_cast<std::int32_t>(node));
  const std::size_t num_regions = node_of_place.size();
  const NodePlaces places = places_of_nodes(tree, node_of_place, execution);
  // How many regions hold what is in one, itself included.
  std::vector<std::int32_t> depth_of_place(num_regions, 1);
  for (std::size_t place = num_regions; place-- > 0;)
    if (places.outer[place] != kNoPlace) depth_of_place[place] += depth_of_place[places.outer[place]];
  const auto lo_of_place = [&](std::uint32_t place) { return tree.lo(node_of_place[place]); };
  const auto number_of_place = [&](std::int32_t place) { return number_of_node[at(node_of_place[at(place)])]; };
  std::vector<std::int32_t> place_of_region(num_regions), region_of_place(num_regions);
  std::iota(place_of_region.begin(), place_of_region.end(), 0);
  std::sort(place_of_region.begin(), place_of_region.end(),
            [&](std::int32_t a, std::int32_t b) { return number_of_place(a) < number_of_place(b); });
  for (std::size_t r = 0; r < num_regions; ++r) region_of_place[at(place_of_region[r])] = static_cast<std::int32_t>(r);

  const RimLevels rims = walk_rims(surface, tree, places, depth_of_place, execution);
  const auto emit = [&](std::size_t begin, std::size_t end, std::vector<OwnedHalfEdge>& list) {
    const std::int32_t* twins = surface.twins.data();
    const std::uint32_t* place_of = places.of_triangle.get();
    OwnedEdges found(list, places);
    auto rim = static_cast<std::size_t>(
        std::lower_bound(rims.half_edges.begin(), rims.half_edges.end(), static_cast<std::int64_t>(3 * begin)) -
        rims.half_edges.begin());
    for (std::size_t t = begin; t < end; ++t) {
      const std::uint32_t here = place_of[t];
      std::array<std::uint32_t, 3> there{};
      bool at_rim = false;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::int32_t twin = twins[3 * t + k];
        at_rim |= twin < 0;
        there[k] = place_of[twin < 0 ? t : static_cast<std::uint32_t>(twin) / 3];
      }
      // Behind a hole edge begin the regions that hold the whole rim.
      if (at_rim && level_of_triangle(tree, t) > 0)
        for (std::size_t k = 0; k < 3; ++k) {
          if (twins[3 * t + k] >= 0) continue;
          const std::int32_t least = rims.least[rim++];
          while (there[k] != kNoPlace && lo_of_place(there[k]) > least) there[k] = places.outer[there[k]];
        }
      found.put(t, here, there, [&](std::uint32_t place) { return region_of_place[place]; });
    }
    found.finish();
  };
  // Traced by place: what a region holds just before it, and what lies beside it soon after.
  BorderLoops loops = trace_all(
      surface, gather_by_owner(num_triangles, num_regions, emit, execution), region_of_place,
      [&](std::size_t r) { return number_of_place(place_of_region[r]); },
      [&](std::size_t r) {
        return [&tree, lo = lo_of_place(static_cast<std::uint32_t>(place_of_region[r]))](std::int32_t triangle) {
          return level_of_triangle(tree, at(triangle)) >= lo;
        };
      },
      number_behind, execution);
  loops.num_hole_loops_dropped += rims.num_loops_dropped;
  return loops;
}

BorderLoops extract_label_borders(const SurfaceView& surface, std::span<const std::int32_t> label_of_triangle,
                                  const Execution& execution) {
  const std::size_t num_triangles = surface.triangles.size();
  if (label_of_triangle.size() != num_triangles || surface.twins.size() != 3 * num_triangles)
    throw StageError("label borders need one label a triangle and one twin a half-edge");
  std::int32_t num_labels = 0;
  for (const std::int32_t label : label_of_triangle) num_labels = std::max(num_labels, label);
  // There are lists as long as the greatest label.
  if (static_cast<std::size_t>(num_labels) > std::max(num_triangles, kAlwaysTaken))
    throw StageError("label " + std::to_string(num_labels) + " of a mesh of " + std::to_string(num_triangles) +
                     " triangles: labels count patches from 1 on; number them without such gaps");
  const auto emit = [&](std::size_t begin, std::size_t end, std::vector<OwnedHalfEdge>& list) {
    for (std::size_t t = begin; t < end; ++t) {
      const std::int32_t label = label_of_triangle[t];
      if (label <= 0) continue;
      for (std::size_t h = 3 * t; h < 3 * t + 3; ++h) {
        const std::int32_t twin = surface.twins[h];
        if (twin < 0 || label_of_triangle[at(triangle_of_half_edge(twin))] != label)
          list.push_back({label - 1, static_cast<std::int32_t>(h)});
      }
    }
  };
  std::vector<std::int32_t> order(at(num_labels));
  std::iota(order.begin(), order.end(), 0);
  return trace_all(
      surface, gather_by_owner(num_triangles, order.size(), emit, execution), order,
      [](std::size_t owner) { return static_cast<std::int32_t>(owner) + 1; },
      [&](std::size_t owner) {
        return [labels = label_of_triangle.data(), label = static_cast<std::int32_t>(owner) + 1](
                   std::int32_t triangle) { return labels[triangle] == label; };
      },
      label_of_triangle, execution);
}

BorderLoops merge_borders(const BorderLoops& first, const BorderLoops& second) {
  BorderLoops merged;
  merged.first_edge_of_loop.push_back(0);
  merged.num_hole_loops_dropped = first.num_hole_loops_dropped + second.num_hole_loops_dropped;
  std::size_t i = 0, j = 0;
  while (i < first.num_loops() || j < second.num_loops()) {
    const bool from_first =
        j == second.num_loops() || (i < first.num_loops() && first.owner_of_loop[i] < second.owner_of_loop[j]);
    const BorderLoops& source = from_first ? first : second;
    const std::size_t loop = from_first ? i++ : j++;
    merged.owner_of_loop.push_back(source.owner_of_loop[loop]);
    merged.level_length_of_loop.push_back(source.level_length_of_loop[loop]);
    merged.hole_length_of_loop.push_back(source.hole_length_of_loop[loop]);
    const auto begin = source.first_edge_of_loop[loop], end = source.first_edge_of_loop[loop + 1];
    auto append = [&](auto& to, const auto& from) { to.insert(to.end(), from.begin() + begin, from.begin() + end); };
    append(merged.half_edges, source.half_edges);
    append(merged.kinds, source.kinds);
    append(merged.neighbours, source.neighbours);
    merged.first_edge_of_loop.push_back(static_cast<std::int64_t>(merged.half_edges.size()));
  }
  return merged;
}

}  // namespace meshmser
