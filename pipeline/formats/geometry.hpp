#pragma once
/// What a user's file holds, before any stage has looked at it.

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/artifacts/property.hpp"

namespace meshmser {

/// Properties of points that come from a scanner's grid: the scan line and the place along it, from 0. In a range map
/// these are row and column; in a PTX file the line is what Leica calls a column and Photoneo a row.
inline constexpr const char* kGridLine = "scan_line";
inline constexpr const char* kGridPlace = "scan_place";

/// The vertices (or points) and faces of one file, or of one scan of a file that holds several, in the file's order and
/// frame. Nothing is merged, dropped or checked but what the format itself demands: indices are in range, every
/// property has one value per vertex, faces have at least three corners.
struct Geometry {
  std::string name;                                ///< file name without folder; of several scans with ` #1`, ` #2` ...
  std::vector<Eigen::Vector3d> positions;          ///< #V; may hold non-finite values
  std::vector<Property> properties;                ///< each #V values
  std::vector<std::int64_t> first_corner_of_face;  ///< #F + 1, or empty: no faces
  std::vector<std::int32_t> corners;               ///< vertex of each corner, faces one after the other
  std::optional<Eigen::Vector3d> scanner_position;  ///< where the file says it
  std::optional<Eigen::Vector3d> view_direction;    ///< toward a far-away scanner, where the format implies it
  bool loose_facets = false;                        ///< each face has vertices of its own (STL): equal ones are one
  std::int64_t num_skipped_lines = 0;               ///< bad lines left out on request
  std::int64_t num_empty_cells = 0;                 ///< of a scan grid: cells without a measured point

  std::size_t num_vertices() const { return positions.size(); }
  std::size_t num_faces() const { return first_corner_of_face.empty() ? 0 : first_corner_of_face.size() - 1; }
};

}  // namespace meshmser
