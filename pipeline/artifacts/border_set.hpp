#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace meshmser {

/// A level edge has a triangle outside the region behind it; a hole edge is the mesh's own rim.
enum class EdgeKind : std::uint8_t { kLevel, kHole };

/// Closed oriented cycles of half-edges, the region on the left (definitions 10). Loop l has the half-edges
/// first_edge_of_loop[l] .. first_edge_of_loop[l + 1]; it starts at its smallest level half-edge.
struct BorderLoops {
  std::vector<std::int32_t> owner_of_loop;         ///< #L: region number or label, from 1; ascending
  std::vector<std::int64_t> first_edge_of_loop;    ///< #L + 1
  std::vector<std::int32_t> half_edges;            ///< #E: 3 t + k
  std::vector<EdgeKind> kinds;                     ///< #E
  std::vector<std::int32_t> neighbours;            ///< #E: number behind the edge: region or label; 0 background, -1 hole
  std::vector<double> level_length_of_loop;        ///< #L
  std::vector<double> hole_length_of_loop;         ///< #L
  std::int64_t num_hole_loops_dropped = 0;         ///< loops of hole edges alone

  std::size_t num_loops() const { return owner_of_loop.size(); }

  template <class Self, class Visitor>
  static void visit(Self& self, Visitor&& field) {
    field("owner_of_loop", self.owner_of_loop);
    field("first_edge_of_loop", self.first_edge_of_loop);
    field("half_edges", self.half_edges);
    field("kinds", self.kinds);
    field("neighbours", self.neighbours);
    field("level_length_of_loop", self.level_length_of_loop);
    field("hole_length_of_loop", self.hole_length_of_loop);
    field("num_hole_loops_dropped", self.num_hole_loops_dropped);
  }
};

/// Closed curves off the mesh edges; curve l belongs to loop l of the regions' loops.
struct BorderCurves {
  std::vector<std::int64_t> first_point_of_curve;  ///< #L + 1
  std::vector<Eigen::Vector3d> points;             ///< minus the mesh's origin; the last is joined to the first
  std::vector<EdgeKind> kinds;                     ///< of the piece from this point to the next

  template <class Self, class Visitor>
  static void visit(Self& self, Visitor&& field) {
    field("first_point_of_curve", self.first_point_of_curve);
    field("points", self.points);
    field("kinds", self.kinds);
  }
};

struct BorderSet {
  BorderLoops regions;         ///< of every region, nested ones included
  BorderLoops labels;          ///< of the final label patches
  BorderCurves interpolated;   ///< of the regions: sub-triangle level lines; empty unless asked for
  BorderCurves smooth;         ///< the interpolated curves, smoothed within `smooth_tolerance`; empty unless asked for
  double smooth_tolerance = 0; ///< in coordinate units

  template <class Self, class Visitor>
  static void visit(Self& self, Visitor&& field) {
    field("regions", self.regions);
    field("labels", self.labels);
    field("interpolated", self.interpolated);
    field("smooth", self.smooth);
    field("smooth_tolerance", self.smooth_tolerance);
  }
};

}  // namespace meshmser
