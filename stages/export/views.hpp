#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "pipeline/artifacts/triangle_mesh.hpp"

namespace meshmser {

/// A direction to look along. Cameras are orthographic: lengths can be measured anywhere in the picture.
struct View {
  std::string name;
  Eigen::Vector3d direction;  ///< from the eye to the object, unit length
  Eigen::Vector3d up;         ///< upward in the picture, at right angles to `direction`
};

/// Names that view_of_name knows: front (looking along +y), back, left, right, top, bottom, iso, iso_back, iso_below,
/// best.
const std::vector<std::string>& view_names();

/// Throws UsageError, which names the known ones, for the name of no view.
void check_view_name(const std::string& name);

/// The view called `name`. `best` looks at a sheet-like mesh along its mean normal (walls at its rim left out), with
/// the scan's own y up, and at a solid like iso. Throws UsageError for an unknown name.
View view_of_name(const std::string& name, const TriangleMesh& mesh);

/// What shows a mesh well: best alone for a sheet-like mesh (area-weighted mean normal longer than 0.5), else iso,
/// iso_back, top and iso_below.
std::vector<std::string> default_views(const TriangleMesh& mesh);

}  // namespace meshmser
