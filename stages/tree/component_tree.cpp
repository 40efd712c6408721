#include "stages/tree/component_tree.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "stages/common/adjacency.hpp"
#include "stages/common/exact_area.hpp"
#include "stages/common/large_pages.hpp"
#include "stages/common/parallel.hpp"
#include "stages/tree/level_bitmap.hpp"

namespace meshmser {
namespace {

/// What the flood needs of a triangle, 16 bytes: who has looked at a neighbour's level has its neighbours too.
struct FloodTriangle {
  std::array<std::uint32_t, 3> neighbours;  ///< #F where there is none
  std::int32_t unmet;                       ///< its level while it was not met, then 0
};

/// Where a level's triangles wait: taken are those before `head`, waiting those before `tail`, in the queue array.
struct Segment {
  std::int32_t head = 0, tail = 0;
};

/// A triangle that was met and will wait at its level.
struct Met {
  std::int32_t triangle, level;
};

/// A node whose triangles are still being met.
struct OpenNode {
  std::int32_t level;
  std::int32_t first_node;   ///< of its subtree
  std::int32_t first_taken;  ///< place in the queue array of its first triangle
};

constexpr std::int32_t kTrianglesAhead = 16;
constexpr std::int32_t kNeighboursAhead = 8;
constexpr std::size_t kMostLower = 512;    ///< so many stay in the processor's nearest cache
constexpr std::size_t kFewTriangles = 16;  ///< a level
constexpr std::int64_t kTrianglesPerChunk = 1 << 16;
/// Up to so many levels a chunk counts its triangles by level for itself.
constexpr std::int32_t kFewLevels = 1 << 14;

/// What the flood leaves: the queue array, in which the own triangles of every node stand side by side.
struct Flooded {
  std::unique_ptr<std::int32_t[]>
      queue;  ///< the triangles of level 1 and above, and a place of none behind each level's
  std::vector<std::int32_t> first_of_node;  ///< #N: place in the queue of a node's first own triangle
  std::vector<std::int32_t> end_of_node;    ///< #N
  std::size_t num_triangles = 0;            ///< of level 1 and above
};

/// Floods the mesh from its highest levels downward. Triangles wait in one first-in-first-out segment a level, all in
/// one array; the segments' places follow from the histogram of levels, since every triangle is put exactly once. The
/// part of a segment taken while a node is open is exactly the node's own triangles. Behind each segment one place is
/// free, to be written past its last triangle.
class Flood {
 public:
  Flood(std::span<const std::int32_t> twins, std::span<const std::int32_t> levels, std::int32_t num_levels,
        ComponentTree& tree, const Execution& execution)
      : segments_(static_cast<std::size_t>(num_levels) + 1),
        waiting_(static_cast<std::size_t>(num_levels) + 1),
        tree_(tree) {
    const std::vector<std::int32_t> num_of_level = take_triangles(twins, levels, num_levels, execution);
    flooded_.num_triangles = levels.size() - static_cast<std::size_t>(num_of_level[0]);
    few_a_level_ = flooded_.num_triangles / kFewTriangles < segments_.size();
    std::int32_t sum = 0;
    for (std::size_t level = 0; level < segments_.size(); ++level) {
      segments_[level] = {sum, sum};
      sum += (level == 0 ? 0 : num_of_level[level]) + 1;  // level 0 never waits
    }
    flooded_.queue = make_on_large_pages<std::int32_t>(static_cast<std::size_t>(sum));
  }

  Flooded run(const Execution& execution) {
    for (std::size_t t = 0; num_taken_ < flooded_.num_triangles; ++t)
      if (triangles_[t].unmet != 0) flood_from(static_cast<std::int32_t>(t), execution);
    return std::move(flooded_);
  }

