#pragma once
/// Where a surface falls away at its rim: a fragment's broken, rounded edge, a plate's side.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/execution/execution.hpp"

namespace meshmser {

struct FallenRimParameters {
  double radius = 0;   ///< the scalar's own scale r, > 0; all reaches are multiples of it
  double depth = 0;    ///< below the surface inside, in coordinate units; 0: measured on the relief inside
  double min_rim = 0;  ///< rims up to this length are holes at which nothing falls
};

struct FallenRim {
  std::vector<std::uint8_t> fallen_of_vertex;  ///< #V
  double depth = 0;                            ///< that was asked for or measured; 0: no vertex near a long rim
};

/// Vertices deeper than `depth` below the surface inside that are joined to a long rim through such vertices.
///
/// The surface inside: around each place within 8 r of a rim, z = a + b u + c v + d u^2 + e u v + f v^2 in the frame of
/// the mean normal, fitted to the places within 12 r that are more than 4 r from the rim, then refitted six times to
/// all of them with Tukey's weights (which leave out what has fallen). A place stands for the vertices of a cube of
/// side r. Measured depth: that below which 2 % of the vertices lie that are 4 to 8 r from a rim, at least
/// r / 3; so neither grooves nor ridges count as fallen. positions, normals (unit or longer, not NaN), areas: #V;
/// twins: of the whole mesh. Time: linear in the mesh, and some 400 places for each place near a rim.
FallenRim fallen_rim(std::span<const Eigen::Vector3d> positions, std::span<const Eigen::Vector3d> normals,
                     std::span<const double> areas, std::span<const std::array<std::int32_t, 3>> triangles,
                     std::span<const std::int32_t> twins, const FallenRimParameters& parameters,
                     const Execution& execution = {});

}  // namespace meshmser
