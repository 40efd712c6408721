#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/artifacts/property.hpp"

namespace meshmser {

/// One pass of the scanner: one input file, or one range map.
struct Scan {
  std::string name;                                ///< file name without folder
  std::optional<Eigen::Vector3d> scanner_position; ///< minus the cloud's origin, after the pose
  std::int64_t num_raw_points = 0;

  template <class Self, class Visitor>
  static void visit(Self& self, Visitor&& field) {
    field("name", self.name);
    field("scanner_position", self.scanner_position);
    field("num_raw_points", self.num_raw_points);
  }
};

/// Why a raw point is not a point of the cloud.
enum class DropReason : std::uint8_t { kDuplicate, kNonFinite, kCropped, kOutlier };

/// Points in canonical order (definitions 1): by Morton code, then x, y, z, then scan. Their positions in the arrays are
/// their ids, whatever the order of the file. A point keeps its raw index: its place in the concatenated input files.
struct PointCloud {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< was subtracted from every coordinate
  double spacing = 0;                                ///< h of definitions 1, in coordinate units; 0 for fewer than 17 points
  std::vector<Eigen::Vector3d> positions;            ///< #P, minus the origin
  std::vector<std::int64_t> raw_index_of_point;      ///< #P
  std::vector<std::uint32_t> scan_of_point;          ///< #P, index into scans
  std::vector<Scan> scans;
  std::vector<Property> properties;                  ///< each #P values
  std::int64_t num_raw_points = 0;                   ///< points in the input files

  // Raw points that are not points of the cloud, by ascending raw index. Their property values are not kept.
  std::vector<std::int64_t> dropped_raw_index;           ///< #D
  std::vector<Eigen::Vector3d> dropped_positions;        ///< #D, minus the origin
  std::vector<DropReason> drop_reasons;                  ///< #D
  std::vector<std::int32_t> kept_point_of_dropped;       ///< #D: of a duplicate the point that stands for it, else -1

  std::size_t num_points() const { return positions.size(); }

  template <class Self, class Visitor>
  static void visit(Self& self, Visitor&& field) {
    field("origin", self.origin);
    field("spacing", self.spacing);
    field("positions", self.positions);
    field("raw_index_of_point", self.raw_index_of_point);
    field("scan_of_point", self.scan_of_point);
    field("scans", self.scans);
    field("properties", self.properties);
    field("num_raw_points", self.num_raw_points);
    field("dropped_raw_index", self.dropped_raw_index);
    field("dropped_positions", self.dropped_positions);
    field("drop_reasons", self.drop_reasons);
    field("kept_point_of_dropped", self.kept_point_of_dropped);
  }
};

}  // namespace meshmser
