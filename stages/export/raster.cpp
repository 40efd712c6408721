#include "stages/export/raster.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "stages/common/parallel.hpp"

namespace meshmser {
namespace {

constexpr double kAmbientReach = 0.12;  // length of an ambient-occlusion ray, as a share of the mesh's diagonal

Eigen::Vector3d normal_at(const Drawing& drawing, const Raster::Sample& sample) {
  return drawing.normal_at({sample.triangle, sample.depth, sample.u, sample.v});
}

Eigen::Vector3d toward_eye(const Eigen::Vector3d& normal, const Eigen::Vector3d& direction) {
  return normal.dot(direction) > 0 ? Eigen::Vector3d(-normal) : normal;
}

Raster cast_rays(const Drawing& drawing, const View& view, int width, int height, const Execution& execution) {
  const TriangleMesh& mesh = drawing.mesh;
  Raster raster;
  raster.direction = view.direction;
  raster.up = view.up;
  raster.right = view.direction.cross(view.up);
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const auto& triangle : mesh.triangles)
    for (std::int32_t v : triangle) {
      const Eigen::Vector3d& p = mesh.positions[static_cast<std::size_t>(v)];
      const Eigen::Vector3d q(p.dot(raster.right), p.dot(raster.up), p.dot(raster.direction));
      low = low.cwiseMin(q);
      high = high.cwiseMax(q);
    }
  const double extent = std::max({high.x() - low.x(), high.y() - low.y(), high.z() - low.z(), 1e-300});
  const double pixel = std::max({(high.x() - low.x()) / (width - 2 * kMargin),
                                 (high.y() - low.y()) / (height - 2 * kMargin - kScaleBarSpace), extent * 1e-6});
  raster.width = width * kSamples;
  raster.height = height * kSamples;
  raster.sample_size = pixel / kSamples;
  raster.roughness = drawing.roughness;
  const double left = (low.x() + high.x()) / 2 - (raster.width - 1) / 2.0 * raster.sample_size;
  const double top =
      (low.y() + high.y()) / 2 + ((raster.height - 1) / 2.0 - kScaleBarSpace * kSamples / 2.0) * raster.sample_size;
  raster.corner = raster.right * left + raster.up * top + raster.direction * (low.z() - 0.01 * extent);
  raster.samples.resize(static_cast<std::size_t>(raster.width) * static_cast<std::size_t>(raster.height));
  parallel_chunks(raster.height, 16, "render", execution, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < end; ++y)
      for (int x = 0; x < raster.width; ++x)
        if (const RayScene::Hit hit = drawing.scene.intersect(raster.ray_start(x, y), raster.direction);
            hit.triangle >= 0)
          raster.samples[raster.index(x, y)] = {hit.triangle, static_cast<float>(hit.u), static_cast<float>(hit.v),
                                                static_cast<float>(hit.distance), 0};
  });
  return raster;
}

/// Open share of the sky above each pixel's surface, 0 .. 1, blurred over 4 x 4 pixels of similar depth to hide the
/// noise of few rays. Directions are a fixed pattern by pixel, so the picture is always the same.
std::vector<float> ambient_light(const Drawing& drawing, const Raster& raster, int rays, const Execution& execution) {
  const double reach = kAmbientReach * drawing.diagonal;
  const int width = raster.width / kSamples, height = raster.height / kSamples;
  std::vector<float> open(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 1.0f);
  if (rays <= 0) return open;
  auto sample_of_pixel = [&](int x, int y) -> const Raster::Sample& {
    return raster.samples[raster.index(x * kSamples, y * kSamples)];
  };
  auto pixel_index = [&](int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  };
  std::vector<float> raw = open;
  parallel_chunks(height, 8, "render", execution, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < end; ++y)
      for (int x = 0; x < width; ++x) {
        const Raster::Sample& sample = sample_of_pixel(x, y);
        if (sample.triangle < 0) continue;
        const Eigen::Vector3d normal = toward_eye(normal_at(drawing, sample), raster.direction);
        const Eigen::Vector3d tangent = normal.unitOrthogonal(), bitangent = normal.cross(tangent);
        const Eigen::Vector3d at = raster.ray_start(x * kSamples, y * kSamples) + raster.direction * sample.depth +
                                   (normal - raster.direction) * (0.5 * raster.sample_size) +
                                   normal * drawing.roughness;
        const int cell = (x % 4) + 4 * (y % 4);
        int free = 0;
        for (int ray = 0; ray < rays; ++ray) {
          // Cosine-weighted directions: a golden-angle spiral, turned and shifted from cell to cell of 4 x 4 pixels.
          const double height_share = (ray + (cell * 7 % 16 + 0.5) / 16) / rays;
          const double angle = 2 * std::numbers::pi * (ray * 0.6180339887 + cell * 5 % 16 / 16.0);
          const double radius = std::sqrt(height_share);
          const Eigen::Vector3d toward = tangent * (radius * std::cos(angle)) + bitangent * (radius * std::sin(angle)) +
                                         normal * std::sqrt(1 - height_share);
          free += drawing.scene.occluded(at, toward, 0, reach) ? 0 : 1;
        }
        raw[pixel_index(x, y)] = static_cast<float>(free) / static_cast<float>(rays);
      }
  });
  const double similar = 6 * kSamples * raster.sample_size;
  parallel_chunks(height, 16, "render", execution, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < end; ++y)
      for (int x = 0; x < width; ++x) {
        if (sample_of_pixel(x, y).triangle < 0) continue;
        float sum = 0, count = 0;
        for (int v = std::max(0, y - 1); v < std::min(height, y + 3); ++v)
          for (int u = std::max(0, x - 1); u < std::min(width, x + 3); ++u)
            if (sample_of_pixel(u, v).triangle >= 0 &&
                std::abs(sample_of_pixel(u, v).depth - sample_of_pixel(x, y).depth) < similar) {
              sum += raw[pixel_index(u, v)];
              count += 1;
            }
        open[pixel_index(x, y)] = sum / count;
      }
  });
  return open;
}

}  // namespace

Raster make_raster(const Drawing& drawing, const View& view, const RasterOptions& options, const Execution& execution) {
  Raster raster = cast_rays(drawing, view, options.width, options.height, execution);
  const std::vector<float> open = ambient_light(drawing, raster, options.ambient_rays, execution);
  const double azimuth = options.light_azimuth * std::numbers::pi / 180,
               elevation = options.light_elevation * std::numbers::pi / 180;
  const Eigen::Vector3d light =
      (raster.right * std::cos(azimuth) + raster.up * std::sin(azimuth)) * std::cos(elevation) -
      raster.direction * std::sin(elevation);
  parallel_chunks(raster.height, 16, "render", execution, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < end; ++y)
      for (int x = 0; x < raster.width; ++x) {
        Raster::Sample& sample = raster.samples[raster.index(x, y)];
        if (sample.triangle < 0) continue;
        const Eigen::Vector3d outward = normal_at(drawing, sample), normal = toward_eye(outward, raster.direction);
        const double sky = open[static_cast<std::size_t>(y / kSamples) * static_cast<std::size_t>(options.width) +
                                static_cast<std::size_t>(x / kSamples)];
        const double bright = sky * (0.37 - 0.37 * normal.dot(raster.direction)) +
                              0.52 * std::max(0.0, normal.dot(light)) * (0.4 + 0.6 * sky);
        const bool inside = outward.dot(raster.direction) > 0.1;
        sample.brightness = static_cast<float>(inside ? 0.62 * bright : bright);
      }
  });
  return raster;
}

}  // namespace meshmser
