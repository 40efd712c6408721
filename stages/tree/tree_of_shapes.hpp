#pragma once
/// The tree of shapes of a mesh's vertices (definitions 6, shapes), on plain arrays.

#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/artifacts/level_set_trees.hpp"
#include "pipeline/execution/execution.hpp"
#include "stages/common/surface.hpp"

namespace meshmser {

/// The tree of shapes: bright and dark regions in one tree, each with its holes filled.
///
/// A threshold k parts the vertices into those of level >= k and those below. A *shape* is a connected component (along
/// edges) of either part that does not hold the root, together with every component of the rest that does not hold the
/// root either. Shapes are nested or disjoint. A triangle lies in a shape where its three corners do: so a bright shape
/// without filling is a component of {min S >= h}, a dark one of {max S < h}, as for the two polarities. On
/// triangulated spheres edges serve both parts alike, and no triangle is claimed by a bright and a dark shape that do
/// not nest.
///
/// Each rim of a component is closed by one more vertex, joined to all of the rim, whose level is the lower median of
/// the rim's: the level lines that reach a hole end there, and a region that a hole cuts may stay one shape. The root
/// is the vertex that closes the longest rim; `root_vertex` where it is a vertex of the component; without rim the
/// place from which no shape has more than half of the area (the centroid of the tree of level lines, which is not
/// rooted).
///
/// The result is a component tree whose levels count the thresholds between a shape and the root, upward or downward:
/// level 1 is the root, a shape of level k lies within k - 1 level lines. Its nodes are the edge-connected parts of the
/// shapes' triangles; so stability, selection and borders apply as they are. `polarity` is shapes, `levels` are those
/// of the scalar; ComponentTree::value tells S on a node's line, ComponentTree::side bright (upper) from dark (lower).
///
/// `surface.twins`: after cut_out_triangles; `areas`: #F; `level_of_vertex`: #V, 0 .. n, of levels_of_vertices with
/// `levels` (n, ascending); `excluded`: #F or empty. Vertices where several fans meet count once for each.
/// Throws StageError for a component with a handle, naming it, and for arrays of differing sizes.
/// O(V log V + F log V), one thread but for the last step; 100 bytes a vertex.
///
/// Source: Monasse, Guichard 2000 (shapes by saturation, fusion of upper and lower tree); made here by the contour tree
/// (Carr, Snoeyink, Axen 2003: join and split tree, merged), whose arcs are the level lines of a simply connected
/// surface.
ComponentTree build_tree_of_shapes(const SurfaceView& surface, std::span<const double> areas,
                                   std::span<const std::int32_t> level_of_vertex, std::span<const double> levels,
                                   std::span<const std::uint8_t> excluded, std::int32_t root_vertex = -1,
                                   const Execution& execution = {});

}  // namespace meshmser
