#include "stages/mser/level_lines.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

#include "stages/common/adjacency.hpp"

namespace meshmser {
namespace {

/// Calls `visit(half-edge, node)` for each level edge of each node, half-edges ascending.
template <class Visitor>
void visit_level_edges(const SurfaceView& surface, const ComponentTree& tree, Visitor visit) {
  for (std::size_t h = 0; h < surface.twins.size(); ++h) {
    if (surface.twins[h] < 0) continue;
    const std::int32_t node = tree.node_of_triangle[h / 3];
    const std::int32_t end = tree.node_of_triangle[static_cast<std::size_t>(surface.twins[h] / 3)];
    if (node < 0 || node == end) continue;
    if (end >= 0 && tree.hi_of_node[static_cast<std::size_t>(node)] < tree.hi_of_node[static_cast<std::size_t>(end)])
      continue;
    // Of two neighbours the one of higher level lies in a descendant of the other's node: every node in between ends
    // here.
    for (std::int32_t n = node; n >= 0 && n != end; n = tree.parent_of_node[static_cast<std::size_t>(n)])
      visit(h, static_cast<std::size_t>(n));
  }
}

/// The nodes that `wanted(node)`; roots only where marked.
template <class Wanted>
std::vector<std::int32_t> select_if(const ComponentTree& tree, std::span<const std::uint8_t> open_root_of_node,
                                    NodeFates* fates, NodeFate::Kind otherwise, Wanted wanted) {
  std::vector<std::int32_t> selected;
  for (std::size_t n = 0; n < tree.num_nodes(); ++n) {
    if (tree.parent_of_node[n] < 0 && (open_root_of_node.empty() || open_root_of_node[n] == 0))
      tell_fate(fates, n, {NodeFate::Kind::kRoot});
    else if (wanted(n))
      selected.push_back(static_cast<std::int32_t>(n));
    else
      tell_fate(fates, n, {otherwise});
  }
  return selected;
}

}  // namespace

std::vector<double> level_line_lengths(const SurfaceView& surface, const ComponentTree& tree) {
  std::vector<double> lengths(tree.num_nodes(), 0);
  visit_level_edges(surface, tree, [&](std::size_t h, std::size_t node) {
    const auto& corners = surface.triangles[h / 3];
    lengths[node] += (surface.positions[static_cast<std::size_t>(corners[h % 3])] -
                      surface.positions[static_cast<std::size_t>(corners[(h + 1) % 3])])
                         .norm();
  });
  return lengths;
}

std::vector<LevelLine> level_lines(const SurfaceView& surface, const ComponentTree& tree,
                                   std::span<const double> gradients) {
  // The level edges of each node, by ascending id.
  std::vector<std::int64_t> first(tree.num_nodes() + 1, 0);
  visit_level_edges(surface, tree, [&](std::size_t, std::size_t node) { ++first[node + 1]; });
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<std::int32_t> edges(static_cast<std::size_t>(first.back()));
  std::vector<std::int64_t> next(first.begin(), first.end() - 1);
  visit_level_edges(surface, tree, [&](std::size_t h, std::size_t node) {
    edges[static_cast<std::size_t>(next[node]++)] = static_cast<std::int32_t>(h);
  });

  std::vector<LevelLine> lines;
  // The node in whose border each half-edge was last walked over.
  std::vector<std::int32_t> walked(surface.twins.size(), -1);
  for (std::size_t n = 0; n < tree.num_nodes(); ++n) {
    const auto node = static_cast<std::int32_t>(n);
    const auto leaves = [&](std::int32_t twin) {
      if (twin < 0) return true;
      const std::int32_t other = tree.node_of_triangle[static_cast<std::size_t>(twin) / 3];
      return other < tree.first_node_of_subtree[n] || other > node;
    };
    for (auto e = static_cast<std::size_t>(first[n]); e < static_cast<std::size_t>(first[n + 1]); ++e) {
      if (walked[static_cast<std::size_t>(edges[e])] == node) continue;
      LevelLine line{node, 0, std::numeric_limits<double>::infinity()};
      std::int32_t h = edges[e];
      while (walked[static_cast<std::size_t>(h)] != node) {
        walked[static_cast<std::size_t>(h)] = node;
        if (const std::int32_t twin = surface.twins[static_cast<std::size_t>(h)]; twin >= 0) {
          const auto& corners = surface.triangles[static_cast<std::size_t>(h) / 3];
          const auto k = static_cast<std::size_t>(h) % 3;
          line.length += (surface.positions[static_cast<std::size_t>(corners[k])] -
                          surface.positions[static_cast<std::size_t>(corners[(k + 1) % 3])])
                             .norm();
          line.least_gradient = std::min(line.least_gradient, gradients[static_cast<std::size_t>(twin) / 3]);
        }
        // On to the next border edge, turning about the end vertex inside the node.
        h = next_half_edge(h);
        while (!leaves(surface.twins[static_cast<std::size_t>(h)]))
          h = next_half_edge(surface.twins[static_cast<std::size_t>(h)]);
      }
      lines.push_back(line);
    }
  }
  return lines;
}

std::vector<std::int32_t> select_length(const ComponentTree& tree, std::span<const double> length_of_node, double least,
                                        std::span<const std::uint8_t> open_root_of_node, NodeFates* fates) {
  return select_if(tree, open_root_of_node, fates, NodeFate::Kind::kShortLine,
                   [&](std::size_t n) { return length_of_node[n] >= least; });
}

std::vector<std::int32_t> select_level(const ComponentTree& tree, double value,
                                       std::span<const std::uint8_t> open_root_of_node, NodeFates* fates) {
  const double signed_value = tree.polarity == Polarity::kLower ? -value : value;
  const auto level = static_cast<std::int32_t>(std::upper_bound(tree.levels.begin(), tree.levels.end(), signed_value) -
                                               tree.levels.begin());
  return select_if(tree, open_root_of_node, fates, NodeFate::Kind::kOtherLevel,
                   [&](std::size_t n) { return tree.is_at(static_cast<std::int32_t>(n), level); });
}

}  // namespace meshmser
