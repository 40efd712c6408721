#pragma once
/// From component trees to regions and labels: selection, filters, labels, growth and merging in the order of
/// definitions 7 to 9.

#include <cstdint>
#include <limits>
#include <span>

#include "pipeline/artifacts/level_set_trees.hpp"
#include "pipeline/artifacts/segmentation.hpp"
#include "pipeline/execution/execution.hpp"
#include "stages/common/surface.hpp"
#include "stages/mser/describe_regions.hpp"
#include "stages/mser/filters.hpp"
#include "stages/mser/select_mser.hpp"

namespace meshmser {

enum class Select : std::uint8_t { kMser, kPersistence, kStableBranch, kLength, kLevel, kMeaningful };
enum class Grow : std::uint8_t { kNone, kAbsorb, kWatershed, kLevel };
enum class FloodBy : std::uint8_t { kStrength, kFacets, kLikeness };
enum class Border : std::uint8_t { kFlood, kSides };
enum class Merge : std::uint8_t { kNone, kSaliency, kTurning };

/// Areas in coordinate units squared, lengths in coordinate units, scalars in units of S.
struct SegmentParameters {
  Select select = Select::kMser;
  std::int32_t delta = 3;  ///< level steps
  double delta_value = 0;  ///< > 0: in units of S, in place of level steps
  Against against = Against::kChildren;

  double min_length = 0;        ///< kLength: of a level line, in coordinate units
  double level = 0;             ///< kLevel: in units of S
  double max_false_alarms = 1;  ///< kMeaningful: expected number of lines by chance
  double independent = 0;       ///< kMeaningful: distance from which gradients along a line are independent

  // Filters, in this order. For persistence and stable_branch min_area and min_persistence say which maxima are
  // significant instead.
  double min_area = 0;
  double max_area = std::numeric_limits<double>::infinity();
  double max_variation = std::numeric_limits<double>::infinity();
  double min_persistence = 0;
  double min_contrast = 0;  ///< times the noise of S
  double band = 0;          ///< on each side of the border, for the contrast
  double min_diversity = 0;
  Nested nested = Nested::kKeep;
  std::int64_t keep_largest = 0;  ///< 0: all

  Grow grow = Grow::kNone;
  double absorb_area = 0;  ///< patches below this join a neighbour, unless grow is none
  FloodBy flood_by = FloodBy::kStrength;
  double flood_width = 0;  ///< for facets: see flood_facets
  Border border = Border::kFlood;
  double side_radius = 0;  ///< > 0 for borders by sides: see fit_borders
  double spacing = 0;      ///< > 0 for borders by sides: h
  Merge merge = Merge::kNone;
  double saliency = 0;
  double turning = 6 * 0.017453292519943295;  ///< radians
  double turning_radius = 0;                  ///< > 0 for merging by turning
};

/// What is segmented. Spans may be empty where marked optional.
struct SegmentInputs {
  SurfaceView surface;  ///< twins after cut_out_triangles of what the trees exclude
  const LevelSetTrees& level_sets;
  std::span<const double> strength;   ///< optional, #V, >= 0: what borders are strong in; else |S|
  std::span<const double> curvature;  ///< optional, #V, >= 0: greatest principal curvature, for facets and turning
  std::span<const Eigen::Vector3d> normals;  ///< #V unit normals, for facets
};

/// The contrast of nodes of a tree, by node ascending, as border_contrasts gives it.
struct Contrasts {
  std::vector<std::int32_t> nodes;
  std::vector<double> values;

  /// Of a node; NaN: not measured.
  double of(std::int32_t node) const;
};

/// What selection and filters make of the trees.
struct RegionSelection {
  std::vector<TreeSelection> selections;  ///< one for each tree
  std::vector<Contrasts> contrasts;       ///< one for each tree: of the nodes that came as far as being measured
  std::vector<SelectedNode> regions;      ///< in the order of order_regions; keep_largest has been applied
  std::vector<FilterCount> filters;       ///< in the order applied
};

/// The first half of segment(): which nodes are regions. `fates`, where given, becomes one list for each tree, which
/// tells of every node whether it is a region, or what decided that it is none. Throws as segment().
RegionSelection select_regions(const SegmentInputs& inputs, const SegmentParameters& parameters,
                               std::vector<NodeFates>* fates = nullptr, const Execution& execution = {});

/// Segments a surface by the level sets of a scalar on it. Regions and labels are numbered from 1 by decreasing area,
/// then smallest triangle id. Throws StageError where the arrays' sizes differ or a parameter is out of range.
/// Linear in the mesh but for sorting regions and for what contrast and turning look at. Fates are recorded on request.
Segmentation segment(const SegmentInputs& inputs, const SegmentParameters& parameters, const Execution& execution = {},
                     bool record_fates = false);

}  // namespace meshmser
