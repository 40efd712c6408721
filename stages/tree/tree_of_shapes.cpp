#include "stages/tree/tree_of_shapes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "pipeline/execution/error.hpp"
#include "stages/common/adjacency.hpp"
#include "stages/tree/component_tree.hpp"

namespace meshmser {
namespace {

using Ids = std::vector<std::int32_t>;

std::size_t at(std::int32_t id) {
  return static_cast<std::size_t>(id);
}

/// A graph in one array: the neighbours of v are targets[first[v]] .. targets[first[v + 1]].
struct Graph {
  std::vector<std::int64_t> first;
  Ids targets;

  std::span<const std::int32_t> neighbours(std::int32_t v) const {
    return std::span(targets).subspan(static_cast<std::size_t>(first[at(v)]),
                                      static_cast<std::size_t>(first[at(v) + 1] - first[at(v)]));
  }
  std::size_t size() const { return first.size() - 1; }
};

/// From directed edges, each given by every call of `each(edge)` with a function edge(from, to).
template <class EachEdge>
Graph make_graph(std::size_t num_vertices, EachEdge each) {
  Graph graph;
  graph.first.assign(num_vertices + 1, 0);
  each([&](std::int32_t from, std::int32_t) { ++graph.first[at(from) + 1]; });
  std::partial_sum(graph.first.begin(), graph.first.end(), graph.first.begin());
  graph.targets.resize(static_cast<std::size_t>(graph.first.back()));
  std::vector<std::int64_t> next(graph.first.begin(), graph.first.end() - 1);
  each([&](std::int32_t from, std::int32_t to) { graph.targets[static_cast<std::size_t>(next[at(from)]++)] = to; });
  return graph;
}

/// The mesh as triangulated spheres: a vertex for each fan of triangles, then one for each rim, which closes it.
struct Spheres {
  Ids vertex_of_corner;            ///< 3 #F; -1: excluded
  Ids mesh_vertex;                 ///< of each; -1 of a closing vertex
  Ids level;                       ///< of each
  std::vector<double> weight;      ///< of each: its share of the area
  std::vector<double> rim_length;  ///< of each closing vertex
  std::size_t first_closing = 0;   ///< the number of fans
  Graph edges;

  std::size_t size() const { return mesh_vertex.size(); }
};

class SphereMaker {
 public:
  SphereMaker(const SurfaceView& surface, std::span<const double> areas, std::span<const std::int32_t> level_of_vertex,
              std::span<const std::uint8_t> excluded)
      : surface_(surface), areas_(areas), level_of_vertex_(level_of_vertex), excluded_(excluded) {}

  Spheres make() {
    number_fans();
    close_rims();
    spheres_.edges = make_graph(spheres_.size(), [&](auto edge) {
      for (std::size_t h = 0; h < spheres_.vertex_of_corner.size(); ++h) {
        if (spheres_.vertex_of_corner[h] < 0) continue;
        const std::int32_t from = start(h), to = start(at(next_half_edge(static_cast<std::int32_t>(h))));
        edge(from, to);
        if (surface_.twins[h] >= 0) continue;
        edge(to, from);
        edge(closing_[h], from);
        edge(from, closing_[h]);
      }
    });
    return std::move(spheres_);
  }

 private:
  std::int32_t start(std::size_t half_edge) const { return spheres_.vertex_of_corner[half_edge]; }
  bool is_excluded(std::size_t half_edge) const { return !excluded_.empty() && excluded_[half_edge / 3] != 0; }

