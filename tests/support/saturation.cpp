#include "tests/support/saturation.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <utility>

namespace meshmser::oracle {
namespace {

using Set = std::set<int>;

std::size_t at(int id) {
  return static_cast<std::size_t>(id);
}
int next_of(int half_edge) {
  return half_edge % 3 == 2 ? half_edge - 2 : half_edge + 1;
}

/// Classes of 0 .. n - 1 joined by pairs.
std::vector<int> classes(int n, const std::set<std::pair<int, int>>& pairs) {
  std::vector<int> of(at(n));
  std::iota(of.begin(), of.end(), 0);
  for (bool changed = true; changed;) {
    changed = false;
    for (const auto& [a, b] : pairs) {
      int &x = of[at(a)], &y = of[at(b)];
      if (x == y) continue;
      x = y = std::min(x, y);
      changed = true;
    }
  }
  return of;
}

Set without(const Set& all, const Set& some) {
  Set left;
  std::set_difference(all.begin(), all.end(), some.begin(), some.end(), std::inserter(left, left.end()));
  return left;
}

struct Shape {
  Set nodes;
  int threshold = 0;
  bool bright = false;
};

/// The mesh as spheres: a node for each class of corners that meet in edges, then one for each class of rim half-edges
/// that meet in nodes.
class Spheres {
 public:
  explicit Spheres(const ShapesCase& of) : of_(of), node_of_corner_(of.twins.size(), -1) {
    number_corners();
    join_corners();
    close_rims();
    std::set<std::pair<int, int>> edges;
    for (const auto& [a, all] : neighbours_)
      for (const int b : all) edges.insert({a, b});
    component_ = classes(static_cast<int>(level_.size()), edges);
  }

  std::map<int, Set> components() const {
    std::map<int, Set> of;
    for (std::size_t v = 0; v < component_.size(); ++v) of[component_[v]].insert(static_cast<int>(v));
    return of;
  }
  int level(int node) const { return level_[at(node)]; }

  /// Vertices - edges + faces of every component, where a rim of n edges is closed by n edges and n faces.
  bool are_spheres() const {
    std::map<int, int> twice;
    for (const int component : component_) twice[component] += 2;
    for (std::size_t t = 0; t < of_.triangles.size(); ++t) {
      if (of_.excluded[t] != 0) continue;
      int& sum = twice[component_[at(node_of_corner_[3 * t])]];
      sum += 2;
      for (std::size_t k = 0; k < 3; ++k) sum -= of_.twins[3 * t + k] < 0 ? 2 : 1;
    }
    return std::all_of(twice.begin(), twice.end(), [](const auto& of) { return of.second == 4; });
  }

  /// Every shape of one component, a shape of several thresholds as often.
  std::vector<Shape> shapes(const Set& component, int root) const {
    std::vector<Shape> shapes;
    for (int k = 1; k <= of_.num_levels; ++k)
      for (const bool bright : {true, false}) {
        Set side;
        for (const int v : component)
          if ((level(v) >= k) == bright) side.insert(v);
        for (const Set& part : parts_of(side)) {
          if (part.contains(root)) continue;
          Shape shape{part, k, bright};
          for (const Set& rest : parts_of(without(component, part)))
            if (!rest.contains(root)) shape.nodes.insert(rest.begin(), rest.end());
          shapes.push_back(shape);
        }
      }
    return shapes;
  }

  /// The triangles whose corners all lie in the set.
  Set triangles_in(const Set& nodes) const {
    Set triangles;
    for (int t = 0; at(t) < of_.triangles.size(); ++t)
      if (nodes.contains(node_of_corner_[at(3 * t)]) && nodes.contains(node_of_corner_[at(3 * t + 1)]) &&
          nodes.contains(node_of_corner_[at(3 * t + 2)]))
        triangles.insert(t);
    return triangles;
  }

  std::vector<Set> edge_parts(const Set& triangles) const {
    std::set<std::pair<int, int>> pairs;
    for (std::size_t h = 0; h < of_.twins.size(); ++h)
      if (of_.twins[h] >= 0 && triangles.contains(static_cast<int>(h / 3)) && triangles.contains(of_.twins[h] / 3))
        pairs.insert({static_cast<int>(h / 3), of_.twins[h] / 3});
    const std::vector<int> of = classes(static_cast<int>(of_.triangles.size()), pairs);
    std::map<int, Set> parts;
    for (const int t : triangles) parts[of[at(t)]].insert(t);
    std::vector<Set> result;
    for (auto& [first, part] : parts) result.push_back(part);
    return result;
  }

  /// The roots that the definition leaves open; for a component without rim and without the user's vertex all nodes.
  std::vector<int> possible_roots(const Set& component) const {
    std::vector<int> roots;
    for (const int v : component)
      if (of_.root_vertex >= 0 && mesh_vertex_[at(v)] == of_.root_vertex) return {v};
    double longest = -1;
    for (const int v : component)
      if (rim_length_.contains(v)) longest = std::max(longest, rim_length_.at(v));
    for (const int v : component)
      if (longest < 0 || (rim_length_.contains(v) && rim_length_.at(v) > longest - 1e-9)) roots.push_back(v);
    return roots;
  }

