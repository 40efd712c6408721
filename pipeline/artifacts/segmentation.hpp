#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "pipeline/artifacts/level_set_trees.hpp"
#include "pipeline/artifacts/node_fate.hpp"

namespace meshmser {

enum class FittedShape : std::uint8_t { kNone, kPlane, kSphere, kCylinder };

/// As tables spell it.
inline const char* name_of(FittedShape shape) {
  switch (shape) {
    case FittedShape::kPlane:
      return "plane";
    case FittedShape::kSphere:
      return "sphere";
    case FittedShape::kCylinder:
      return "cylinder";
    case FittedShape::kNone:
      break;
  }
  return "none";
}

/// A selected node that passed the filters (definitions 7, 8).
struct Region {
  Polarity polarity = Polarity::kUpper;  ///< the side of its node: upper or lower
  std::int32_t node = -1;       ///< in the tree that has_side(polarity)
  std::int32_t parent = -1;     ///< label of the smallest region of the same tree that contains it; -1: none
  std::int32_t low_level = 0;   ///< lo of definitions 6, from 1
  std::int32_t high_level = 0;  ///< hi
  double value = 0;             ///< S on its line: h at lo (not of -S), of a shape the level of its outermost line
  std::int64_t num_triangles = 0;
  double area = 0;         ///< in coordinate units squared
  double stability = 0;    ///< q: 0 is perfectly stable; infinite for zero area
  double persistence = 0;  ///< of its highest maximum, in units of S
  double contrast = 0;     ///< mean step of S across the level part of the border
  double scalar_mean = 0, scalar_min = 0, scalar_max = 0, scalar_deviation = 0;  ///< area-weighted over its triangles
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();                            ///< minus the mesh's origin
  Eigen::Vector3d mean_normal = Eigen::Vector3d::Zero();
  double level_length = 0;  ///< of the border where a triangle outside lies behind it
  double hole_length = 0;   ///< of the border along the mesh's own rim, inner loops included
  std::int32_t depth = 0;   ///< how many regions of the same tree contain it
  std::int64_t euler = 0;   ///< 1 for a disc, 1 less for each hole in it; see NodeAttributes
  double flatness = 0;      ///< length of the integral of the normal over area: 1 on a plane
  Eigen::Vector3d box_min = Eigen::Vector3d::Zero(), box_max = Eigen::Vector3d::Zero();  ///< minus the origin
  /// Unit, right-handed: where its area spreads most, next and least.
  Eigen::Vector3d axis_1 = Eigen::Vector3d::Zero(), axis_2 = Eigen::Vector3d::Zero(), axis_3 = Eigen::Vector3d::Zero();
  Eigen::Vector3d spread = Eigen::Vector3d::Zero();  ///< standard deviation along the axes
  FittedShape best_fit = FittedShape::kNone;         ///< by residual and number of parameters; see fit_shapes
  double plane_residual = kUnknown;                  ///< root mean square distance; NaN: too few points
  double sphere_residual = kUnknown, sphere_radius = kUnknown;          ///< radius < 0: seen from within
  Eigen::Vector3d sphere_centre = Eigen::Vector3d::Constant(kUnknown);  ///< minus the origin
  double cylinder_residual = kUnknown, cylinder_radius = kUnknown;
  Eigen::Vector3d cylinder_point = Eigen::Vector3d::Constant(kUnknown);  ///< of the axis, minus the origin
  Eigen::Vector3d cylinder_axis = Eigen::Vector3d::Constant(kUnknown);

  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

  template <class Self, class Visitor>
  static void visit(Self& self, Visitor&& field) {
    field("polarity", self.polarity);
    field("node", self.node);
    field("parent", self.parent);
    field("low_level", self.low_level);
    field("high_level", self.high_level);
    field("value", self.value);
    field("num_triangles", self.num_triangles);
    field("area", self.area);
    field("stability", self.stability);
    field("persistence", self.persistence);
    field("contrast", self.contrast);
    field("scalar_mean", self.scalar_mean);
    field("scalar_min", self.scalar_min);
    field("scalar_max", self.scalar_max);
    field("scalar_deviation", self.scalar_deviation);
    field("centroid", self.centroid);
    field("mean_normal", self.mean_normal);
    field("level_length", self.level_length);
    field("hole_length", self.hole_length);
    field("depth", self.depth);
    field("euler", self.euler);
    field("flatness", self.flatness);
    field("box_min", self.box_min);
    field("box_max", self.box_max);
    field("axis_1", self.axis_1);
    field("axis_2", self.axis_2);
    field("axis_3", self.axis_3);
    field("spread", self.spread);
    field("best_fit", self.best_fit);
    field("plane_residual", self.plane_residual);
    field("sphere_residual", self.sphere_residual);
    field("sphere_radius", self.sphere_radius);
    field("sphere_centre", self.sphere_centre);
    field("cylinder_residual", self.cylinder_residual);
    field("cylinder_radius", self.cylinder_radius);
    field("cylinder_point", self.cylinder_point);
    field("cylinder_axis", self.cylinder_axis);
  }
};

/// What one filter saw and removed.
struct FilterCount {
  std::string filter;
  std::int64_t seen = 0, removed = 0;

  template <class Self, class Visitor>
  static void visit(Self& self, Visitor&& field) {
    field("filter", self.filter);
    field("seen", self.seen);
    field("removed", self.removed);
  }
};

/// Regions and the labels that come of them (definitions 9). Region i bears the number i + 1 before splitting and
/// growing.
struct Segmentation {
  std::vector<Region> regions;                       ///< by decreasing area, then smallest triangle id
  std::vector<std::int32_t> region_of_triangle;      ///< #F: 1 + index of the smallest region that contains it; 0: none
  std::vector<std::int32_t> label_of_triangle;       ///< #F: final label, after split, growth and merging; 0: background
  std::vector<std::int32_t> region_of_label;         ///< #L + 1: 1 + index of the region the label came from; [0] is 0
  std::vector<double> area_of_label;                 ///< #L + 1
  std::vector<FilterCount> filters;                  ///< in the order applied
  std::vector<TreeFates> fates;                      ///< one for each tree, in their order; empty: not recorded

  template <class Self, class Visitor>
  static void visit(Self& self, Visitor&& field) {
    field("regions", self.regions);
    field("region_of_triangle", self.region_of_triangle);
    field("label_of_triangle", self.label_of_triangle);
    field("region_of_label", self.region_of_label);
    field("area_of_label", self.area_of_label);
    field("filters", self.filters);
    field("fates", self.fates);
  }
};

}  // namespace meshmser
