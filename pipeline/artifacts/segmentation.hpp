#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/artifacts/level_set_trees.hpp"
#include "pipeline/artifacts/node_fate.hpp"

namespace meshmser {

/// A selected node that passed the filters (definitions 7, 8).
struct Region {
  Polarity polarity = Polarity::kUpper;
  std::int32_t node = -1;           ///< in the tree of its polarity
  std::int32_t parent = -1;         ///< label of the smallest region of the same polarity that contains it; -1: none
  std::int32_t low_level = 0;       ///< lo of definitions 6, from 1
  std::int32_t high_level = 0;      ///< hi
  double value = 0;                 ///< h at lo, as a value of S (not of -S)
  std::int64_t num_triangles = 0;
  double area = 0;                  ///< in coordinate units squared
  double stability = 0;             ///< q: 0 is perfectly stable; infinite for zero area
  double persistence = 0;           ///< of its highest maximum, in units of S
  double contrast = 0;              ///< mean step of S across the level part of the border
  double scalar_mean = 0, scalar_min = 0, scalar_max = 0, scalar_deviation = 0;  ///< area-weighted over its triangles
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();  ///< minus the mesh's origin
  Eigen::Vector3d mean_normal = Eigen::Vector3d::Zero();

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

/// Regions and the labels that come of them (definitions 9). Region i bears the number i + 1 before splitting and growing.
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
