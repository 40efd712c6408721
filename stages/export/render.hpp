#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pipeline/artifacts/border_set.hpp"
#include "pipeline/artifacts/triangle_mesh.hpp"
#include "pipeline/execution/execution.hpp"
#include "stages/common/colours.hpp"
#include "stages/export/image.hpp"
#include "stages/export/views.hpp"

namespace meshmser {

/// Border lines to draw over the mesh where it does not hide them.
struct BorderLines {
  struct Segment {
    Eigen::Vector3d from, to;  ///< minus the mesh's origin
    EdgeKind kind;
  };
  std::vector<Segment> segments;

  /// Every half-edge of the loops.
  static BorderLines of_loops(const TriangleMesh& mesh, const BorderLoops& loops);
  /// Every piece of the closed curves.
  static BorderLines of_curves(const BorderCurves& curves);
};

struct RenderOptions {
  std::vector<std::string> views;  ///< names; empty: default_views
  int panel_width = 900;           ///< pixels a view
  int panel_height = 700;
  std::string unit;             ///< of the coordinates, written at the scale bar
  std::string title;            ///< one line above the views; empty: none
  double light_azimuth = 135;   ///< degrees, of the raking light, counter-clockwise from the picture's right
  double light_elevation = 28;  ///< degrees above the picture's plane: low light shows shallow relief
  int ambient_rays = 4;         ///< per pixel; 0: no ambient occlusion
};

/// What tells one picture of a mesh from another.
struct Picture {
  /// Colour of the point with weights u, v of corners 1 and 2 of a triangle.
  std::function<Colour(std::int32_t triangle, double u, double v)> colour_at;
  BorderLines lines;  ///< dark level edges, violet hole edges
  /// Draws what explains the colours, its upper left corner at (x, y); returns where it ends.
  std::function<int(Image& image, int x, int y)> legend;
};

/// One colour per label (#F, from 0). Pictures refer to the mesh and to what they are given.
Picture picture_of_labels(const TriangleMesh& mesh, std::span<const std::int32_t> label_of_triangle,
                          BorderLines borders);
/// Coloured by a value per vertex (#V; NaN grey), interpolated linearly within each triangle, with a colour bar that
/// bears `name` and `unit` of the scalar. `map`: none: ColourMap::of_values.
Picture picture_of_scalar(const TriangleMesh& mesh, std::span<const double> value_of_vertex, const std::string& name,
                          const std::string& scalar_unit, BorderLines borders,
                          const std::optional<ColourMap>& map = {});
/// In one colour: the shape alone.
Picture picture_of_shape(const TriangleMesh& mesh, BorderLines borders);

/// Draws several pictures of the same mesh at little more than the cost of one, each with the views side by side, name
/// and scale bar in each, and a legend below. Result: in the order of `pictures`. Throws UsageError for an unknown
/// view, StageError for a mesh without triangles. O(F log F + pixels log F); the same bytes for any number of threads.
std::vector<Image> render(const TriangleMesh& mesh, std::span<const Picture> pictures,
                          const RenderOptions& options = {}, const Execution& execution = {});

/// render of one picture_of_labels, picture_of_scalar, picture_of_shape.
Image render_labels(const TriangleMesh& mesh, std::span<const std::int32_t> label_of_triangle,
                    const BorderLines& borders, const RenderOptions& options = {}, const Execution& execution = {});
Image render_scalar(const TriangleMesh& mesh, std::span<const double> value_of_vertex, const std::string& name,
                    const std::string& scalar_unit, const BorderLines& borders,
                    const std::optional<ColourMap>& map = {}, const RenderOptions& options = {},
                    const Execution& execution = {});
Image render_shape(const TriangleMesh& mesh, const BorderLines& borders, const RenderOptions& options = {},
                   const Execution& execution = {});

}  // namespace meshmser
