#pragma once
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace meshmser {

/// Upper: components of {S >= h}. Lower: the same of -S.
enum class Polarity : std::uint8_t { kUpper, kLower };

/// The component tree of a mesh's triangles for one polarity (definitions 6). Nodes are in topological order, children
/// before parents (postorder of the flood), so that the nodes of a subtree, and `triangles` of a subtree, are intervals.
struct ComponentTree {
  Polarity polarity = Polarity::kUpper;
  std::vector<double> levels;                    ///< h_1 < ... < h_n of the signed scalar (-S for the lower tree); levels count from 1
  std::vector<std::int32_t> parent_of_node;      ///< #N; -1 for a root
  std::vector<std::int32_t> hi_of_node;          ///< #N: the greatest level at which the node is a component
  std::vector<std::int64_t> area_of_node;        ///< #N: exact area in units of 2^-area_exponent of its root
  std::vector<std::int32_t> area_exponent_of_node;  ///< #N
  std::vector<std::int32_t> first_node_of_subtree;  ///< #N: the subtree of n is first_node_of_subtree[n] .. n
  std::vector<std::int32_t> node_of_triangle;    ///< #F; -1: excluded or below h_1

  std::size_t num_nodes() const { return parent_of_node.size(); }
  /// Least level at which the node is a component.
  std::int32_t lo(std::int32_t node) const {
    const std::int32_t parent = parent_of_node[static_cast<std::size_t>(node)];
    return parent < 0 ? 1 : hi_of_node[static_cast<std::size_t>(parent)] + 1;
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
  }
};

/// What the tree stage makes of a mesh and a scalar on it.
struct LevelSetTrees {
  std::string scalar;                          ///< its name in the config
  std::string unit;                            ///< of the scalar
  double noise = std::numeric_limits<double>::quiet_NaN();  ///< sigma_S of definitions 5; NaN: unknown
  std::vector<double> values;                  ///< #V: S after detrending and transform
  std::vector<std::uint8_t> excluded_of_triangle;  ///< #F: 1: left the mesh before anything else
  std::vector<ComponentTree> trees;            ///< one per polarity asked for

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