  void number_fans() {
    const std::size_t num_corners = 3 * surface_.triangles.size();
    spheres_.vertex_of_corner.assign(num_corners, -1);
    for (std::size_t corner = 0; corner < num_corners; ++corner) {
      if (is_excluded(corner) || start(corner) >= 0) continue;
      const auto fan = static_cast<std::int32_t>(spheres_.mesh_vertex.size());
      const std::int32_t vertex = surface_.triangles[corner / 3][corner % 3];
      spheres_.mesh_vertex.push_back(vertex);
      spheres_.level.push_back(level_of_vertex_[at(vertex)]);
      spheres_.weight.push_back(0);
      const auto take = [&](std::int32_t h) {
        spheres_.vertex_of_corner[at(h)] = fan;
        spheres_.weight.back() += areas_[at(h) / 3] / 3;
      };
      // About the vertex to one side until the fan ends or closes, then to the other.
      auto h = static_cast<std::int32_t>(corner);
      do {
        take(h);
        h = surface_.twins[at(previous_half_edge(h))];
      } while (h >= 0 && h != static_cast<std::int32_t>(corner));
      if (h >= 0) continue;
      for (h = surface_.twins[corner]; h >= 0; h = surface_.twins[at(h)]) {
        h = next_half_edge(h);
        take(h);
      }
    }
    spheres_.first_closing = spheres_.mesh_vertex.size();
  }

  void close_rims() {
    closing_.assign(surface_.twins.size(), -1);
    Ids levels;
    for (std::size_t first = 0; first < closing_.size(); ++first) {
      if (start(first) < 0 || surface_.twins[first] >= 0 || closing_[first] >= 0) continue;
      const auto closing = static_cast<std::int32_t>(spheres_.mesh_vertex.size());
      levels.clear();
      double length = 0;
      auto h = static_cast<std::int32_t>(first);
      do {
        closing_[at(h)] = closing;
        levels.push_back(spheres_.level[at(start(at(h)))]);
        const auto position = [&](std::int32_t half_edge) {
          return surface_.positions[at(surface_.triangles[at(half_edge) / 3][at(half_edge) % 3])];
        };
        length += (position(next_half_edge(h)) - position(h)).norm();
        h = next_half_edge(h);
        while (surface_.twins[at(h)] >= 0) h = next_half_edge(surface_.twins[at(h)]);
      } while (h != static_cast<std::int32_t>(first));
      const auto median = levels.begin() + static_cast<std::ptrdiff_t>((levels.size() - 1) / 2);
      std::nth_element(levels.begin(), median, levels.end());
      spheres_.mesh_vertex.push_back(-1);
      spheres_.level.push_back(*median);
      spheres_.weight.push_back(0);
      spheres_.rim_length.push_back(length);
    }
  }

  SurfaceView surface_;
  std::span<const double> areas_;
  std::span<const std::int32_t> level_of_vertex_;
  std::span<const std::uint8_t> excluded_;
  Ids closing_;  ///< of each half-edge of a rim the vertex that closes it; else -1
  Spheres spheres_;
};

/// A forest of vertices from which vertices of one child at most are taken out; what hangs on them is tied together.
class ShrinkingForest {
 public:
  explicit ShrinkingForest(std::size_t size) : parent_(size, -1), num_children_(size, 0), children_(size, 0) {}

  void set_parent(std::int32_t child, std::int32_t parent) {
    parent_[at(child)] = parent;
    ++num_children_[at(parent)];
    children_[at(parent)] ^= child;
  }
  std::int32_t parent(std::int32_t v) const { return parent_[at(v)]; }
  std::int32_t num_children(std::int32_t v) const { return num_children_[at(v)]; }
  void take_out(std::int32_t v) {
    const std::int32_t parent = parent_[at(v)];
    if (num_children_[at(v)] == 1) {
      const std::int32_t child = children_[at(v)];
      parent_[at(child)] = parent;
      if (parent >= 0) children_[at(parent)] ^= v ^ child;
    } else if (parent >= 0) {
      --num_children_[at(parent)];
      children_[at(parent)] ^= v;
    }
  }

