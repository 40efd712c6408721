#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "pipeline/execution/execution.hpp"
#include "stages/export/drawing.hpp"
#include "stages/export/views.hpp"

namespace meshmser {

inline constexpr int kSamples = 2;         ///< per pixel and axis
inline constexpr int kMargin = 24;         ///< pixels around the object
inline constexpr int kScaleBarSpace = 44;  ///< pixels below it

struct RasterOptions {
  int width = 900, height = 700;  ///< pixels
  double light_azimuth = 135;     ///< degrees, counter-clockwise from the picture's right
  double light_elevation = 28;    ///< degrees above the picture's plane
  int ambient_rays = 4;           ///< per pixel; 0: no ambient occlusion
};

/// What the rays of one view met and how bright it is there: all of a picture but its colours.
struct Raster {
  struct Sample {
    std::int32_t triangle = -1;  ///< -1: nothing
    float u = 0, v = 0;          ///< weights of corners 1 and 2
    float depth = 0;
    float brightness = 0;  ///< factor for the surface's colour
  };
  int width = 0, height = 0;  ///< in samples, kSamples a pixel
  std::vector<Sample> samples;
  Eigen::Vector3d right, up, direction, corner;  ///< corner: where the ray of the upper left sample starts
  double sample_size = 0;
  double roughness = 0;  ///< of the surface: a line that lies on it may be so much deeper than its samples

  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
  Eigen::Vector3d ray_start(int x, int y) const { return corner + right * (x * sample_size) - up * (y * sample_size); }
  /// Column, row, depth of a point.
  Eigen::Vector3d project(const Eigen::Vector3d& point) const {
    const Eigen::Vector3d from_corner = point - corner;
    return {from_corner.dot(right) / sample_size, -from_corner.dot(up) / sample_size, from_corner.dot(direction)};
  }
};

/// Looks at the mesh so that it fills the picture within its margins. Raking light, a light from the eye, and ambient
/// occlusion; the inside of an open surface is darker. The same for any number of threads.
Raster make_raster(const Drawing& drawing, const View& view, const RasterOptions& options, const Execution& execution);

}  // namespace meshmser
