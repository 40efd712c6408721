#include "stages/export/render.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "stages/common/parallel.hpp"
#include "stages/export/drawing.hpp"

namespace meshmser {
namespace {

constexpr int kSamples = 2;             // per pixel and axis
constexpr int kMargin = 24;             // pixels around the object
constexpr int kScaleBarSpace = 44;      // pixels below it
constexpr double kLineRadius = 1.6;     // of border lines, in samples
constexpr double kAmbientReach = 0.12;  // length of an ambient-occlusion ray, as a share of the mesh's diagonal
constexpr Colour kPaper = {255, 255, 255};
constexpr Colour kInk = {30, 30, 34};

/// Colour of the point with weights u, v of corners 1 and 2 of a triangle.
using SurfaceColour = std::function<Colour(std::int32_t triangle, double u, double v)>;

View make_view(const std::string& name, const Eigen::Vector3d& direction, const Eigen::Vector3d& upward) {
  const Eigen::Vector3d along = direction.normalized();
  return {name, along, (upward - along * along.dot(upward)).normalized()};
}

struct NamedView {
  const char* name;
  std::array<double, 3> direction, up;
};
constexpr std::array<NamedView, 9> kNamedViews = {{{"front", {0, 1, 0}, {0, 0, 1}},
                                                   {"back", {0, -1, 0}, {0, 0, 1}},
                                                   {"left", {1, 0, 0}, {0, 0, 1}},
                                                   {"right", {-1, 0, 0}, {0, 0, 1}},
                                                   {"top", {0, 0, -1}, {0, 1, 0}},
                                                   {"bottom", {0, 0, 1}, {0, 1, 0}},
                                                   {"iso", {-1, 1.2, -0.9}, {0, 0, 1}},
                                                   {"iso_back", {1, -1.2, -0.9}, {0, 0, 1}},
                                                   {"iso_below", {-1, 1.2, 0.9}, {0, 0, 1}}}};

/// What the rays of one view met, at kSamples x kSamples samples a pixel.
struct Raster {
  int width = 0, height = 0;  ///< in samples
  std::vector<RayScene::Hit> hits;
  Eigen::Vector3d right, up, direction, corner;  ///< corner: where the ray of the upper left sample starts
  double sample_size = 0;

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
  const double left = (low.x() + high.x()) / 2 - (raster.width - 1) / 2.0 * raster.sample_size;
  const double top =
      (low.y() + high.y()) / 2 + ((raster.height - 1) / 2.0 - kScaleBarSpace * kSamples / 2.0) * raster.sample_size;
  raster.corner = raster.right * left + raster.up * top + raster.direction * (low.z() - 0.01 * extent);
  raster.hits.resize(static_cast<std::size_t>(raster.width) * static_cast<std::size_t>(raster.height));
  parallel_chunks(raster.height, 16, "render", execution, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < end; ++y)
      for (int x = 0; x < raster.width; ++x)
        raster.hits[raster.index(x, y)] = drawing.scene.intersect(raster.ray_start(x, y), raster.direction);
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
  auto pixel_hit = [&](int x, int y) -> const RayScene::Hit& {
    return raster.hits[raster.index(x * kSamples, y * kSamples)];
  };
  auto pixel_index = [&](int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  };
  std::vector<float> raw = open;
  parallel_chunks(height, 8, "render", execution, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < end; ++y)
      for (int x = 0; x < width; ++x) {
        const RayScene::Hit& hit = pixel_hit(x, y);
        if (hit.triangle < 0) continue;
        const Eigen::Vector3d normal = drawing.normal_toward_eye(hit, raster.direction);
        const Eigen::Vector3d tangent = normal.unitOrthogonal(), bitangent = normal.cross(tangent);
        const Eigen::Vector3d at = raster.ray_start(x * kSamples, y * kSamples) + raster.direction * hit.distance +
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
        if (pixel_hit(x, y).triangle < 0) continue;
        float sum = 0, count = 0;
        for (int v = std::max(0, y - 1); v < std::min(height, y + 3); ++v)
          for (int u = std::max(0, x - 1); u < std::min(width, x + 3); ++u)
            if (std::abs(pixel_hit(u, v).distance - pixel_hit(x, y).distance) < similar) {
              sum += raw[pixel_index(u, v)];
              count += 1;
            }
        open[pixel_index(x, y)] = sum / count;
      }
  });
  return open;
}