 private:
  Ids parent_, num_children_;
  Ids children_;  ///< the exclusive or of all: the only one where there is one
};

/// The merge tree of a sweep: each vertex in `order` takes the components it touches among those before it; the last
/// vertex of each gets it as its parent (Carr, Snoeyink, Axen 2003, 4.1).
ShrinkingForest sweep(const Graph& edges, std::span<const std::int32_t> order, std::span<const std::int32_t> rank,
                      bool descending) {
  ShrinkingForest forest(order.size());
  Ids component(order.size()), last(order.size());
  std::iota(component.begin(), component.end(), 0);
  const auto find = [&](std::int32_t v) {
    while (component[at(v)] != v) v = component[at(v)] = component[at(component[at(v)])];
    return v;
  };
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::int32_t v = order[descending ? order.size() - 1 - i : i];
    last[at(v)] = v;
    for (const std::int32_t w : edges.neighbours(v)) {
      if (w == v || (rank[at(w)] > rank[at(v)]) != descending) continue;
      const std::int32_t other = find(w), own = find(v);
      if (other == own) continue;
      forest.set_parent(last[at(other)], v);
      component[at(other)] = own;
      last[at(own)] = v;
    }
  }
  return forest;
}

/// The contour trees of the spheres: how vertices follow each other along level lines' sides. A forest of V - (number
/// of spheres) arcs, both ways (Carr, Snoeyink, Axen 2003, 4.2).
Graph contour_trees(const Spheres& spheres, const Execution& execution) {
  const std::size_t n = spheres.size();
  Ids order(n), rank(n);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::int32_t a, std::int32_t b) { return spheres.level[at(a)] < spheres.level[at(b)]; });
  for (std::size_t i = 0; i < n; ++i) rank[at(order[i])] = static_cast<std::int32_t>(i);
  execution.check();
  ShrinkingForest join = sweep(spheres.edges, order, rank, true);
  execution.check();
  ShrinkingForest split = sweep(spheres.edges, order, rank, false);
  execution.check();

  std::vector<std::array<std::int32_t, 2>> arcs;
  arcs.reserve(n);
  std::vector<std::uint8_t> gone(n, 0);
  const auto is_leaf = [&](std::int32_t v) { return join.num_children(v) + split.num_children(v) == 1; };
  Ids leaves;
  for (std::int32_t v = 0; v < static_cast<std::int32_t>(n); ++v)
    if (is_leaf(v)) leaves.push_back(v);
  while (!leaves.empty()) {
    const std::int32_t v = leaves.back();
    leaves.pop_back();
    if (gone[at(v)] != 0 || !is_leaf(v)) continue;
    const std::int32_t w = join.num_children(v) == 0 ? join.parent(v) : split.parent(v);
    arcs.push_back({v, w});
    join.take_out(v);
    split.take_out(v);
    gone[at(v)] = 1;
    if (is_leaf(w)) leaves.push_back(w);
  }
  return make_graph(n, [&](auto edge) {
    for (const auto& [v, w] : arcs) {
      edge(v, w);
      edge(w, v);
    }
  });
}

/// The contour trees hung up at their roots.
struct Rooted {
  Ids parent;      ///< a root is its own
  Ids depth;       ///< arcs up to the root
  Ids jump;        ///< an ancestor far up, by depth alone (Myers 1983); a root is its own
  Ids thresholds;  ///< 1 + level lines up to the root
  Ids root;        ///< of each vertex
  Ids order;       ///< parents first

  std::int32_t common_ancestor(std::int32_t a, std::int32_t b) const {
    if (depth[at(a)] < depth[at(b)]) std::swap(a, b);
    while (depth[at(a)] > depth[at(b)]) a = depth[at(jump[at(a)])] >= depth[at(b)] ? jump[at(a)] : parent[at(a)];
    while (a != b) {
      const bool far = jump[at(a)] != jump[at(b)];
      a = far ? jump[at(a)] : parent[at(a)];
      b = far ? jump[at(b)] : parent[at(b)];
    }
    return a;
  }
  /// The last vertex on the way up that lies within at least that many thresholds.
  std::int32_t top_within(std::int32_t v, std::int32_t at_least) const {
    while (thresholds[at(parent[at(v)])] >= at_least && parent[at(v)] != v)
      v = thresholds[at(jump[at(v)])] >= at_least ? jump[at(v)] : parent[at(v)];
    return v;
  }
};

class Rooting {
 public:
  Rooting(const Spheres& spheres, const Graph& arcs, std::int32_t root_vertex)
      : spheres_(spheres), arcs_(arcs), root_vertex_(root_vertex) {}

