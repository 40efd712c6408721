#pragma once
/// Borders as drawings to scale on a plane, for plates and workshops.

#include <Eigen/Core>
#include <filesystem>
#include <string>

#include "pipeline/artifacts/border_set.hpp"
#include "pipeline/artifacts/triangle_mesh.hpp"

namespace meshmser {

/// Axes of a drawing, of unit length and at right angles; the plane is seen from right x up.
struct DrawingAxes {
  Eigen::Vector3d right = Eigen::Vector3d::UnitX();
  Eigen::Vector3d up = Eigen::Vector3d::UnitY();
};

/// The plane with the least squared distances to the loops' vertices, seen from the side that the surface there faces,
/// with the scan's y upward (z where the plane faces along y). Fewer than three vertices: x and y. O(edges).
DrawingAxes best_fitting_plane(const TriangleMesh& mesh, const BorderLoops& loops);

/// Writes loops as paths in millimetres where `units` is a known unit (else a unit of the drawing is one of the
/// coordinates), each run of level or hole edges one path of that class with `data-number`, the loop's owner. Throws
/// CacheError where the file cannot be written.
void write_borders_svg(const std::filesystem::path& path, const TriangleMesh& mesh, const BorderLoops& loops,
                       const DrawingAxes& axes, const std::string& units);

/// Writes the same runs as polylines of DXF release 12, in coordinate units, on layers LEVEL_N and HOLE_N. The drawing's
/// origin is that of the coordinates.
void write_borders_dxf(const std::filesystem::path& path, const TriangleMesh& mesh, const BorderLoops& loops,
                       const DrawingAxes& axes, const std::string& units);

}  // namespace meshmser
