#include "stages/borders/borders.hpp"

#include <algorithm>
#include <limits>
#include <memory>
#include <mutex>
#include <numeric>
#include <utility>

#include "stages/borders/loop_tracer.hpp"
#include "stages/common/adjacency.hpp"
#include "stages/common/large_pages.hpp"
#include "stages/common/parallel.hpp"

namespace meshmser {
namespace {

constexpr std::int32_t kNone = -1;
/// Small enough to share out, large enough to cost nothing.
constexpr std::int64_t kEdgesPerGroup = 1 << 15;

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

RimLevels walk_rims(const SurfaceView& surface, const ComponentTree& tree, std::span<const std::int32_t> levels,
                    std::span<const std::int32_t> num_regions_of_node) {
  RimLevels rims;
  for (std::size_t h = 0; h < surface.twins.size(); ++h)
    if (surface.twins[h] < 0 && levels[h / 3] > 0) rims.half_edges.push_back(static_cast<std::int32_t>(h));
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
        const std::int32_t level = levels[at(triangle_of_half_edge(out))];
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
    if (least > 0) rims.num_loops_dropped += num_regions_of_node[at(tree.node_of_triangle[at(least_triangle)])];
  }
  return rims;
}

/// Loops of owners with the half-edges first_of_owner[i] .. first_of_owner[i + 1], each ascending. Owners are traced in
/// groups of about as many half-edges each; groups are put together in order, so that threads do not matter.
template <class NumberOf, class InsideOf>
BorderLoops trace_all(const SurfaceView& surface, std::span<const std::int32_t> half_edges,
                      std::span<const std::int64_t> first_of_owner, NumberOf&& number_of, InsideOf&& inside_of,
                      std::span<const std::int32_t> number_behind, const Execution& execution) {
  std::vector<std::size_t> first_of_group{0};
  for (std::size_t i = 0; i + 1 < first_of_owner.size(); ++i)
    if (first_of_owner[i + 1] - first_of_owner[first_of_group.back()] >= kEdgesPerGroup)
      first_of_group.push_back(i + 1);
  if (first_of_group.back() + 1 < first_of_owner.size()) first_of_group.push_back(first_of_owner.size() - 1);
  const std::size_t num_groups = first_of_group.size() - 1;
  std::vector<BorderLoops> groups(num_groups);
  // A tracer holds a bit a half-edge: as many are made as threads work at a time.
  std::mutex mutex;
  std::vector<std::unique_ptr<LoopTracer>> idle;
  parallel_chunks(
      static_cast<std::int64_t>(num_groups), 1, "borders", execution, [&](std::int64_t begin, std::int64_t) {
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
        BorderLoops& loops = groups[group];
        const auto num_edges =
            static_cast<std::size_t>(first_of_owner[first_of_group[group + 1]] - first_of_owner[first_of_group[group]]);
        loops.half_edges.reserve(num_edges);
        loops.kinds.reserve(num_edges);
        loops.neighbours.reserve(num_edges);
        loops.first_edge_of_loop.push_back(0);
        for (std::size_t i = first_of_group[group]; i < first_of_group[group + 1]; ++i)
          tracer->trace(half_edges.subspan(static_cast<std::size_t>(first_of_owner[i]),
                                           static_cast<std::size_t>(first_of_owner[i + 1] - first_of_owner[i])),
                        number_of(i), inside_of(i), number_behind, loops);
        const std::lock_guard lock(mutex);
        idle.push_back(std::move(tracer));
      });
  if (num_groups == 1) return std::move(groups[0]);
  BorderLoops all;
  all.first_edge_of_loop.push_back(0);
  std::size_t num_edges = 0;
  for (const BorderLoops& loops : groups) num_edges += loops.half_edges.size();
  all.half_edges.reserve(num_edges);
  all.kinds.reserve(num_edges);
  all.neighbours.reserve(num_edges);
  for (BorderLoops& loops : groups) {
    const auto base = static_cast<std::int64_t>(all.half_edges.size());
    auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    append(all.owner_of_loop, loops.owner_of_loop);
    append(all.half_edges, loops.half_edges);
    append(all.kinds, loops.kinds);
    append(all.neighbours, loops.neighbours);
    append(all.level_length_of_loop, loops.level_length_of_loop);
    append(all.hole_length_of_loop, loops.hole_length_of_loop);
    for (std::size_t l = 1; l < loops.first_edge_of_loop.size(); ++l)
      all.first_edge_of_loop.push_back(base + loops.first_edge_of_loop[l]);
    all.num_hole_loops_dropped += loops.num_hole_loops_dropped;
    loops = {};
  }
  return all;
}

struct Emitted {
  std::int32_t region;  ///< index into the regions by ascending number
  std::int32_t half_edge;
};

}  // namespace

