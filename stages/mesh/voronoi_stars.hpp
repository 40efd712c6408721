#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "pipeline/execution/execution.hpp"

namespace meshmser {

/// The neighbours of each point's Voronoi cell in its own tangent plane, counter-clockwise about its normal.
struct VoronoiStars {
  enum State : std::uint8_t { kGap, kFound, kTaken };
  std::vector<std::int64_t> first;       ///< #P + 1
  std::vector<std::int32_t> neighbours;  ///< of point p: first[p] .. first[p + 1]
  std::vector<std::uint8_t> states;      ///< of the triangle (p, this neighbour, the next one around)

  std::int64_t begin(std::int32_t p) const { return first[static_cast<std::size_t>(p)]; }
  std::int64_t end(std::int32_t p) const { return first[static_cast<std::size_t>(p) + 1]; }
  std::int32_t neighbour(std::int64_t slot) const { return neighbours[static_cast<std::size_t>(slot)]; }
  std::uint8_t& state(std::int64_t slot) { return states[static_cast<std::size_t>(slot)]; }
  std::uint8_t state(std::int64_t slot) const { return states[static_cast<std::size_t>(slot)]; }
  /// The slot after this one around p.
  std::int64_t after(std::int32_t p, std::int64_t slot) const { return slot + 1 == end(p) ? begin(p) : slot + 1; }
  /// The slot of `q` around p, -1 if there is none.
  std::int64_t find(std::int32_t p, std::int32_t q) const {
    for (std::int64_t slot = begin(p); slot < end(p); ++slot)
      if (neighbour(slot) == q) return slot;
    return -1;
  }
};

/// Makes the stars of all points. Arguments as of local_delaunay. A slot is kFound where the two neighbours and the
/// point make a triangle with edges of at most `max_edge` and a circumradius (in the tangent plane) of at most 0.6
/// max_edge, else kGap; neighbours between two gaps are left out. Linear; deterministic for any number of threads.
VoronoiStars make_voronoi_stars(const std::vector<Eigen::Vector3d>& positions,
                                const std::vector<Eigen::Vector3d>& normals, double spacing, double max_edge,
                                const Execution& execution = {});

/// Two unit vectors that make a right-handed frame with a unit normal.
void tangent_frame(const Eigen::Vector3d& normal, Eigen::Vector3d& u, Eigen::Vector3d& v);

}  // namespace meshmser
