#pragma once
/// Component trees cut, simplified and read back as a scalar (definitions 6), on plain arrays.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/artifacts/level_set_trees.hpp"

namespace meshmser {

/// The greatest of a tree's `levels` not above a value of S (of -S for a lower tree); 0: the value is below all.
std::int32_t level_of_value(const ComponentTree& tree, double value);

/// The components of one level set.
struct TreeCut {
  std::vector<std::int32_t> nodes;                  ///< of each component, by decreasing area, ties by node
  std::vector<std::int32_t> component_of_triangle;  ///< #F: 1 + index in `nodes`, the smallest; 0: below the level
};

/// The components of {t : level(t) >= level}: each node with lo <= level <= hi is one. Of a tree of shapes those of
/// {S >= h} and of {S < h} that have no root, filled, so that one may lie in another. O(N log N + F).
TreeCut cut_tree(const ComponentTree& tree, std::int32_t level);

/// Marks (#N) the nodes of at least `min_area`, in coordinate units squared, and the roots. O(N).
std::vector<std::uint8_t> nodes_of_area(const ComponentTree& tree, double min_area);

/// Marks (#N) the nodes whose highest maximum lasts at least `min_persistence`, in units of S, and the roots; of a tree
/// of shapes also what holds a marked node. O(N + F).
std::vector<std::uint8_t> nodes_of_persistence(const ComponentTree& tree, double min_persistence);

/// The tree of what remains when every node that is not marked is razed to the level of its smallest marked ancestor:
/// its triangles become triangles of that ancestor. `keep` (#N): roots, and with a node all its ancestors; StageError
/// otherwise. The result is the component tree of the razed levels, nodes in the same order; areas stay. With
/// nodes_of_area this is the area opening (Vincent 1993), with nodes_of_persistence the removal of every maximum that
/// lasts less, all others left as they are. O(N + F).
ComponentTree simplify_tree(const ComponentTree& tree, std::span<const std::uint8_t> keep);

/// The scalar as the tree has it, one value a triangle: of S at the triangle's level (-h for a lower tree), an infinite
/// h_1 and what lies below an explicit one taken as one step below the next (below the only finite level by 1 or its
/// own size); NaN in no node. #F.
std::vector<double> reconstruct_triangle_values(const ComponentTree& tree);

/// One value a vertex: the highest (lower tree: lowest; shapes: within the most lines) of its triangles'; NaN where no
/// triangle in a node touches it. The tree of these values at the same levels is the same tree again, but after a
/// simplification, where a razed triangle may lie between vertices of higher ones, and but for shapes, where a vertex
/// above or below all of its triangles is lost. `values_of_triangle`: of reconstruct_triangle_values. O(V + F).
std::vector<double> reconstruct_vertex_values(const ComponentTree& tree, std::span<const double> values_of_triangle,
                                              std::span<const std::array<std::int32_t, 3>> triangles,
                                              std::size_t num_vertices);

}  // namespace meshmser
