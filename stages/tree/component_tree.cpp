#include "stages/tree/component_tree.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <string>

#include "stages/common/adjacency.hpp"
#include "stages/common/exact_area.hpp"
#include "stages/common/large_pages.hpp"
#include "stages/common/parallel.hpp"
#include "stages/tree/level_bitmap.hpp"

namespace meshmser {
namespace {

/// Where a level's triangles wait: taken are those before `head`, waiting those before `tail`, in the queue array.
struct Segment {
  std::int32_t head = 0, tail = 0;
};

/// A node whose triangles are still being met.
struct OpenNode {
  std::int32_t level;
  std::int32_t first_node;   ///< of its subtree
  std::int32_t first_taken;  ///< place in the queue array of its first triangle
};

constexpr std::int32_t kAdjacencyAhead = 8;
constexpr std::int32_t kLevelsAhead = 4;

/// Floods the mesh from its highest levels downward. Triangles wait in one first-in-first-out segment a level, all in
/// one array; the segments' places follow from the histogram of levels, since every triangle is put exactly once. The
/// part of a segment taken while a node is open is exactly the node's own triangles, so that ids can be given when it
/// closes.
class Flood {
 public:
  Flood(std::span<const std::int32_t> twins, std::span<const std::int32_t> levels, std::int32_t num_levels,
        ComponentTree& tree)
      : twins_(twins), levels_(levels), waiting_(static_cast<std::size_t>(num_levels) + 1), tree_(tree) {
    // One pass: the histogram of levels, and level 0, which is in no node, marked as seen.
    const std::size_t n = levels.size();
    segments_.resize(static_cast<std::size_t>(num_levels) + 2);
    seen_.assign(n / 64 + 1, 0);
    for (std::size_t begin = 0; begin < n; begin += 64) {
      std::uint64_t without_level = 0;
      const std::size_t end = std::min(n, begin + 64);
      for (std::size_t t = begin; t < end; ++t) {
        const auto level = static_cast<std::uint32_t>(levels[t]);
        if (level > static_cast<std::uint32_t>(num_levels))
          throw StageError("the level of triangle " + std::to_string(t) + " is " + std::to_string(levels[t]) +
                           ", outside 0 .. " + std::to_string(num_levels) + ", the number of levels");
        ++segments_[level + 1].head;
        without_level |= static_cast<std::uint64_t>(level == 0) << (t - begin);
      }
      seen_[begin / 64] = without_level;
    }
    segments_[1].head = 0;  // level 0 never waits: its segment has no room
    std::int32_t sum = 0;
    for (Segment& segment : segments_) segment.head = segment.tail = sum += segment.head;
    segments_.pop_back();
    reserve_on_large_pages(queue_, static_cast<std::size_t>(sum));
    queue_.resize(static_cast<std::size_t>(sum));
  }

  void run(const Execution& execution) {
    for (std::size_t word = 0; word < seen_.size(); ++word) {
      if (word % 1024 == 0) execution.check();
      while (seen_[word] != ~std::uint64_t{0}) {
        const std::size_t t = 64 * word + static_cast<std::size_t>(std::countr_one(seen_[word]));
        if (t >= levels_.size()) break;
        flood_from(static_cast<std::int32_t>(t), execution);
      }
    }
  }

 private:
  void put(std::int32_t triangle, std::int32_t level) {
    const auto l = static_cast<std::size_t>(level);
    waiting_.set(l);
    __builtin_prefetch(&twins_[3 * static_cast<std::size_t>(triangle)]);
    queue_[static_cast<std::size_t>(segments_[l].tail++)] = triangle;
  }

  void open(std::int32_t level, std::int32_t first_node) {
    open_.push_back({level, first_node, segments_[static_cast<std::size_t>(level)].head});
  }

