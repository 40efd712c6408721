#include "stages/export/render.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "stages/common/parallel.hpp"
#include "stages/export/drawing.hpp"
#include "stages/export/raster.hpp"

namespace meshmser {
namespace {

constexpr double kLineRadius = 1.6;  // of border lines, in samples
constexpr Colour kPaper = {255, 255, 255};
constexpr Colour kInk = {30, 30, 34};

/// Draws the lines into an image of samples where the surface does not hide them.
void draw_lines(Image& samples, const Raster& raster, const BorderLines& lines) {
  auto surface_depth = [&](int x, int y) {
    // The farthest of the samples around: a line on a steep surface must not drop out. Background does not count, else
    // lines behind the object would shine through along its outline.
    double depth = -std::numeric_limits<double>::infinity();
    for (int v = std::max(0, y - 1); v <= std::min(raster.height - 1, y + 1); ++v)
      for (int u = std::max(0, x - 1); u <= std::min(raster.width - 1, x + 1); ++u)
        if (const Raster::Sample& sample = raster.samples[raster.index(u, v)]; sample.triangle >= 0)
          depth = std::max(depth, static_cast<double>(sample.depth));
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
        if (at.z() > surface_depth(x, y) + 2 * raster.sample_size + 1.5 * raster.roughness) continue;
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

Image colour_view(const Raster& raster, const std::string& name, const Picture& picture, const RenderOptions& options,
                  const Execution& execution) {
  Image samples(raster.width, raster.height, kPaper);
  parallel_chunks(raster.height, 16, "render", execution, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < end; ++y)
      for (int x = 0; x < raster.width; ++x) {
        const Raster::Sample& sample = raster.samples[raster.index(x, y)];
        if (sample.triangle < 0) continue;
        Colour colour = picture.colour_at(sample.triangle, sample.u, sample.v);
        for (std::uint8_t& channel : colour)
          channel = static_cast<std::uint8_t>(std::lround(std::clamp(channel * sample.brightness, 0.0f, 255.0f)));
        samples.set(x, y, colour);
      }
  });
  draw_lines(samples, raster, picture.lines);
  Image image = halve(samples);
  draw_text(image, 10, 8, name, 2, {110, 110, 115});
  draw_scale_bar(image, raster.sample_size * kSamples, options.unit);
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

Picture picture_of_labels(const TriangleMesh& mesh, std::span<const std::int32_t> label_of_triangle,
                          BorderLines borders) {
  std::vector<Colour> colours = label_colours(mesh, label_of_triangle);
  const std::size_t count = colours.size() - 1;
  Picture picture;
  picture.lines = std::move(borders);
  picture.legend = [count](Image& image, int x, int y) {
    const std::string text = fmt::format("{} label{}", count, count == 1 ? "" : "s");
    draw_text(image, x, y, text, 2, kInk);
    return x + text_width(text, 2);
  };
  picture.colour_at = [colours = std::move(colours), label_of_triangle](std::int32_t triangle, double, double) {
    return colours[static_cast<std::size_t>(label_of_triangle[static_cast<std::size_t>(triangle)])];
  };
  return picture;
}

Picture picture_of_scalar(const TriangleMesh& mesh, std::span<const double> value_of_vertex, const std::string& name,
                          const std::string& scalar_unit, BorderLines borders,
                          const std::optional<ColourMap>& given_map) {
  const ColourMap map = given_map ? *given_map : ColourMap::of_values(value_of_vertex);
  Picture picture;
  picture.lines = std::move(borders);
  picture.colour_at = [&mesh, value_of_vertex, map](std::int32_t triangle, double u, double v) {
    const auto& [a, b, c] = mesh.triangles[static_cast<std::size_t>(triangle)];
    return map(value_of_vertex[static_cast<std::size_t>(a)] * (1 - u - v) +
               value_of_vertex[static_cast<std::size_t>(b)] * u + value_of_vertex[static_cast<std::size_t>(c)] * v);
  };
  picture.legend = [map, name, scalar_unit](Image& image, int x, int y) {
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
    return x + text_width(text, 2);
  };
  return picture;
}

Picture picture_of_shape(const TriangleMesh& mesh, BorderLines borders) {
  Picture picture;
  picture.lines = std::move(borders);
  picture.colour_at = [](std::int32_t, double, double) { return Colour{214, 210, 202}; };
  picture.legend = [triangles = mesh.num_triangles(), vertices = mesh.num_vertices()](Image& image, int x, int y) {
    const std::string text = fmt::format("{} triangles, {} vertices", triangles, vertices);
    draw_text(image, x, y, text, 2, kInk);
    return x + text_width(text, 2);
  };
  return picture;
}

std::vector<Image> render(const TriangleMesh& mesh, std::span<const Picture> pictures, const RenderOptions& options,
                          const Execution& execution) {
  if (mesh.triangles.empty()) throw StageError("render: the mesh has no triangles, so there is nothing to draw");
  if (options.panel_width < 4 * kMargin || options.panel_height < 4 * kMargin + kScaleBarSpace)
    throw UsageError(fmt::format("render: a view of {} x {} pixels is too small, at least {} x {} are needed",
                                 options.panel_width, options.panel_height, 4 * kMargin, 4 * kMargin + kScaleBarSpace));
  std::vector<View> views;
  for (const std::string& name : options.views.empty() ? default_views(mesh) : options.views)
    views.push_back(view_of_name(name, mesh));
  const Drawing drawing(mesh);
  RasterOptions raster_options;
  raster_options.width = options.panel_width;
  raster_options.height = options.panel_height;
  raster_options.light_azimuth = options.light_azimuth;
  raster_options.light_elevation = options.light_elevation;
  raster_options.ambient_rays = options.ambient_rays;

  const int columns = views.size() > 1 ? 2 : 1, rows = (static_cast<int>(views.size()) + columns - 1) / columns;
  const int title_height = options.title.empty() ? 0 : 40, legend_height = 56;
  const Image empty(columns * options.panel_width, title_height + rows * options.panel_height + legend_height, kPaper);
  std::vector<Image> images(pictures.size(), empty);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const int column = static_cast<int>(i) % columns, row = static_cast<int>(i) / columns;
    const Raster raster = make_raster(drawing, views[i], raster_options, execution);
    for (std::size_t p = 0; p < pictures.size(); ++p)
      images[p].paste(colour_view(raster, views[i].name, pictures[p], options, execution), column * options.panel_width,
                      title_height + row * options.panel_height);
  }
  for (std::size_t p = 0; p < pictures.size(); ++p) {
    if (!options.title.empty()) draw_text(images[p], kMargin, 14, options.title, 2, kInk);
    const int y = title_height + rows * options.panel_height;
    images[p].fill_rectangle(0, y, images[p].width, 1, {225, 225, 225});
    const int x = pictures[p].legend ? pictures[p].legend(images[p], kMargin, y + 18) + 40 : kMargin;
    draw_line_legend(images[p], x, y + 18, pictures[p].lines);
  }
  return images;
}

Image render_labels(const TriangleMesh& mesh, std::span<const std::int32_t> label_of_triangle,
                    const BorderLines& borders, const RenderOptions& options, const Execution& execution) {
  const Picture picture = picture_of_labels(mesh, label_of_triangle, borders);
  return std::move(render(mesh, {&picture, 1}, options, execution).front());
}

Image render_scalar(const TriangleMesh& mesh, std::span<const double> value_of_vertex, const std::string& name,
                    const std::string& scalar_unit, const BorderLines& borders, const std::optional<ColourMap>& map,
                    const RenderOptions& options, const Execution& execution) {
  const Picture picture = picture_of_scalar(mesh, value_of_vertex, name, scalar_unit, borders, map);
  return std::move(render(mesh, {&picture, 1}, options, execution).front());
}

Image render_shape(const TriangleMesh& mesh, const BorderLines& borders, const RenderOptions& options,
                   const Execution& execution) {
  const Picture picture = picture_of_shape(mesh, borders);
  return std::move(render(mesh, {&picture, 1}, options, execution).front());
}

}  // namespace meshmser
