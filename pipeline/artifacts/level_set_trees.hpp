#pragma once
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace meshmser {

/// Upper: components of {S >= h}. Lower: the same of -S. Shapes, of trees alone: components of {S >= h} and of {S < h} in
/// one tree, their holes filled.
enum class Polarity : std::uint8_t { kUpper, kLower, kShapes };

/// As tables and options spell it.
inline const char* name_of(Polarity polarity) {
  return polarity == Polarity::kUpper ? "upper" : polarity == Polarity::kLower ? "lower" : "shapes";
}

/// The component tree of a mesh's triangles for one polarity, or their tree of shapes (definitions 6). Nodes are in
/// topological order, children before parents (postorder of the flood), so that the nodes of a subtree, and `triangles`
/// of a subtree, are intervals. Nodes count levels from 1: those of the scalar, but in a tree of shapes level lines up
/// from the root, whose level is 1. What a node's line is in S, `line`, `value`, `side` and `is_at` tell for any tree.
struct ComponentTree {
  Polarity polarity = Polarity::kUpper;
  std::vector<double> levels;                    ///< h_1 < ... < h_n of the signed scalar (-S for the lower tree)
  std::vector<std::int32_t> parent_of_node;      ///< #N; -1 for a root
  std::vector<std::int32_t> hi_of_node;          ///< #N: the greatest level at which the node is a component
  std::vector<std::int64_t> area_of_node;        ///< #N: exact area in units of 2^-area_exponent of its root
  std::vector<std::int32_t> area_exponent_of_node;  ///< #N
  std::vector<std::int32_t> first_node_of_subtree;  ///< #N: the subtree of n is first_node_of_subtree[n] .. n
  std::vector<std::int32_t> node_of_triangle;    ///< #F; -1: excluded or below h_1
  std::vector<Polarity> side_of_node;            ///< shapes: #N: see side(); else empty
  std::vector<std::int32_t> own_level_of_node;   ///< shapes: #N: see own_level(); else empty

  std::size_t num_nodes() const { return parent_of_node.size(); }
  /// Least level at which the node is a component.
  std::int32_t lo(std::int32_t node) const {
    const std::int32_t parent = parent_of_node[static_cast<std::size_t>(node)];
    return parent < 0 ? 1 : hi_of_node[static_cast<std::size_t>(parent)] + 1;
  }
  /// Whether regions of a side, upper or lower, are nodes of this tree.
  bool has_side(Polarity side) const { return polarity == side || polarity == Polarity::kShapes; }
  /// Upper: S >= value() within the node's line; lower: S <= value(), of a shape S < value(). Upper of a root of shapes.
  Polarity side(std::int32_t node) const {
    return side_of_node.empty() ? polarity : side_of_node[static_cast<std::size_t>(node)];
  }
  /// 1 where S rises into the node, -1 where it falls.
  double sign(std::int32_t node) const { return side(node) == Polarity::kLower ? -1 : 1; }
  /// The level of S (of -S in a lower tree) of the triangles that are the node's own: number of `levels`, 0 below all.
  std::int32_t own_level(std::int32_t node) const {
    return own_level_of_node.empty() ? hi_of_node[static_cast<std::size_t>(node)]
                                     : own_level_of_node[static_cast<std::size_t>(node)];
  }
  /// The number, in `levels`, of the level whose line bounds the node; 0 for a root of shapes, which has none.
  std::int32_t line(std::int32_t node) const {
    if (polarity != Polarity::kShapes) return lo(node);
    if (parent_of_node[static_cast<std::size_t>(node)] < 0) return 0;
    // All lines of one node go one way.
    const std::int32_t more = hi_of_node[static_cast<std::size_t>(node)] - lo(node);
    return side(node) == Polarity::kUpper ? own_level(node) - more : own_level(node) + 1 + more;
  }
  /// h of a number of `levels`, as a value of S (not of -S); 0: of what lies below all.
  double value_of_level(std::int32_t level) const {
    const double h = level > 0 ? levels[static_cast<std::size_t>(level) - 1] : -std::numeric_limits<double>::infinity();
    return polarity == Polarity::kLower ? -h : h;
  }
  /// S on the node's line; where there is none, minus infinity.
  double value(std::int32_t node) const { return value_of_level(line(node)); }
  /// Whether the node is a component of the level set of a number of `levels`: of a shape, with its holes filled.
  bool is_at(std::int32_t node, std::int32_t level) const {
    if (side(node) == Polarity::kLower && polarity == Polarity::kShapes)
      return own_level(node) < level && level <= line(node);
    return line(node) > 0 && line(node) <= level && level <= own_level(node);
  }

  template <class Self, class Visitor>
  static void visit(Self& self, Visitor&& field) {
    field("polarity", self.polarity);
    field("levels", self.levels);
    field("parent_of_node", self.parent_of_node);
    field("hi_of_node", self.hi_of_node);
    field("area_of_node", self.area_of_node);
    field("area_exponent_of_node", self.area_exponent_of_node);
    field("first_node_of_subtree", self.first_node_of_subtree);
    field("node_of_triangle", self.node_of_triangle);
    field("side_of_node", self.side_of_node);
    field("own_level_of_node", self.own_level_of_node);
  }
};

/// What the tree stage makes of a mesh and a scalar on it.
struct LevelSetTrees {
  std::string scalar;                          ///< its name in the config
  std::string unit;                            ///< of the scalar
  double noise = std::numeric_limits<double>::quiet_NaN();  ///< sigma_S of definitions 5; NaN: unknown
  std::vector<double> values;                  ///< #V: S after detrending and transform
  std::vector<std::uint8_t> excluded_of_triangle;  ///< #F: 1: left the mesh before anything else
  std::vector<ComponentTree> trees;            ///< one per polarity asked for, or one of shapes

  template <class Self, class Visitor>
  static void visit(Self& self, Visitor&& field) {
    field("scalar", self.scalar);
    field("unit", self.unit);
    field("noise", self.noise);
    field("values", self.values);
    field("excluded_of_triangle", self.excluded_of_triangle);
    field("trees", self.trees);
  }
};

}  // namespace meshmser