  /// Gives the top node its id, its triangles and its children; returns the first node of its subtree.
  std::int32_t close() {
    const OpenNode node = open_.back();
    open_.pop_back();
    const auto id = static_cast<std::int32_t>(tree_.hi_of_node.size());
    tree_.hi_of_node.push_back(node.level);
    tree_.first_node_of_subtree.push_back(node.first_node);
    tree_.parent_of_node.push_back(-1);
    // In postorder the children of `id` are the last nodes of the intervals that fill its own.
    for (std::int32_t child = id - 1; child >= node.first_node;
         child = tree_.first_node_of_subtree[static_cast<std::size_t>(child)] - 1)
      tree_.parent_of_node[static_cast<std::size_t>(child)] = id;
    const std::int32_t end = segments_[static_cast<std::size_t>(node.level)].head;
    for (std::int32_t i = node.first_taken; i < end; ++i)
      tree_.node_of_triangle[static_cast<std::size_t>(queue_[static_cast<std::size_t>(i)])] = id;
    return node.first_node;
  }

  void flood_from(std::int32_t start, const Execution& execution) {
    std::int32_t current = levels_[static_cast<std::size_t>(start)];
    seen_[static_cast<std::size_t>(start) / 64] |= std::uint64_t{1} << (static_cast<std::size_t>(start) % 64);
    put(start, current);
    open(current, static_cast<std::int32_t>(tree_.hi_of_node.size()));
    while (true) {
      const auto l = static_cast<std::size_t>(current);
      if (segments_[l].head < segments_[l].tail) {
        const std::int32_t highest = take(current);
        if (highest > current) {
          current = highest;
          open(current, static_cast<std::int32_t>(tree_.hi_of_node.size()));
        }
        continue;
      }
      waiting_.clear(l);
      execution.check();
      const std::int32_t below = waiting_.highest_below(current);
      // Nodes above the next waiting level are complete.
      std::int32_t first_node = close();
      while (!open_.empty() && open_.back().level > below) first_node = close();
      if (below == 0) return;
      if (open_.empty() || open_.back().level < below) open(below, first_node);
      current = below;
    }
  }

  /// Takes one triangle of the current level and puts its neighbours that were not met before; returns the highest
  /// level put, or the current one.
  std::int32_t take(std::int32_t current) {
    Segment& segment = segments_[static_cast<std::size_t>(current)];
    const std::int32_t place = segment.head++;
    if (place + kAdjacencyAhead < segment.tail)
      __builtin_prefetch(
          &twins_[3 * static_cast<std::size_t>(queue_[static_cast<std::size_t>(place + kAdjacencyAhead)])]);
    if (place + kLevelsAhead < segment.tail) {
      const std::size_t h = 3 * static_cast<std::size_t>(queue_[static_cast<std::size_t>(place + kLevelsAhead)]);
      for (std::size_t k = 0; k < 3; ++k) {
        const auto neighbour = static_cast<std::size_t>(std::max(twins_[h + k], 0)) / 3;
        __builtin_prefetch(&levels_[neighbour]);
        __builtin_prefetch(&seen_[neighbour / 64]);
      }
    }
    const std::size_t h = 3 * static_cast<std::size_t>(queue_[static_cast<std::size_t>(place)]);
    std::int32_t highest = current;
    bool again = false;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t twin = twins_[h + k];
      if (twin < 0) continue;
      const std::int32_t neighbour = triangle_of_half_edge(twin);
      std::uint64_t& word = seen_[static_cast<std::size_t>(neighbour) / 64];
      const std::uint64_t bit = std::uint64_t{1} << (static_cast<std::size_t>(neighbour) % 64);
      if (word & bit) continue;
      const std::int32_t level = levels_[static_cast<std::size_t>(neighbour)];
      if (level > current) {
        // Two higher neighbours may be of two components: the second waits until the first is flooded. This happens
        // only where levels are not the least of corners, since else all but one neighbour share the least corner.
        if (highest > current) {
          again = true;
          continue;
        }
        highest = level;
      }
      word |= bit;
      put(neighbour, level);
    }
    if (again) --segment.head;
    return highest;
  }

