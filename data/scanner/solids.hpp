#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "data/scanner/shape.hpp"

namespace meshmser::scanner {

/// Everything here is closed and outward unless said otherwise. `first_face`: number of the first face; the faces of
/// one solid are numbered upward from it in the order told.

/// Vertices that a circle of `radius` needs so that its chords stay within `tolerance` of it; at least 24.
int circle_segments(double radius, double tolerance);

/// Axis-parallel box. Faces: low x, high x, low y, high y, low z, high z.
Shape box(const Eigen::Vector3d& low, const Eigen::Vector3d& high, std::int32_t first_face);

/// Cylinder or cone between two discs. Faces: side, disc at `from`, disc at `to`.
Shape frustum(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double from_radius, double to_radius,
              double tolerance, std::int32_t first_face);

/// Triangular prism: the triangle a, b, c shifted by `half_width` both ways. Faces: the two caps, ab, bc, ca.
Shape prism(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
            const Eigen::Vector3d& half_width, std::int32_t first_face);

/// Sphere about 0: an icosahedron whose edges were halved `level` times. One face.
Shape sphere(double radius, int level);

/// Torus about the z axis. One face.
Shape torus(double ring_radius, double tube_radius, double tolerance);

/// A surface over a grid of cells, each cut in two triangles.
struct HeightField {
  Eigen::Vector2d low, high;
  int columns = 1, rows = 1;  ///< cells along x and y
  std::function<double(double x, double y)> height;
  std::function<std::int32_t(double x, double y)> face;  ///< of the triangle with this centroid
  std::function<bool(double x, double y)> falls =
      {};                       ///< of the cell with this centre: cut from upper left to lower right
  std::optional<double> floor;  ///< none: an open sheet; else walls and a bottom at this z
};
/// Faces: as `face` says (from 1), then the walls at low x, high x, low y, high y and the bottom, from
/// `first_wall_face`.
Shape height_field(const HeightField& field, std::int32_t first_wall_face);

/// A closed polygon in x and z, its inside on the left, pulled along y from 0 to `length`. face_of_side[i]: of the side
/// from corner i to the next; `cap_face`: of the cap at y = 0, `cap_face` + 1: at y = length.
Shape extrusion(const std::vector<Eigen::Vector2d>& corners, const std::vector<std::int32_t>& face_of_side,
                double length, std::int32_t cap_face);

/// A profile (radius, z) from axis to axis, its inside on the left, turned about the z axis in `segments` steps.
/// `radius`: none, or gives the radius to use for a profile point at an angle (in radians). `face`: of the triangle on
/// a piece of the profile (from point i to i + 1) whose centroid lies at an angle and z. First and last point must lie
/// on the axis.
struct Turning {
  std::vector<Eigen::Vector2d> profile;
  int segments = 64;
  std::function<double(std::size_t point, double angle)> radius = {};
  std::function<std::int32_t(std::size_t piece, double angle, double z)> face;
};
Shape turned_solid(const Turning& turning);

}  // namespace meshmser::scanner
