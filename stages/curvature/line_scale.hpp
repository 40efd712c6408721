#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "pipeline/execution/execution.hpp"

namespace meshmser {

/// Radius of the regression for lines of a given width, from sherds (ridges 2 mm wide, best radius 0.75 mm) and a
/// tablet (grooves 0.7 mm wide, best radius 0.3 mm).
inline constexpr double kRadiusOfLineWidth = 0.375;

/// The scale at which a relief stands out.
struct LineScale {
  double radius = 0;                                ///< of the regression, in coordinate units
  std::vector<std::pair<double, double>> response;  ///< (radius, scale-normalised strength) as far as it was measured
};

/// Measures the radius at which a relief answers most: the first maximum of radius times the width of the distribution
/// of H (its 10 % to 90 % quantiles, which leaves out rims; less the share of noise) after four scale-space steps, over
/// radii from 3 spacings upward by cube roots of two, refined by a parabola. Scale selection by normalised derivatives
/// after Lindeberg 1998, with H for the second derivative.
///
/// points, normals: as scale_space takes them; spacing: > 0. From the third radius on, points are averaged over cells
/// of a quarter radius, so that all radii together cost about as much as ten steps. 3 spacings where the response only
/// falls; the largest radius tried (48 spacings) where it only rises. Does not depend on threads.
LineScale measure_line_scale(std::span<const Eigen::Vector3d> points, std::span<const Eigen::Vector3d> normals,
                             double spacing, const Execution& execution = {});

}  // namespace meshmser