  std::span<const std::int32_t> twins_, levels_;
  std::vector<Segment> segments_;  ///< a level
  std::vector<std::int32_t> queue_;
  std::vector<std::uint64_t> seen_;
  LevelBitmap waiting_;
  std::vector<OpenNode> open_;
  ComponentTree& tree_;
};

/// Exact areas of the nodes (definitions 6): own triangles first, then every node into its parent, children first.
void sum_areas(std::span<const double> areas, ComponentTree& tree) {
  const std::size_t n = tree.num_nodes();
  for (std::size_t t = 0; t < areas.size(); ++t)
    if (!(areas[t] >= 0 && areas[t] <= std::numeric_limits<double>::max()))
      throw StageError("the area of triangle " + std::to_string(t) +
                       " is not a finite number >= 0; check the coordinates of its corners");
  // Roots in order; the nodes of root r are those after root r - 1 up to itself.
  std::vector<std::int32_t> roots;
  for (std::size_t i = 0; i < n; ++i)
    if (tree.parent_of_node[i] < 0) roots.push_back(static_cast<std::int32_t>(i));
  std::vector<std::int64_t> count(roots.size(), 0);
  std::vector<double> greatest(roots.size(), 0);
  if (roots.size() == 1) {
    for (std::size_t t = 0; t < areas.size(); ++t) {
      const bool in_tree = tree.node_of_triangle[t] >= 0;
      count[0] += in_tree;
      greatest[0] = std::max(greatest[0], in_tree ? areas[t] : 0.0);
    }
  } else {
    // Only here it matters which root a triangle is under.
    std::vector<std::int32_t> root_of_node(n);
    for (std::size_t i = 0, r = 0; i < n; ++i) {
      root_of_node[i] = static_cast<std::int32_t>(r);
      r += tree.parent_of_node[i] < 0;
    }
    for (std::size_t t = 0; t < areas.size(); ++t) {
      if (tree.node_of_triangle[t] < 0) continue;
      const auto r = static_cast<std::size_t>(root_of_node[static_cast<std::size_t>(tree.node_of_triangle[t])]);
      ++count[r];
      greatest[r] = std::max(greatest[r], areas[t]);
    }
  }
  tree.area_of_node.assign(n, 0);
  tree.area_exponent_of_node.resize(n);
  for (std::size_t i = 0, r = 0; i < n; ++i) {
    tree.area_exponent_of_node[i] = area_exponent(count[r], greatest[r]);
    r += tree.parent_of_node[i] < 0;
  }
  const std::int32_t only_exponent = roots.size() == 1 ? tree.area_exponent_of_node[0] : 0;
  for (std::size_t t = 0; t < areas.size(); ++t) {
    if (tree.node_of_triangle[t] < 0) continue;
    const auto node = static_cast<std::size_t>(tree.node_of_triangle[t]);
    tree.area_of_node[node] +=
        area_in_units(areas[t], roots.size() == 1 ? only_exponent : tree.area_exponent_of_node[node]);
  }
  for (std::size_t i = 0; i < n; ++i) {
    const std::int32_t parent = tree.parent_of_node[i];
    if (parent >= 0) tree.area_of_node[static_cast<std::size_t>(parent)] += tree.area_of_node[i];
  }
}

}  // namespace

ComponentTree build_component_tree(std::span<const std::int32_t> twins, std::span<const double> areas,
                                   std::span<const std::int32_t> level_of_triangle, std::int32_t num_levels,
                                   const Execution& execution) {
  const std::size_t n = level_of_triangle.size();
  if (twins.size() != 3 * n || areas.size() != n)
    throw StageError("a tree needs one level and one area a triangle and one twin a half-edge: given are " +
                     std::to_string(n) + " levels, " + std::to_string(areas.size()) + " areas and " +
                     std::to_string(twins.size()) + " twins");
  if (n > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()) / 3)
    throw StageError("a mesh of " + std::to_string(n) +
                     " triangles is too large: half-edge ids end at 715827882 triangles; split the mesh");
  if (num_levels < 0) throw StageError("the number of levels is negative");
  ComponentTree tree;
  reserve_on_large_pages(tree.node_of_triangle, n);
  tree.node_of_triangle.assign(n, -1);
  Flood(twins, level_of_triangle, num_levels, tree).run(execution);
  sum_areas(areas, tree);
  return tree;
}

std::vector<std::int32_t> rebuild_levels(const ComponentTree& tree) {
  std::vector<std::int32_t> levels(tree.node_of_triangle.size(), 0);
  for (std::size_t t = 0; t < levels.size(); ++t)
    if (tree.node_of_triangle[t] >= 0) levels[t] = tree.hi_of_node[static_cast<std::size_t>(tree.node_of_triangle[t])];
  return levels;
}

}  // namespace meshmser