 private:
  /// The neighbours and levels of all triangles, checked; returns how many triangles have each level.
  std::vector<std::int32_t> take_triangles(std::span<const std::int32_t> twins, std::span<const std::int32_t> levels,
                                           std::int32_t num_levels, const Execution& execution) {
    const std::size_t n = levels.size();
    triangles_ = make_on_large_pages<FloodTriangle>(n + 1);
    const auto nobody = nobody_ = static_cast<std::uint32_t>(n);
    triangles_[n] = {{nobody, nobody, nobody}, 0};
    std::vector<std::int32_t> num_of_level(static_cast<std::size_t>(num_levels) + 1, 0);
    const auto limit = static_cast<std::uint32_t>(num_levels);
    // Returns whether every level of the chunk is within range; those that are not are counted as level 0.
    const auto take_chunk = [&](std::int64_t begin, std::int64_t end, std::vector<std::int32_t>& num) {
      bool good = true;
      // A missing twin, as an unsigned number, is beyond every triangle.
      const auto neighbour = [&](std::size_t h) { return std::min(static_cast<std::uint32_t>(twins[h]) / 3, nobody); };
      for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t) {
        const auto level = static_cast<std::uint32_t>(levels[t]);
        good &= level <= limit;
        const std::uint32_t counted = level <= limit ? level : 0;
        triangles_[t] = {{neighbour(3 * t), neighbour(3 * t + 1), neighbour(3 * t + 2)},
                         static_cast<std::int32_t>(counted)};
        ++num[counted];
      }
      return good;
    };
    std::atomic<bool> all_good{true};
    if (num_levels <= kFewLevels) {
      std::mutex mutex;
      parallel_chunks(static_cast<std::int64_t>(n), 4 * kTrianglesPerChunk, "", execution,
                      [&](std::int64_t begin, std::int64_t end) {
                        std::vector<std::int32_t> own(num_of_level.size(), 0);
                        if (!take_chunk(begin, end, own)) all_good = false;
                        const std::lock_guard lock(mutex);
                        for (std::size_t level = 0; level < own.size(); ++level) num_of_level[level] += own[level];
                      });
    } else {
      all_good = take_chunk(0, static_cast<std::int64_t>(n), num_of_level);
    }
    if (all_good) return num_of_level;
    const auto bad = std::find_if(levels.begin(), levels.end(),
                                  [&](std::int32_t level) { return static_cast<std::uint32_t>(level) > limit; });
    throw StageError("the level of triangle " + std::to_string(bad - levels.begin()) + " is " + std::to_string(*bad) +
                     ", outside 0 .. " + std::to_string(num_levels) + ", the number of levels");
  }

  void open(std::int32_t level, std::int32_t first_node) {
    open_.push_back({level, first_node, segments_[static_cast<std::size_t>(level)].head});
  }

  /// Gives the top node its id and its children; returns the first node of its subtree.
  std::int32_t close() {
    const OpenNode node = open_.back();
    open_.pop_back();
    const auto id = static_cast<std::int32_t>(tree_.hi_of_node.size());
    const std::int32_t end_taken = segments_[static_cast<std::size_t>(node.level)].head;
    tree_.hi_of_node.push_back(node.level);
    tree_.first_node_of_subtree.push_back(node.first_node);
    tree_.parent_of_node.push_back(-1);
    flooded_.first_of_node.push_back(node.first_taken);
    flooded_.end_of_node.push_back(end_taken);
    num_taken_ += static_cast<std::size_t>(end_taken - node.first_taken);
    // In postorder the children of `id` are the last nodes of the intervals that fill its own.
    for (std::int32_t child = id - 1; child >= node.first_node;
         child = tree_.first_node_of_subtree[static_cast<std::size_t>(child)] - 1)
      tree_.parent_of_node[static_cast<std::size_t>(child)] = id;
    return node.first_node;
  }