  double weight_of(const Set& nodes) const {
    double weight = 0;
    for (std::size_t c = 0; c < node_of_corner_.size(); ++c)
      if (nodes.contains(node_of_corner_[c])) weight += of_.areas[c / 3] / 3;
    return weight;
  }

 private:
  int node(int half_edge) const { return node_of_corner_[at(half_edge)]; }

  void number_corners() {
    const int corners = static_cast<int>(of_.twins.size());
    std::set<std::pair<int, int>> same;
    for (int h = 0; h < corners; ++h) {
      const int twin = of_.twins[at(h)];
      if (twin < 0) continue;
      same.insert({h, next_of(twin)});
      same.insert({next_of(h), twin});
    }
    const std::vector<int> of_corner = classes(corners, same);
    std::map<int, int> number;
    for (int c = 0; c < corners; ++c) {
      if (of_.excluded[at(c / 3)] != 0) continue;
      const auto [found, is_new] = number.insert({of_corner[at(c)], static_cast<int>(level_.size())});
      node_of_corner_[at(c)] = found->second;
      if (!is_new) continue;
      const std::int32_t vertex = of_.triangles[at(c / 3)][at(c % 3)];
      level_.push_back(of_.level_of_vertex[at(vertex)]);
      mesh_vertex_.push_back(vertex);
    }
  }

  void join_corners() {
    for (int h = 0; at(h) < of_.twins.size(); ++h) {
      if (node(h) < 0) continue;
      neighbours_[node(h)].insert(node(next_of(h)));
      neighbours_[node(next_of(h))].insert(node(h));
      if (of_.twins[at(h)] < 0) rim_.push_back(h);
    }
  }

  void close_rims() {
    std::set<std::pair<int, int>> meet;
    for (std::size_t i = 0; i < rim_.size(); ++i)
      for (std::size_t j = 0; j < rim_.size(); ++j)
        if (node(next_of(rim_[i])) == node(rim_[j])) meet.insert({static_cast<int>(i), static_cast<int>(j)});
    const std::vector<int> loop_of = classes(static_cast<int>(rim_.size()), meet);
    std::map<int, std::vector<int>> loops;
    for (std::size_t i = 0; i < rim_.size(); ++i) loops[loop_of[i]].push_back(rim_[i]);
    for (const auto& [first, loop] : loops) {
      const int closing = static_cast<int>(level_.size());
      std::vector<int> levels;
      for (const int h : loop) {
        levels.push_back(level(node(h)));
        neighbours_[closing].insert(node(h));
        neighbours_[node(h)].insert(closing);
        const auto position = [&](int half_edge) {
          return of_.positions[at(of_.triangles[at(half_edge / 3)][at(half_edge % 3)])];
        };
        rim_length_[closing] += (position(next_of(h)) - position(h)).norm();
      }
      std::sort(levels.begin(), levels.end());
      level_.push_back(levels[(levels.size() - 1) / 2]);
      mesh_vertex_.push_back(-1);
    }
  }

  std::vector<Set> parts_of(Set members) const {
    std::vector<Set> parts;
    while (!members.empty()) {
      Set part = {*members.begin()}, front = part;
      while (!front.empty()) {
        Set next;
        for (const int v : front)
          for (const int w : neighbours_.at(v))
            if (members.contains(w) && !part.contains(w)) next.insert(w);
        part.insert(next.begin(), next.end());
        front = next;
      }
      for (const int v : part) members.erase(v);
      parts.push_back(part);
    }
    return parts;
  }

  const ShapesCase& of_;
  std::vector<int> node_of_corner_;  ///< -1: excluded
  std::vector<int> level_, mesh_vertex_;
  std::vector<int> rim_;              ///< half-edges
  std::map<int, double> rim_length_;  ///< of the closing nodes
  std::map<int, Set> neighbours_;
  std::vector<int> component_;
};

std::vector<Set> sets_of(const ComponentTree& tree) {
  std::vector<Set> sets(tree.num_nodes());
  for (std::size_t t = 0; t < tree.node_of_triangle.size(); ++t)
    for (std::int32_t n = tree.node_of_triangle[t]; n >= 0; n = tree.parent_of_node[at(n)])
      sets[at(n)].insert(static_cast<int>(t));
  return sets;
}

bool are_nested(const std::vector<Shape>& shapes) {
  for (const Shape& a : shapes)
    for (const Shape& b : shapes) {
      const std::size_t common = a.nodes.size() - without(a.nodes, b.nodes).size();
      if (common != 0 && common != a.nodes.size() && common != b.nodes.size()) return false;
    }
  return true;
}

/// The tree on one component against saturation about one root.
class Comparison {
 public:
  Comparison(const Spheres& spheres, const Set& component, int root, const ComponentTree& tree,
             const std::vector<Set>& sets)
      : spheres_(spheres),
        root_(root),
        tree_(tree),
        sets_(sets),
        all_(spheres.triangles_in(component)),
        shapes_(spheres.shapes(component, root)) {
    for (const Shape& shape : shapes_) {
      triangles_.push_back(spheres_.triangles_in(shape.nodes));
      parts_.push_back(spheres_.edge_parts(triangles_.back()));
    }
  }