  Rooted run() {
    const std::size_t n = spheres_.size();
    for (Ids* ids : {&rooted_.parent, &rooted_.depth, &rooted_.jump, &rooted_.thresholds, &rooted_.root})
      ids->assign(n, -1);
    rooted_.order.reserve(n);
    for (std::int32_t v = 0; v < static_cast<std::int32_t>(n); ++v)
      if (rooted_.root[at(v)] < 0) {
        const std::size_t begin = rooted_.order.size();
        hang_up(v);
        const std::int32_t root = choose_root(begin);
        rooted_.order.resize(begin);
        hang_up(root);
      }
    return std::move(rooted_);
  }

 private:
  void hang_up(std::int32_t root) {
    const std::size_t begin = rooted_.order.size();
    rooted_.parent[at(root)] = rooted_.jump[at(root)] = root;
    rooted_.depth[at(root)] = 0;
    rooted_.thresholds[at(root)] = 1;
    rooted_.order.push_back(root);
    for (std::size_t i = begin; i < rooted_.order.size(); ++i) {
      const std::int32_t v = rooted_.order[i];
      rooted_.root[at(v)] = root;
      const std::int32_t far = rooted_.jump[at(v)], farther = rooted_.jump[at(far)];
      const bool even =
          rooted_.depth[at(v)] - rooted_.depth[at(far)] == rooted_.depth[at(far)] - rooted_.depth[at(farther)];
      for (const std::int32_t w : arcs_.neighbours(v)) {
        if (w == rooted_.parent[at(v)]) continue;
        rooted_.parent[at(w)] = v;
        rooted_.depth[at(w)] = rooted_.depth[at(v)] + 1;
        rooted_.jump[at(w)] = even ? farther : v;
        const std::int32_t lines = std::abs(spheres_.level[at(w)] - spheres_.level[at(v)]);
        if (rooted_.thresholds[at(v)] > kMostThresholds - lines)
          throw StageError("a shape lies within more than " + std::to_string(kMostThresholds) +
                           " level lines; use fewer levels");
        rooted_.thresholds[at(w)] = rooted_.thresholds[at(v)] + lines;
        rooted_.order.push_back(w);
      }
    }
  }

  /// Of the component in `order` from `begin` on, which has been hung up somewhere.
  std::int32_t choose_root(std::size_t begin) {
    const std::span<const std::int32_t> component = std::span(rooted_.order).subspan(begin);
    std::int32_t longest = -1, given = -1;
    for (const std::int32_t v : component) {
      if (at(v) >= spheres_.first_closing) {
        const auto length = [&](std::int32_t of) { return spheres_.rim_length[at(of) - spheres_.first_closing]; };
        if (longest < 0 || length(v) > length(longest) || (length(v) == length(longest) && v < longest)) longest = v;
      } else if (root_vertex_ >= 0 && spheres_.mesh_vertex[at(v)] == root_vertex_ && (given < 0 || v < given)) {
        given = v;
      }
    }
    if (given >= 0) return given;
    if (longest >= 0) return longest;
    // The centroid: down from the root into any subtree of more than half.
    std::vector<double>& below = weight_below_;
    below.resize(spheres_.size());
    for (const std::int32_t v : component) below[at(v)] = spheres_.weight[at(v)];
    for (std::size_t i = component.size(); i-- > 1;)
      below[at(rooted_.parent[at(component[i])])] += below[at(component[i])];
    const double half = below[at(component[0])] / 2;
    std::int32_t root = component[0];
    for (const std::int32_t v : component.subspan(1))
      if (rooted_.parent[at(v)] == root && below[at(v)] > half) root = v;
    return root;
  }

  static constexpr std::int32_t kMostThresholds = 100'000'000;
  const Spheres& spheres_;
  const Graph& arcs_;
  std::int32_t root_vertex_;
  Rooted rooted_;
  std::vector<double> weight_below_;
};