BorderLoops extract_borders(const SurfaceView& surface, const ComponentTree& tree,
                            std::span<const std::int32_t> number_of_node, std::span<const std::int32_t> number_behind,
                            const Execution& execution) {
  const std::size_t num_nodes = tree.num_nodes(), num_triangles = surface.triangles.size();
  if (number_of_node.size() != num_nodes || number_behind.size() != num_triangles ||
      tree.node_of_triangle.size() != num_triangles || surface.twins.size() != 3 * num_triangles)
    throw StageError("borders need one number a node and a triangle, and one twin a half-edge of the tree's own mesh");
  // Regions by ascending number; smallest region of each node, and of each region the next one that contains it.
  std::vector<std::int32_t> nodes;
  for (std::size_t node = 0; node < num_nodes; ++node)
    if (number_of_node[node] > 0) nodes.push_back(static_cast<std::int32_t>(node));
  std::sort(nodes.begin(), nodes.end(),
            [&](std::int32_t a, std::int32_t b) { return number_of_node[at(a)] < number_of_node[at(b)]; });
  std::vector<std::int32_t> region_of_node(num_nodes, kNone);
  for (std::size_t r = 0; r < nodes.size(); ++r) region_of_node[at(nodes[r])] = static_cast<std::int32_t>(r);
  std::vector<std::int32_t> outer_of_region(nodes.size(), kNone), num_regions_of_node(num_nodes, 0);
  for (std::size_t node = num_nodes; node-- > 0;) {
    const std::int32_t parent = tree.parent_of_node[node];
    const std::int32_t outer = parent < 0 ? kNone : region_of_node[at(parent)];
    num_regions_of_node[node] = parent < 0 ? 0 : num_regions_of_node[at(parent)];
    if (region_of_node[node] == kNone) {
      region_of_node[node] = outer;
    } else {
      outer_of_region[at(region_of_node[node])] = outer;
      ++num_regions_of_node[node];
    }
  }
  std::vector<std::int32_t> lo_of_region(nodes.size());
  for (std::size_t r = 0; r < nodes.size(); ++r) lo_of_region[r] = tree.lo(nodes[r]);
  // Of each node: lo of its smallest region, 0 for none.
  std::vector<std::int32_t> lo_of_node(num_nodes, 0);
  for (std::size_t node = 0; node < num_nodes; ++node)
    if (region_of_node[node] != kNone) lo_of_node[node] = lo_of_region[at(region_of_node[node])];
  std::vector<std::int32_t> levels;
  reserve_on_large_pages(levels, num_triangles);
  levels.assign(num_triangles, 0);
  for (std::size_t t = 0; t < num_triangles; ++t)
    if (tree.node_of_triangle[t] >= 0) levels[t] = tree.hi_of_node[at(tree.node_of_triangle[t])];

  const RimLevels rims = walk_rims(surface, tree, levels, num_regions_of_node);
  // Triangles a and b that touch are in one component at the lower of their levels, so one node is an ancestor of the
  // other, and the regions with a but not b are those met climbing from a's until lo is not above b's level.
  std::vector<Emitted> emitted;
  std::vector<std::int64_t> first_of_region(nodes.size() + 1, 0);
  std::size_t rim = 0;
  for (std::size_t t = 0; t < num_triangles; ++t) {
    if (t % (1 << 16) == 0) execution.check();
    const std::int32_t node = tree.node_of_triangle[t];
    if (node < 0) continue;
    const std::int32_t lo = lo_of_node[at(node)];
    for (std::size_t h = 3 * t; h < 3 * t + 3; ++h) {
      const std::int32_t twin = surface.twins[h];
      std::int32_t level_behind = 0;
      if (twin >= 0) {
        level_behind = levels[at(triangle_of_half_edge(twin))];
      } else {
        while (rims.half_edges[rim] != static_cast<std::int32_t>(h)) ++rim;
        level_behind = rims.least[rim];
      }
      if (level_behind >= lo) continue;
      for (std::int32_t region = region_of_node[at(node)]; region != kNone && lo_of_region[at(region)] > level_behind;
           region = outer_of_region[at(region)]) {
        emitted.push_back({region, static_cast<std::int32_t>(h)});
        ++first_of_region[at(region) + 1];
      }
    }
  }
  std::partial_sum(first_of_region.begin(), first_of_region.end(), first_of_region.begin());
  std::vector<std::int32_t> half_edges(emitted.size());
  std::vector<std::int64_t> place(first_of_region.begin(), first_of_region.end() - 1);
  for (const Emitted& e : emitted) half_edges[static_cast<std::size_t>(place[at(e.region)]++)] = e.half_edge;
  emitted = {};

  BorderLoops loops = trace_all(
      surface, half_edges, first_of_region, [&](std::size_t r) { return number_of_node[at(nodes[r])]; },
      [&](std::size_t r) {
        return [&levels, lo = lo_of_region[r]](std::int32_t triangle) { return levels[at(triangle)] >= lo; };
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
  std::vector<std::int64_t> first_of_label(at(num_labels) + 2, 0);
  auto for_each_border = [&](auto&& body) {
    for (std::size_t t = 0; t < num_triangles; ++t) {
      if (t % (1 << 16) == 0) execution.check();
      const std::int32_t label = label_of_triangle[t];
      if (label <= 0) continue;
      for (std::size_t h = 3 * t; h < 3 * t + 3; ++h) {
        const std::int32_t twin = surface.twins[h];
        if (twin < 0 || label_of_triangle[at(twin / 3)] != label) body(label, static_cast<std::int32_t>(h));
      }
    }
  };
  for_each_border([&](std::int32_t label, std::int32_t) { ++first_of_label[at(label) + 1]; });
  std::partial_sum(first_of_label.begin(), first_of_label.end(), first_of_label.begin());
  std::vector<std::int32_t> half_edges(static_cast<std::size_t>(first_of_label.back()));
  std::vector<std::int64_t> place(first_of_label.begin(), first_of_label.end() - 1);
  for_each_border([&](std::int32_t label, std::int32_t half_edge) {
    half_edges[static_cast<std::size_t>(place[at(label)]++)] = half_edge;
  });
  return trace_all(
      surface, half_edges, first_of_label, [](std::size_t label) { return static_cast<std::int32_t>(label); },
      [&](std::size_t label) {
        return
            [=](std::int32_t triangle) { return label_of_triangle[at(triangle)] == static_cast<std::int32_t>(label); };
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