/// Draws the lines into an image of samples where the surface does not hide them.
void draw_lines(Image& samples, const Raster& raster, const BorderLines& lines) {
  auto surface_depth = [&](int x, int y) {
    // The farthest of the samples around: a line on a steep surface must not drop out. Background does not count, else
    // lines behind the object would shine through along its outline.
    double depth = -std::numeric_limits<double>::infinity();
    for (int v = std::max(0, y - 1); v <= std::min(raster.height - 1, y + 1); ++v)
      for (int u = std::max(0, x - 1); u <= std::min(raster.width - 1, x + 1); ++u)
        if (const RayScene::Hit& hit = raster.hits[raster.index(u, v)]; hit.triangle >= 0)
          depth = std::max(depth, hit.distance);
    return depth;
  };
  // Hole edges last: where both kinds share a pixel the rim of the mesh shows.
  for (EdgeKind kind : {EdgeKind::kLevel, EdgeKind::kHole})
    for (const BorderLines::Segment& segment : lines.segments) {
      if (segment.kind != kind) continue;
      const Eigen::Vector3d from = raster.project(segment.from), to = raster.project(segment.to);
      const int steps = std::max(1, static_cast<int>(std::ceil((to - from).head<2>().norm())));
      for (int step = 0; step <= steps; ++step) {
        const Eigen::Vector3d at = from + (to - from) * (static_cast<double>(step) / steps);
        const int x = static_cast<int>(std::lround(at.x())), y = static_cast<int>(std::lround(at.y()));
        if (x < 0 || y < 0 || x >= raster.width || y >= raster.height) continue;
        if (at.z() > surface_depth(x, y) + 2 * raster.sample_size) continue;
        for (int v = y - 2; v <= y + 2; ++v)
          for (int u = x - 2; u <= x + 2; ++u)
            if (std::hypot(u - at.x(), v - at.y()) <= kLineRadius)
              samples.set(u, v, kind == EdgeKind::kLevel ? kLevelEdgeColour : kHoleEdgeColour);
      }
    }
}

Image halve(const Image& samples) {
  Image image(samples.width / kSamples, samples.height / kSamples, kPaper);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      std::array<int, 3> sum{};
      for (int v = 0; v < kSamples; ++v)
        for (int u = 0; u < kSamples; ++u) {
          const Colour colour = samples.at(x * kSamples + u, y * kSamples + v);
          for (std::size_t c = 0; c < 3; ++c) sum[c] += colour[c];
        }
      Colour mean;
      for (std::size_t c = 0; c < 3; ++c)
        mean[c] = static_cast<std::uint8_t>((sum[c] + kSamples * kSamples / 2) / (kSamples * kSamples));
      image.set(x, y, mean);
    }
  return image;
}

/// The largest of 1, 2, 5 x 10^n that is not above `length`.
double round_length(double length) {
  const double decade = std::pow(10.0, std::floor(std::log10(length)));
  for (double factor : {5.0, 2.0})
    if (factor * decade <= length) return factor * decade;
  return decade;
}

void draw_scale_bar(Image& image, double pixel_size, const std::string& unit) {
  const double length = round_length(0.3 * image.width * pixel_size);
  const int bar = static_cast<int>(std::lround(length / pixel_size));
  const int y = image.height - 20;
  image.fill_rectangle(kMargin, y, bar, 4, kInk);
  image.fill_rectangle(kMargin, y - 4, 2, 12, kInk);
  image.fill_rectangle(kMargin + bar - 2, y - 4, 2, 12, kInk);
  draw_text(image, kMargin + bar + 10, y - 5,
            unit.empty() ? fmt::format("{:g}", length) : fmt::format("{:g} {}", length, unit), 2, kInk);
}

Image render_view(const Drawing& drawing, const View& view, const SurfaceColour& colour_at, const BorderLines& lines,
                  const RenderOptions& options, const Execution& execution) {
  const Raster raster = cast_rays(drawing, view, options.panel_width, options.panel_height, execution);
  const std::vector<float> open = ambient_light(drawing, raster, options.ambient_rays, execution);
  const double azimuth = options.light_azimuth * std::numbers::pi / 180,
               elevation = options.light_elevation * std::numbers::pi / 180;
  const Eigen::Vector3d light =
      (raster.right * std::cos(azimuth) + raster.up * std::sin(azimuth)) * std::cos(elevation) -
      raster.direction * std::sin(elevation);
  Image samples(raster.width, raster.height, kPaper);
  parallel_chunks(raster.height, 16, "render", execution, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < end; ++y)
      for (int x = 0; x < raster.width; ++x) {
        const RayScene::Hit& hit = raster.hits[raster.index(x, y)];
        if (hit.triangle < 0) continue;
        const Eigen::Vector3d normal = drawing.normal_toward_eye(hit, raster.direction);
        const double sky = open[static_cast<std::size_t>(y / kSamples) * static_cast<std::size_t>(options.panel_width) +
                                static_cast<std::size_t>(x / kSamples)];
        double brightness = sky * (0.34 + 0.34 * -normal.dot(raster.direction)) +
                            0.48 * std::max(0.0, normal.dot(light)) * (0.4 + 0.6 * sky);
        // The inside of an open surface is told apart: darker.
        if (drawing.normal_at(hit).dot(raster.direction) > 0.1) brightness *= 0.62;
        Colour colour = colour_at(hit.triangle, hit.u, hit.v);
        for (std::uint8_t& channel : colour)
          channel = static_cast<std::uint8_t>(std::lround(std::clamp(channel * brightness * 1.08, 0.0, 255.0)));
        samples.set(x, y, colour);
      }
  });
  draw_lines(samples, raster, lines);
  Image image = halve(samples);
  draw_text(image, 10, 8, view.name, 2, {110, 110, 115});
  draw_scale_bar(image, raster.sample_size * kSamples, options.unit);
  return image;
}

