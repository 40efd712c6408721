#pragma once
/// The parameters of the stage mser as a configuration gives them.

#include <optional>
#include <string>

#include "pipeline/artifacts/triangle_mesh.hpp"
#include "pipeline/stage/quantities.hpp"
#include "stages/mser/segment.hpp"

namespace meshmser {

struct MserParameters {
  Select select = Select::kMser;
  std::int32_t delta = 3;
  std::optional<double> delta_value;
  Against against = Against::kChildren;
  std::optional<Length> min_length;
  std::optional<double> level;
  double max_false_alarms = 1;
  Length independent = spacings(6);
  Area min_area = spacings2(60);
  std::optional<Area> max_area;
  std::optional<double> max_variation;
  AutoOr<Amount> min_persistence;
  AutoOr<double> min_contrast;
  Length band = spacings(3);
  Share min_diversity{0.2};
  Nested nested = Nested::kKeep;
  std::optional<std::int64_t> keep_largest;
  Grow grow = Grow::kAbsorb;
  Area absorb = spacings2(20);
  FloodBy flood_by = FloodBy::kStrength;
  Length flood_width = spacings(40);
  std::string strength = "auto";
  Border border = Border::kFlood;
  Length side_radius = spacings(8);
  Merge merge = Merge::kNone;
  Amount saliency = noises(6);
  Angle turning{6};
  Length turning_radius = spacings(6);
};

/// The same in the units of a mesh and of the scalar of its trees. Throws StageError where an amount in noise is
/// needed and the noise is not known. One pass over the mesh.
SegmentParameters resolve(const MserParameters& given, const TriangleMesh& mesh, const LevelSetTrees& trees,
                          const Execution& execution);

}  // namespace meshmser
