#pragma once
/// The scalar of a tree by its name, as one value a vertex (definitions 5).

#include <limits>
#include <span>
#include <string>
#include <vector>

#include "pipeline/artifacts/point_cloud.hpp"
#include "pipeline/artifacts/scalar_fields.hpp"
#include "pipeline/artifacts/triangle_mesh.hpp"

namespace meshmser {

/// The fields that one stage made, under the stage's name in the config.
struct StageFields {
  std::string stage;
  const ScalarFields* fields = nullptr;
};

struct VertexScalar {
  std::string name;
  std::string unit;                                         ///< in coordinate units; "" for a property
  double noise = std::numeric_limits<double>::quiet_NaN();  ///< sigma_S; NaN: unknown
  double radius = 0;                                        ///< at which a stage measured it; 0: not known
  bool is_given = false;                                    ///< a property of a file, not measured by a stage
  std::vector<double> values;                               ///< #V
};

/// Looks a scalar up: `stage.field`, a field that only one stage made, a vertex property of the mesh, or a property of
/// the cloud (may be null). A field over points is read at each vertex's point; an odd one (H, height) changes its sign
/// where the mesh turned the point's normal. Throws StageError, naming what there is, where nothing bears the name or
/// several stages do. O(V).
VertexScalar find_vertex_scalar(const std::string& name, std::span<const StageFields> fields, const TriangleMesh& mesh,
                                const PointCloud* cloud);

}  // namespace meshmser