/// Draws what explains the colours into the strip below the views, from (x, y) on.
using Legend = std::function<void(Image& image, int x, int y)>;

Image render(const TriangleMesh& mesh, const SurfaceColour& colour_at, const BorderLines& lines, const Legend& legend,
             const RenderOptions& options, const Execution& execution) {
  if (mesh.triangles.empty()) throw StageError("render: the mesh has no triangles, so there is nothing to draw");
  if (options.panel_width < 4 * kMargin || options.panel_height < 4 * kMargin + kScaleBarSpace)
    throw UsageError(fmt::format("render: a view of {} x {} pixels is too small, at least {} x {} are needed",
                                 options.panel_width, options.panel_height, 4 * kMargin, 4 * kMargin + kScaleBarSpace));
  std::vector<View> views;
  for (const std::string& name : options.views.empty() ? default_views(mesh) : options.views)
    views.push_back(view_of_name(name, mesh));
  const Drawing drawing(mesh);
  const int columns = views.size() > 1 ? 2 : 1, rows = (static_cast<int>(views.size()) + columns - 1) / columns;
  const int title_height = options.title.empty() ? 0 : 40, legend_height = 56;
  Image image(columns * options.panel_width, title_height + rows * options.panel_height + legend_height, kPaper);
  if (!options.title.empty()) draw_text(image, kMargin, 14, options.title, 2, kInk);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const int column = static_cast<int>(i) % columns, row = static_cast<int>(i) / columns;
    image.paste(render_view(drawing, views[i], colour_at, lines, options, execution), column * options.panel_width,
                title_height + row * options.panel_height);
  }
  const int y = title_height + rows * options.panel_height;
  image.fill_rectangle(0, y, image.width, 1, {225, 225, 225});
  legend(image, kMargin, y + 18);
  return image;
}

/// Tells the two kinds of border edges apart, right of x; only those that occur.
void draw_line_legend(Image& image, int x, int y, const BorderLines& lines) {
  for (EdgeKind kind : {EdgeKind::kLevel, EdgeKind::kHole}) {
    if (std::none_of(lines.segments.begin(), lines.segments.end(),
                     [&](const auto& segment) { return segment.kind == kind; }))
      continue;
    const std::string text = kind == EdgeKind::kLevel ? "level edge" : "hole edge";
    image.fill_rectangle(x, y + 6, 28, 3, kind == EdgeKind::kLevel ? kLevelEdgeColour : kHoleEdgeColour);
    draw_text(image, x + 38, y, text, 2, kInk);
    x += 38 + text_width(text, 2) + 30;
  }
}

}  // namespace

const std::vector<std::string>& view_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const NamedView& view : kNamedViews) all.emplace_back(view.name);
    all.emplace_back("best");
    return all;
  }();
  return names;
}

View view_of_name(const std::string& name, const TriangleMesh& mesh) {
  if (name == "best") {
    const Eigen::Vector3d facing = facing_of_sheet(mesh);
    if (facing.isZero()) {
      View view = view_of_name("iso", mesh);
      view.name = name;
      return view;
    }
    // The scan's own y stays up, as in the scanner's picture; z where the sheet faces along y.
    return make_view(name, -facing, std::abs(facing.y()) < 0.8 ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ());
  }
  for (const NamedView& view : kNamedViews)
    if (name == view.name)
      return make_view(name, {view.direction[0], view.direction[1], view.direction[2]},
                       {view.up[0], view.up[1], view.up[2]});
  throw UsageError(fmt::format("render: unknown view '{}'; known: {}", name, fmt::join(view_names(), ", ")));
}

