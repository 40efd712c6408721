#pragma once
/// The closed list of what flows between stages. Each type lists its fields once, in `visit`: stored form, digest and
/// statistics come from that list.

#include <memory>
#include <string_view>
#include <variant>

#include "pipeline/artifacts/border_set.hpp"
#include "pipeline/artifacts/file_set.hpp"
#include "pipeline/artifacts/level_set_trees.hpp"
#include "pipeline/artifacts/point_cloud.hpp"
#include "pipeline/artifacts/point_normals.hpp"
#include "pipeline/artifacts/scalar_fields.hpp"
#include "pipeline/artifacts/segmentation.hpp"
#include "pipeline/artifacts/smoothed_points.hpp"
#include "pipeline/artifacts/triangle_mesh.hpp"

namespace meshmser {

template <class T>
using Shared = std::shared_ptr<const T>;

using Artifact = std::variant<Shared<PointCloud>, Shared<PointNormals>, Shared<SmoothedPoints>, Shared<ScalarFields>,
                              Shared<TriangleMesh>, Shared<LevelSetTrees>, Shared<Segmentation>, Shared<BorderSet>,
                              Shared<FileSet>>;

/// Name and version of an artifact's stored form; the version is raised whenever the meaning of a field changes.
struct ArtifactInfo {
  std::string_view name;
  int version;
};
template <class T>
inline constexpr ArtifactInfo kArtifactInfo{};
template <> inline constexpr ArtifactInfo kArtifactInfo<PointCloud>{"point_cloud", 1};
template <> inline constexpr ArtifactInfo kArtifactInfo<PointNormals>{"point_normals", 1};
template <> inline constexpr ArtifactInfo kArtifactInfo<SmoothedPoints>{"smoothed_points", 1};
template <> inline constexpr ArtifactInfo kArtifactInfo<ScalarFields>{"scalar_fields", 1};
template <> inline constexpr ArtifactInfo kArtifactInfo<TriangleMesh>{"triangle_mesh", 1};
template <> inline constexpr ArtifactInfo kArtifactInfo<LevelSetTrees>{"level_set_trees", 1};
template <> inline constexpr ArtifactInfo kArtifactInfo<Segmentation>{"segmentation", 1};
template <> inline constexpr ArtifactInfo kArtifactInfo<BorderSet>{"border_set", 1};
template <> inline constexpr ArtifactInfo kArtifactInfo<FileSet>{"file_set", 1};

}  // namespace meshmser
