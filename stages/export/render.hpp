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
#include "stages/export/colours.hpp"
#include "stages/export/image.hpp"

namespace meshmser {

/// A direction to look along. Cameras are orthographic: lengths can be measured anywhere in the picture.
struct View {
  std::string name;
  Eigen::Vector3d direction;  ///< from the eye to the object, unit length
  Eigen::Vector3d up;         ///< upward in the picture, at right angles to `direction`
};

/// Names that view_of_name knows: front (looking along +y), back, left, right, top, bottom, iso, iso_back, iso_below,
/// best.
const std::vector<std::string>& view_names();

/// The view called `name`. `best` looks at a sheet-like mesh along its mean normal (walls at its rim left out), with
/// the scan's own y up, and at a solid like iso. Throws UsageError for an unknown name.
View view_of_name(const std::string& name, const TriangleMesh& mesh);

/// What shows a mesh well: best alone for a sheet-like mesh (area-weighted mean normal longer than 0.5), else iso,
/// iso_back, top and iso_below.
std::vector<std::string> default_views(const TriangleMesh& mesh);

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
  int ambient_rays = 6;         ///< per pixel; 0: no ambient occlusion
};

/// Draws the mesh, one colour per label, with the borders of the labels: dark level edges, violet hole edges.
/// `label_of_triangle`: #F. `borders`: none: no lines. Result: the views side by side, each with name and scale bar,
/// and a legend below. Throws UsageError for an unknown view, StageError for a mesh without triangles. O(F log F +
/// pixels log F); the same bytes for any number of threads.
Image render_labels(const TriangleMesh& mesh, std::span<const std::int32_t> label_of_triangle,
                    const BorderLines& borders, const RenderOptions& options = {}, const Execution& execution = {});

/// Draws the mesh coloured by a value per vertex (#V; NaN grey), with a colour bar that bears `name` and `unit` of the
/// scalar; interpolated linearly within each triangle. `map`: none: ColourMap::of_values. Otherwise as render_labels.
Image render_scalar(const TriangleMesh& mesh, std::span<const double> value_of_vertex, const std::string& name,
                    const std::string& scalar_unit, const BorderLines& borders,
                    const std::optional<ColourMap>& map = {}, const RenderOptions& options = {},
                    const Execution& execution = {});

/// Draws the mesh in one colour: its shape alone. Otherwise as render_labels.
Image render_shape(const TriangleMesh& mesh, const BorderLines& borders, const RenderOptions& options = {},
                   const Execution& execution = {});

}  // namespace meshmser