  void flood_from(std::int32_t start, const Execution& execution) {
    std::int32_t current = std::exchange(triangles_[static_cast<std::size_t>(start)].unmet, 0);
    put({start, current});
    open(current, static_cast<std::int32_t>(tree_.hi_of_node.size()));
    while (true) {
      const std::int32_t higher = few_a_level_ ? take_few(current) : take_many(current);
      if (higher > current) {
        current = higher;
        open(current, static_cast<std::int32_t>(tree_.hi_of_node.size()));
        continue;
      }
      waiting_.clear(static_cast<std::size_t>(current));
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

  /// Puts a triangle of level 1 or above where it waits, and fetches its neighbours.
  void put(Met met) {
    Segment& segment = segments_[static_cast<std::size_t>(met.level)];
    flooded_.queue[static_cast<std::size_t>(segment.tail)] = met.triangle;
    if (segment.tail++ == segment.head) waiting_.set(static_cast<std::size_t>(met.level));
    prefetch_around(met.triangle);
  }

  void prefetch_around(std::int32_t triangle) const {
    for (const std::uint32_t neighbour : triangles_[static_cast<std::size_t>(triangle)].neighbours)
      __builtin_prefetch(&triangles_[neighbour], 1);
  }

  /// Shows `meet` the neighbours of a triangle that are not above the current level, and the first that is above to
  /// `rise`. Returns whether there is another above, which may be of another component and must wait until the first is
  /// flooded. There is one only where levels are not the least of corners, since else all but one neighbour share the
  /// least corner.
  template <class Meet, class Rise>
  bool show_neighbours(std::int32_t triangle, std::int32_t current, const Meet& meet, const Rise& rise) {
    const std::array<std::uint32_t, 3> neighbours = triangles_[static_cast<std::size_t>(triangle)].neighbours;
    const auto unmet = [&](std::uint32_t neighbour) { return triangles_[neighbour].unmet; };
    if (std::max({unmet(neighbours[0]), unmet(neighbours[1]), unmet(neighbours[2])}) <= current) {
      for (const std::uint32_t neighbour : neighbours) meet(neighbour);
      return false;
    }
    bool risen = false;
    for (const std::uint32_t neighbour : neighbours) {
      if (unmet(neighbour) <= current) {
        meet(neighbour);
      } else if (!risen) {
        rise(neighbour);
        risen = true;
      }
    }
    return std::max({unmet(neighbours[0]), unmet(neighbours[1]), unmet(neighbours[2])}) > current;
  }

  /// Takes triangles of the current level and puts their neighbours that were not met before, until a higher one has
  /// been put, whose level it returns, or none waits, when it returns the current one. For many triangles a level.
  /// Whether a neighbour was met before and whether it is lower is a coin's toss to the processor: every neighbour is
  /// written to the ends of the current level's segment and of the list of lower ones, and stays there or not. One
  /// across two edges is met by the first. The list keeps the other levels' segments out of the loop.
  std::int32_t take_many(std::int32_t current) {
    Segment& segment = segments_[static_cast<std::size_t>(current)];
    std::int32_t* const queue = flooded_.queue.get();
    FloodTriangle* const triangles = triangles_.get();
    Met* const lower = lower_.data();
    std::int32_t head = segment.head, tail = segment.tail;
    std::size_t num_lower = 0;
    const auto meet = [&](std::uint32_t neighbour) {
      const std::int32_t level = std::exchange(triangles[neighbour].unmet, 0);
      queue[tail] = static_cast<std::int32_t>(neighbour);
      tail += static_cast<std::int32_t>(level == current);
      lower[num_lower] = {static_cast<std::int32_t>(neighbour), level};
      num_lower += static_cast<std::size_t>(level != current) & static_cast<std::size_t>(level != 0);
    };
    Met higher{-1, current};
    const auto rise = [&](std::uint32_t neighbour) {
      higher = {static_cast<std::int32_t>(neighbour), std::exchange(triangles[neighbour].unmet, 0)};
    };
    while (head < tail && higher.triangle < 0) {
      for (num_lower = 0; head < tail && higher.triangle < 0 && num_lower < kMostLower;) {
        if (head + kTrianglesAhead < tail) __builtin_prefetch(&triangles[queue[head + kTrianglesAhead]], 1);
        if (head + kNeighboursAhead < tail) prefetch_around(queue[head + kNeighboursAhead]);
        const std::int32_t triangle = queue[head++];
        if (show_neighbours(triangle, current, meet, rise)) --head;
      }
      for (std::size_t i = 0; i < num_lower; ++i) put(lower[i]);
    }
    segment = {head, tail};
    if (higher.triangle >= 0) put(higher);
    return higher.level;
  }

  /// The same for few triangles a level: those met before are put too, at level 0, whose one place is overwritten.
  std::int32_t take_few(std::int32_t current) {
    Segment& segment = segments_[static_cast<std::size_t>(current)];
    const std::uint32_t nobody = nobody_;
    std::int32_t highest = current;
    const auto meet = [&](std::uint32_t neighbour) {
      const std::int32_t level = std::exchange(triangles_[neighbour].unmet, 0);
      highest = std::max(highest, level);
      Segment& of = segments_[static_cast<std::size_t>(level)];
      flooded_.queue[static_cast<std::size_t>(of.tail)] = static_cast<std::int32_t>(neighbour);
      of.tail += static_cast<std::int32_t>(level != 0);
      waiting_.set(static_cast<std::size_t>(level));
      prefetch_around(static_cast<std::int32_t>(level != 0 ? neighbour : nobody));
    };
    while (segment.head < segment.tail && highest == current) {
      const std::int32_t triangle = flooded_.queue[static_cast<std::size_t>(segment.head++)];
      if (show_neighbours(triangle, current, meet, meet)) --segment.head;
    }
    return highest;
  }

  std::unique_ptr<FloodTriangle[]> triangles_;  ///< #F + 1; the last, nobody_, stands for no triangle
  std::uint32_t nobody_ = 0;
  std::vector<Segment> segments_;  ///< a level
  LevelBitmap waiting_;            ///< levels whose segments hold triangles, or the current one
  std::vector<OpenNode> open_;
  std::array<Met, kMostLower + 3> lower_;  ///< room of `take_many`
  bool few_a_level_ = false;
  std::size_t num_taken_ = 0;  ///< by closed nodes
  Flooded flooded_;
  ComponentTree& tree_;
};

/// The greatest area of all triangles, of which every one is checked.
double greatest_area(std::span<const double> areas, const Execution& execution) {
  constexpr double kMost = std::numeric_limits<double>::max();
  std::vector<double> greatest(areas.size() / static_cast<std::size_t>(kTrianglesPerChunk) + 1, 0);
  std::atomic<bool> all_good{true};
  parallel_chunks(static_cast<std::int64_t>(areas.size()), kTrianglesPerChunk, "", execution,
                  [&](std::int64_t begin, std::int64_t end) {
                    // Four at a time, so that one comparison need not wait for the one before.
                    std::array<double, 4> most{0, 0, 0, 0};
                    std::array<bool, 4> good{true, true, true, true};
                    const auto look = [&](std::size_t t, std::size_t lane) {
                      good[lane] = good[lane] && areas[t] >= 0 && areas[t] <= kMost;
                      most[lane] = areas[t] > most[lane] ? areas[t] : most[lane];
                    };
                    auto t = static_cast<std::size_t>(begin);
                    for (; t + 4 <= static_cast<std::size_t>(end); t += 4)
                      for (std::size_t lane = 0; lane < 4; ++lane) look(t + lane, lane);
                    for (; t < static_cast<std::size_t>(end); ++t) look(t, 0);
                    greatest[static_cast<std::size_t>(begin / kTrianglesPerChunk)] =
                        *std::max_element(most.begin(), most.end());
                    if (!(good[0] && good[1] && good[2] && good[3])) all_good = false;
                  });
  if (!all_good) {
    const auto bad =
        std::find_if(areas.begin(), areas.end(), [](double area) { return !(area >= 0 && area <= kMost); });
    throw StageError("the area of triangle " + std::to_string(bad - areas.begin()) +
                     " is not a finite number >= 0; check the coordinates of its corners");
  }
  return *std::max_element(greatest.begin(), greatest.end());
}

/// Of every node, how its root's areas are counted: by the greatest triangle and the number of triangles of the root.
void choose_exponents(std::span<const double> areas, const Flooded& flooded, ComponentTree& tree,
                      const Execution& execution) {
  const std::size_t n = tree.num_nodes();
  const double greatest_of_all = greatest_area(areas, execution);
  tree.area_exponent_of_node.resize(n);
  if (n > 0 && tree.first_node_of_subtree[n - 1] == 0 && flooded.num_triangles == areas.size()) {
    std::fill(tree.area_exponent_of_node.begin(), tree.area_exponent_of_node.end(),
              area_exponent(static_cast<std::int64_t>(areas.size()), greatest_of_all));
    return;
  }
  for (std::size_t begin = 0, end = 0; begin < n; begin = end) {
    // The nodes of a root are those after the root before, up to itself.
    std::int64_t count = 0;
    double greatest = 0;
    bool is_root = false;
    for (end = begin; !is_root; ++end) {
      is_root = tree.parent_of_node[end] < 0;
      count += flooded.end_of_node[end] - flooded.first_of_node[end];
      for (std::int32_t i = flooded.first_of_node[end]; i < flooded.end_of_node[end]; ++i)
        greatest = std::max(greatest, areas[static_cast<std::size_t>(flooded.queue[static_cast<std::size_t>(i)])]);
    }
    std::fill(tree.area_exponent_of_node.begin() + static_cast<std::ptrdiff_t>(begin),
              tree.area_exponent_of_node.begin() + static_cast<std::ptrdiff_t>(end), area_exponent(count, greatest));
  }
}

/// Exact areas of the nodes (definitions 6): own triangles first, then every node into its parent, children first.
void sum_areas(std::span<const double> areas, const Flooded& flooded, ComponentTree& tree, const Execution& execution) {
  choose_exponents(areas, flooded, tree, execution);
  const std::size_t n = tree.num_nodes(), num_triangles = areas.size();
  const bool one_exponent = n > 0 && tree.first_node_of_subtree[n - 1] == 0;
  const std::int32_t only_exponent = one_exponent ? tree.area_exponent_of_node[0] : 0;
  tree.area_of_node.assign(n, 0);
  const auto add = [&](std::size_t begin, std::size_t end, std::vector<std::int64_t>& sums) {
    for (std::size_t t = begin; t < end; ++t) {
      if (tree.node_of_triangle[t] < 0) continue;
      const auto node = static_cast<std::size_t>(tree.node_of_triangle[t]);
      sums[node] += area_in_units(areas[t], one_exponent ? only_exponent : tree.area_exponent_of_node[node]);
    }
  };
  // Whole numbers, so that it does not matter who adds which. Sums of one's own pay where nodes are few.
  const int threads = thread_count(execution);
  if (threads > 1 && num_triangles > static_cast<std::size_t>(kTrianglesPerChunk) && 16 * n < num_triangles) {
    const std::int64_t parts = std::min(threads, 8);
    const auto grain = (static_cast<std::int64_t>(num_triangles) + parts - 1) / parts;
    std::mutex mutex;
    parallel_chunks(static_cast<std::int64_t>(num_triangles), grain, "", execution,
                    [&](std::int64_t begin, std::int64_t end) {
                      std::vector<std::int64_t> own(n, 0);
                      add(static_cast<std::size_t>(begin), static_cast<std::size_t>(end), own);
                      const std::lock_guard lock(mutex);
                      for (std::size_t i = 0; i < n; ++i) tree.area_of_node[i] += own[i];
                    });
  } else {
    add(0, num_triangles, tree.area_of_node);
  }
  for (std::size_t i = 0; i < n; ++i) {
    const std::int32_t parent = tree.parent_of_node[i];
    if (parent >= 0) tree.area_of_node[static_cast<std::size_t>(parent)] += tree.area_of_node[i];
  }
}

/// Tells every triangle its node.
void give_triangles_nodes(const Flooded& flooded, std::size_t num_triangles, ComponentTree& tree,
                          const Execution& execution) {
  reserve_on_large_pages(tree.node_of_triangle, num_triangles);
  tree.node_of_triangle.assign(num_triangles, -1);
  // Chunks of the queue would not know their nodes; chunks of nodes do, and begin where about as many triangles are.
  std::vector<std::int32_t> first_node_of_chunk;
  std::int64_t size = kTrianglesPerChunk;
  const auto n = static_cast<std::int32_t>(tree.num_nodes());
  for (std::int32_t node = 0; node < n; ++node) {
    const auto i = static_cast<std::size_t>(node);
    if (size >= kTrianglesPerChunk) {
      first_node_of_chunk.push_back(node);
      size = 0;
    }
    size += flooded.end_of_node[i] - flooded.first_of_node[i];
  }
  first_node_of_chunk.push_back(n);
  const std::int32_t* const queue = flooded.queue.get();
  std::int32_t* const node_of = tree.node_of_triangle.data();
  parallel_chunks(static_cast<std::int64_t>(first_node_of_chunk.size()) - 1, 1, "", execution,
                  [&](std::int64_t chunk, std::int64_t) {
                    const auto c = static_cast<std::size_t>(chunk);
                    for (std::int32_t node = first_node_of_chunk[c]; node < first_node_of_chunk[c + 1]; ++node) {
                      const std::int32_t end = flooded.end_of_node[static_cast<std::size_t>(node)];
                      for (std::int32_t i = flooded.first_of_node[static_cast<std::size_t>(node)]; i < end; ++i)
                        node_of[queue[i]] = node;
                    }
                  });
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
  const Flooded flooded = Flood(twins, level_of_triangle, num_levels, tree, execution).run(execution);
  give_triangles_nodes(flooded, n, tree, execution);
  sum_areas(areas, flooded, tree, execution);
  return tree;
}

std::vector<std::int32_t> rebuild_levels(const ComponentTree& tree) {
  std::vector<std::int32_t> levels(tree.node_of_triangle.size(), 0);
  for (std::size_t t = 0; t < levels.size(); ++t)
    if (tree.node_of_triangle[t] >= 0) levels[t] = tree.hi_of_node[static_cast<std::size_t>(tree.node_of_triangle[t])];
  return levels;
}

}  // namespace meshmser
