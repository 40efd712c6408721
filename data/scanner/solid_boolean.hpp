#pragma once
#include <vector>

#include "data/scanner/shape.hpp"

namespace meshmser::scanner {

/// The union of `bodies` without the union of `cutters`, with each triangle's face kept; an exact mesh, closed and
/// outward. Arguments: closed outward solids without self-intersections, at least one body. Throws std::logic_error
/// when the result is no closed surface. Deterministic. Corefinement in exact arithmetic [CGAL Polygon Mesh
/// Processing]; about a second for the parts made here.
Shape combine_solids(const std::vector<Shape>& bodies, const std::vector<Shape>& cutters);

}  // namespace meshmser::scanner