  const std::vector<Shape>& shapes() const { return shapes_; }
  const Set& all() const { return all_; }
  int lines(int t) const {
    int count = 1;
    for (const Set& triangles : triangles_) count += triangles.contains(t);
    return count;
  }

  std::string broken() const {
    std::set<Set> expected, found;
    for (const Set& part : spheres_.edge_parts(all_)) expected.insert(part);
    for (const std::vector<Set>& parts : parts_) expected.insert(parts.begin(), parts.end());
    for (const Set& set : sets_)
      if (all_.contains(*set.begin())) found.insert(set);
    if (found != expected) return "other shapes";
    for (const int t : all_) {
      const std::int32_t node = tree_.node_of_triangle[at(t)];
      if (tree_.hi_of_node[at(node)] != lines(t)) return "another number of lines";
      if (tree_.own_level(node) != own_level(t)) return "another own level";
    }
    for (std::size_t n = 0; n < sets_.size(); ++n)
      if (all_.contains(*sets_[n].begin()) && tree_.parent_of_node[n] >= 0 && !has_its_lines(n)) return "other lines";
    return "";
  }

 private:
  /// The level where a triangle's smallest shape has no further line: the root's where there is none.
  int own_level(int t) const {
    std::size_t least = 0;
    int level = spheres_.level(root_);
    for (std::size_t s = 0; s < shapes_.size(); ++s) {
      if (!triangles_[s].contains(t)) continue;
      const std::size_t size = shapes_[s].nodes.size();
      const int within = shapes_[s].bright ? shapes_[s].threshold : shapes_[s].threshold - 1;
      if (least == 0 || size < least)
        level = within;
      else if (size == least)
        level = shapes_[s].bright ? std::max(level, within) : std::min(level, within);
      else
        continue;
      least = size;
    }
    return level;
  }

  /// The node is a component at the thresholds of the shapes that it is a part of, all on one side.
  bool has_its_lines(std::size_t n) const {
    const auto node = static_cast<std::int32_t>(n);
    Set thresholds, found;
    const bool bright = tree_.side(node) == Polarity::kUpper;
    for (std::size_t s = 0; s < shapes_.size(); ++s) {
      if (std::find(parts_[s].begin(), parts_[s].end(), sets_[n]) == parts_[s].end()) continue;
      if (shapes_[s].bright != bright) return false;
      thresholds.insert(shapes_[s].threshold);
    }
    for (int k = 0; at(k) <= tree_.levels.size(); ++k)
      if (tree_.is_at(node, k)) found.insert(k);
    // The line next to the outside: the lowest of a bright shape, the highest of a dark one.
    return found == thresholds && tree_.line(node) == (bright ? *thresholds.begin() : *thresholds.rbegin()) &&
           tree_.value(node) == tree_.levels[at(tree_.line(node)) - 1];
  }

  const Spheres& spheres_;
  int root_;
  const ComponentTree& tree_;
  const std::vector<Set>& sets_;
  Set all_;
  std::vector<Shape> shapes_;
  std::vector<Set> triangles_;           ///< of each shape
  std::vector<std::vector<Set>> parts_;  ///< of each shape
};

}  // namespace

bool has_no_handle(const ShapesCase& of) {
  return Spheres(of).are_spheres();
}

ShapesCheck check_shapes(const ShapesCase& of, const ComponentTree& tree) {
  const Spheres spheres(of);
  const std::vector<Set> sets = sets_of(tree);
  ShapesCheck check;
  check.lines.assign(of.triangles.size(), 0);
  for (std::size_t t = 0; t < of.triangles.size(); ++t)
    if ((tree.node_of_triangle[t] < 0) != (of.excluded[t] != 0)) check.broken = "other triangles are in no node";
  if (!check.broken.empty()) return check;
  for (const auto& [first, component] : spheres.components()) {
    const std::vector<int> roots = spheres.possible_roots(component);
    const bool closed = roots.size() == component.size() && roots.size() > 1;
    check.num_closed += closed;
    std::string broken = "no root leaves every shape half of the area at most";
    for (const int root : roots) {
      const Comparison comparison(spheres, component, root, tree, sets);
      if (!are_nested(comparison.shapes())) check.broken = "shapes that cross";
      const double half = spheres.weight_of(component) / 2;
      if (closed && std::any_of(comparison.shapes().begin(), comparison.shapes().end(),
                                [&](const Shape& shape) { return spheres.weight_of(shape.nodes) > half + 1e-9; }))
        continue;
      broken = comparison.broken();
      if (!broken.empty()) continue;
      for (const int t : comparison.all()) check.lines[at(t)] = comparison.lines(t);
      for (const Shape& shape : comparison.shapes())
        for (const int v : shape.nodes) check.num_filled += (spheres.level(v) >= shape.threshold) != shape.bright;
      break;
    }
    if (check.broken.empty()) check.broken = broken;
    if (!check.broken.empty()) return check;
  }
  return check;
}

}  // namespace meshmser::oracle
