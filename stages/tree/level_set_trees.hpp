#pragma once
/// From a mesh and a scalar on its vertices to its trees: exclusion, detrending, transform, levels, one tree a polarity
/// (definitions 5 and 6).

#include <Eigen/Core>
#include <optional>

#include "pipeline/artifacts/level_set_trees.hpp"
#include "pipeline/artifacts/triangle_mesh.hpp"
#include "pipeline/execution/execution.hpp"
#include "stages/tree/exclusion.hpp"
#include "stages/tree/levels.hpp"
#include "stages/tree/vertex_scalar.hpp"

namespace meshmser {

enum class ScalarTransform { kIdentity, kNegate, kAbs, kNegateAbs };
enum class NanPolicy {
  kAuto,    ///< exclude where a stage measured the scalar, an error where a file gave it
  kError,   ///< a value that is not finite is an error that names the vertex
  kExclude  ///< triangles that touch one are excluded
};
enum class PolarityChoice { kUpper, kLower, kBoth, kShapes };

struct LevelSetTreesParameters {
  ScalarTransform transform = ScalarTransform::kIdentity;
  double detrend = 0;       ///< radius of the ball whose mean is subtracted, in coordinate units; 0: none
  double detrend_clip = 0;  ///< in median deviations: where values are clipped before the mean is taken; 0: nowhere
  double exclude_rim = 0;   ///< in coordinate units; 0: none
  double min_rim = 0;       ///< rims up to this length are holes that exclude nothing, in coordinate units
  bool fallen_rim = false;  ///< what has fallen away at a long rim counts as rim (fallen_rim.hpp)
  double fallen_depth = 0;  ///< in coordinate units; 0: measured
  NanPolicy nan = NanPolicy::kAuto;
  LevelParameters levels;  ///< its noise, where NaN, is the scalar's own
  PolarityChoice polarity = PolarityChoice::kBoth;
  std::optional<Eigen::Vector3d> root;  ///< of shapes, minus the mesh's origin: the vertex nearest to it is the root
};

struct LevelSetTreesResult {
  LevelSetTrees trees;
  double fallen_depth = 0;        ///< asked for or measured, where `fallen_rim`
  Exclusion exclusion;            ///< its triangles are in `trees`; the counts are for the report
  std::int32_t root_vertex = -1;  ///< the vertex nearest to `root`; -1: none was asked for
};

/// Builds the trees. Excluded triangles leave first; the local mean is over what remains (with `detrend_clip`, the
/// clipped one, which neither lines nor a sharp edge tilt);
/// then the transform; the levels are laid over the vertices of what remains. Trees: upper, then lower, or that of the
/// shapes, with the levels of the upper one. Throws StageError for values that are not finite where they are an error,
/// where the level rule lacks what it needs, and for shapes on a surface with a handle (see build_tree_of_shapes).
/// Linear time but for detrending and sorting by value; the same bytes on any number of threads.
LevelSetTreesResult build_level_set_trees(const TriangleMesh& mesh, const VertexScalar& scalar,
                                          const LevelSetTreesParameters& parameters, const Execution& execution = {});

}  // namespace meshmser