std::vector<std::string> default_views(const TriangleMesh& mesh) {
  if (!facing_of_sheet(mesh).isZero()) return {"best"};
  return {"iso", "iso_back", "top", "iso_below"};
}

BorderLines BorderLines::of_loops(const TriangleMesh& mesh, const BorderLoops& loops) {
  BorderLines lines;
  lines.segments.reserve(loops.half_edges.size());
  for (std::size_t e = 0; e < loops.half_edges.size(); ++e) {
    const auto triangle = mesh.triangles[static_cast<std::size_t>(loops.half_edges[e] / 3)];
    const auto corner = static_cast<std::size_t>(loops.half_edges[e] % 3);
    lines.segments.push_back({mesh.positions[static_cast<std::size_t>(triangle[corner])],
                              mesh.positions[static_cast<std::size_t>(triangle[(corner + 1) % 3])], loops.kinds[e]});
  }
  return lines;
}

BorderLines BorderLines::of_curves(const BorderCurves& curves) {
  BorderLines lines;
  for (std::size_t curve = 0; curve + 1 < curves.first_point_of_curve.size(); ++curve) {
    const auto first = static_cast<std::size_t>(curves.first_point_of_curve[curve]);
    const auto last = static_cast<std::size_t>(curves.first_point_of_curve[curve + 1]);
    for (std::size_t i = first; i < last; ++i)
      lines.segments.push_back({curves.points[i], curves.points[i + 1 < last ? i + 1 : first], curves.kinds[i]});
  }
  return lines;
}

Image render_labels(const TriangleMesh& mesh, std::span<const std::int32_t> label_of_triangle,
                    const BorderLines& borders, const RenderOptions& options, const Execution& execution) {
  const std::vector<Colour> colours = label_colours(mesh, label_of_triangle);
  const auto colour_at = [&](std::int32_t triangle, double, double) {
    return colours[static_cast<std::size_t>(label_of_triangle[static_cast<std::size_t>(triangle)])];
  };
  const auto legend = [&](Image& image, int x, int y) {
    const std::size_t count = colours.size() - 1;
    const std::string text = fmt::format("{} label{}", count, count == 1 ? "" : "s");
    draw_text(image, x, y, text, 2, kInk);
    draw_line_legend(image, x + text_width(text, 2) + 40, y, borders);
  };
  return render(mesh, colour_at, borders, legend, options, execution);
}

Image render_scalar(const TriangleMesh& mesh, std::span<const double> value_of_vertex, const std::string& name,
                    const std::string& scalar_unit, const BorderLines& borders,
                    const std::optional<ColourMap>& given_map, const RenderOptions& options,
                    const Execution& execution) {
  const ColourMap map = given_map ? *given_map : ColourMap::of_values(value_of_vertex);
  const auto colour_at = [&](std::int32_t triangle, double u, double v) {
    const auto& [a, b, c] = mesh.triangles[static_cast<std::size_t>(triangle)];
    return map(value_of_vertex[static_cast<std::size_t>(a)] * (1 - u - v) +
               value_of_vertex[static_cast<std::size_t>(b)] * u + value_of_vertex[static_cast<std::size_t>(c)] * v);
  };
  const auto legend = [&](Image& image, int x, int y) {
    const std::string low = fmt::format("{:.3g}", map.low), high = fmt::format("{:.3g}", map.high);
    draw_text(image, x, y, low, 2, kInk);
    x += text_width(low, 2) + 10;
    constexpr int kBarWidth = 240;
    for (int i = 0; i < kBarWidth; ++i)
      image.fill_rectangle(x + i, y - 2, 1, 18, map(map.low + (map.high - map.low) * (i + 0.5) / kBarWidth));
    x += kBarWidth + 10;
    const std::string text =
        scalar_unit.empty() ? fmt::format("{}  {}", high, name) : fmt::format("{}  {} [{}]", high, name, scalar_unit);
    draw_text(image, x, y, text, 2, kInk);
    draw_line_legend(image, x + text_width(text, 2) + 40, y, borders);
  };
  return render(mesh, colour_at, borders, legend, options, execution);
}

Image render_shape(const TriangleMesh& mesh, const BorderLines& borders, const RenderOptions& options,
                   const Execution& execution) {
  const auto colour_at = [](std::int32_t, double, double) { return Colour{214, 210, 202}; };
  const auto legend = [&](Image& image, int x, int y) {
    const std::string text = fmt::format("{} triangles, {} vertices", mesh.num_triangles(), mesh.num_vertices());
    draw_text(image, x, y, text, 2, kInk);
    draw_line_legend(image, x + text_width(text, 2) + 40, y, borders);
  };
  return render(mesh, colour_at, borders, legend, options, execution);
}

}  // namespace meshmser