/// Throws for a component that is no sphere once its rims are closed.
void check_genus(const SurfaceView& surface, const Spheres& spheres, const Rooted& rooted) {
  // Twice vertices - edges + faces of each component, at its root; closing a rim of n edges adds n edges and n faces.
  std::vector<std::int64_t> euler(spheres.size(), 0);
  for (std::size_t v = 0; v < spheres.size(); ++v) euler[at(rooted.root[v])] += 2;
  for (std::size_t h = 0; h < spheres.vertex_of_corner.size(); ++h)
    if (spheres.vertex_of_corner[h] >= 0)
      // A half-edge: half an edge, or a whole one at a rim, and a third of a face.
      euler[at(rooted.root[at(spheres.vertex_of_corner[h])])] -= surface.twins[h] < 0 ? 2 : 1;
  for (std::size_t t = 0; 3 * t < spheres.vertex_of_corner.size(); ++t)
    if (spheres.vertex_of_corner[3 * t] >= 0) euler[at(rooted.root[at(spheres.vertex_of_corner[3 * t])])] += 2;
  for (std::size_t t = 0; 3 * t < spheres.vertex_of_corner.size(); ++t) {
    if (spheres.vertex_of_corner[3 * t] < 0) continue;
    const std::int64_t twice = euler[at(rooted.root[at(spheres.vertex_of_corner[3 * t])])];
    if (twice != 4)
      throw StageError("the tree of shapes needs a surface without handles, but the component of triangle " +
                       std::to_string(t) + " has " + std::to_string((4 - twice) / 4) +
                       ": on it a closed line need not part the inside from the outside; cut the handles open, or "
                       "build an upper and a lower tree (polarity: both)");
  }
}

/// Whether every node lies above or below its line, and the level of its own triangles.
void tell_lines(const Ids& vertex_of_triangle, const Rooted& rooted, const Ids& level, ComponentTree& tree) {
  tree.side_of_node.assign(tree.num_nodes(), Polarity::kUpper);
  tree.own_level_of_node.assign(tree.num_nodes(), 0);
  Ids vertex_of_node(tree.num_nodes(), -1);
  for (std::size_t t = 0; t < tree.node_of_triangle.size(); ++t)
    if (tree.node_of_triangle[t] >= 0) vertex_of_node[at(tree.node_of_triangle[t])] = vertex_of_triangle[t];
  for (std::size_t n = 0; n < tree.num_nodes(); ++n) {
    tree.own_level_of_node[n] = level[at(vertex_of_node[n])];
    if (tree.parent_of_node[n] < 0) continue;
    const std::int32_t inside = rooted.top_within(vertex_of_node[n], tree.lo(static_cast<std::int32_t>(n)));
    if (level[at(inside)] < level[at(rooted.parent[at(inside)])]) tree.side_of_node[n] = Polarity::kLower;
  }
}

}  // namespace

ComponentTree build_tree_of_shapes(const SurfaceView& surface, std::span<const double> areas,
                                   std::span<const std::int32_t> level_of_vertex, std::span<const double> levels,
                                   std::span<const std::uint8_t> excluded, std::int32_t root_vertex,
                                   const Execution& execution) {
  const std::size_t num_triangles = surface.triangles.size();
  if (surface.twins.size() != 3 * num_triangles || areas.size() != num_triangles ||
      level_of_vertex.size() != surface.positions.size() || (!excluded.empty() && excluded.size() != num_triangles))
    throw StageError("a tree of shapes needs one area a triangle, one twin a half-edge and one level a vertex");
  const Spheres spheres = SphereMaker(surface, areas, level_of_vertex, excluded).make();
  const Rooted rooted = Rooting(spheres, contour_trees(spheres, execution), root_vertex).run();
  check_genus(surface, spheres, rooted);
  execution.check();

  // The smallest shape that holds all three corners.
  Ids vertex_of_triangle(num_triangles, -1), thresholds(num_triangles, 0);
  std::int32_t most = 1;
  for (std::size_t t = 0; t < num_triangles; ++t) {
    const std::int32_t* corners = &spheres.vertex_of_corner[3 * t];
    if (corners[0] < 0) continue;
    vertex_of_triangle[t] = rooted.common_ancestor(rooted.common_ancestor(corners[0], corners[1]), corners[2]);
    thresholds[t] = rooted.thresholds[at(vertex_of_triangle[t])];
    most = std::max(most, thresholds[t]);
  }
  ComponentTree tree = build_component_tree(surface.twins, areas, thresholds, most, execution);
  tree.polarity = Polarity::kShapes;
  tree.levels.assign(levels.begin(), levels.end());
  tell_lines(vertex_of_triangle, rooted, spheres.level, tree);
  return tree;
}

}  // namespace meshmser
