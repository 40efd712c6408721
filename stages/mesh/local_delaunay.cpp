#include "stages/mesh/local_delaunay.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <utility>

#include "stages/common/parallel.hpp"
#include "stages/mesh/voronoi_stars.hpp"

namespace meshmser {
namespace {

using Eigen::Vector3d;

constexpr std::int64_t kGrain = 1 << 14;

std::size_t at(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

/// A triangle that not all of its corners found.
struct Candidate {
  double squared_radius;  ///< of its circumcircle
  Triangle corners;       ///< least first
  bool operator<(const Candidate& other) const {
    if (squared_radius != other.squared_radius) return squared_radius < other.squared_radius;
    return corners < other.corners;
  }
};

double squared_circumradius(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const double ab = (b - a).squaredNorm(), bc = (c - b).squaredNorm(), ca = (a - c).squaredNorm();
  const double squared_twice_area = (b - a).cross(c - a).squaredNorm();
  return ab * bc * ca / (4 * squared_twice_area);
}

/// The taken triangles around each point: those in its star, and those that only the others found.
class TakenTriangles {
 public:
  TakenTriangles(VoronoiStars& stars, const std::vector<Vector3d>& positions, const std::vector<Vector3d>& normals)
      : stars_(stars), positions_(positions), normals_(normals), first_extra_(positions.size(), -1) {}

  /// Takes the triangle if it shares so many edges with taken ones, uses none twice in one direction and overlaps none.
  bool try_take(const Triangle& t, int least_shared) {
    int shared = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      if (uses(t[k], t[(k + 1) % 3])) return false;
      shared += uses(t[(k + 1) % 3], t[k]) ? 1 : 0;
    }
    if (shared < least_shared) return false;
    for (std::size_t k = 0; k < 3; ++k)
      if (overlaps(t[k], t[(k + 1) % 3], t[(k + 2) % 3])) return false;
    for (std::size_t k = 0; k < 3; ++k) take_at(t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
    return true;
  }

 private:
  struct Extra {
    std::int32_t next_corner, last_corner;
    std::int32_t next_extra;
  };
  struct Sector {
    double begin, width;
  };

  template <class Body>
  void for_each_taken(std::int32_t p, Body&& body) const {
    for (std::int64_t slot = stars_.begin(p); slot < stars_.end(p); ++slot)
      if (stars_.state(slot) == VoronoiStars::kTaken)
        body(stars_.neighbour(slot), stars_.neighbour(stars_.after(p, slot)));
    for (std::int32_t extra = first_extra_[at(p)]; extra >= 0; extra = extras_[at(extra)].next_extra)
      body(extras_[at(extra)].next_corner, extras_[at(extra)].last_corner);
  }
  /// Whether the half-edge from p to q is taken.
  bool uses(std::int32_t p, std::int32_t q) const {
    bool found = false;
    for_each_taken(p, [&](std::int32_t next, std::int32_t) { found = found || next == q; });
    return found;
  }
  void take_at(std::int32_t p, std::int32_t next, std::int32_t last) {
    const std::int64_t slot = stars_.find(p, next);
    if (slot >= 0 && stars_.state(slot) != VoronoiStars::kGap && stars_.neighbour(stars_.after(p, slot)) == last) {
      stars_.state(slot) = VoronoiStars::kTaken;
    } else {
      extras_.push_back({next, last, first_extra_[at(p)]});
      first_extra_[at(p)] = static_cast<std::int32_t>(extras_.size()) - 1;
    }
  }
  /// Whether the triangle (p, next, last) runs against p's normal or into a taken triangle around p.
  bool overlaps(std::int32_t p, std::int32_t next, std::int32_t last) const {
    if (normals_[at(p)].isZero(0)) return false;
    Vector3d u, v;
    tangent_frame(normals_[at(p)], u, v);
    const auto direction = [&](std::int32_t q) {
      const Vector3d offset = positions_[at(q)] - positions_[at(p)];
      return std::atan2(offset.dot(v), offset.dot(u));
    };
    const auto turn = [](double from, double to) { return to >= from ? to - from : to - from + 2 * std::numbers::pi; };
    const double begin = direction(next), width = turn(begin, direction(last));
    if (!(width < std::numbers::pi)) return true;
    bool hit = false;
    for_each_taken(p, [&](std::int32_t other_next, std::int32_t other_last) {
      const double other_begin = direction(other_next), other_width = turn(other_begin, direction(other_last));
      // Two sectors are disjoint where each begins after the other has ended.
      const bool after = other_next == last || turn(begin, other_begin) >= width;
      const bool before = other_last == next || turn(other_begin, begin) >= other_width;
      hit = hit || !after || !before;
    });
    return hit;
  }

  VoronoiStars& stars_;
  const std::vector<Vector3d>& positions_;
  const std::vector<Vector3d>& normals_;
  std::vector<std::int32_t> first_extra_;
  std::vector<Extra> extras_;
};

}  // namespace

std::vector<Triangle> local_delaunay(const std::vector<Vector3d>& positions, const std::vector<Vector3d>& normals,
                                     double spacing, double max_edge, const Execution& execution,
                                     LocalDelaunayCounts* counts) {
  VoronoiStars stars = make_voronoi_stars(positions, normals, spacing, max_edge, execution);
  const auto num_points = static_cast<std::int64_t>(positions.size());

  // A star is read while its neighbours are looked at from other threads, so agreement is marked in a copy.
  struct Chunk {
    std::vector<Triangle> agreed;
    std::vector<Candidate> twice, once;
  };
  std::vector<Chunk> chunks(static_cast<std::size_t>((num_points + kGrain - 1) / kGrain));
  std::vector<std::uint8_t> states = stars.states;
  const auto finds = [&](std::int32_t p, std::int32_t next, std::int32_t last) {
    const std::int64_t slot = stars.find(p, next);
    return slot >= 0 && stars.state(slot) == VoronoiStars::kFound && stars.neighbour(stars.after(p, slot)) == last;
  };
  const auto candidate = [&](std::int32_t p, std::int32_t q, std::int32_t r) {
    return Candidate{squared_circumradius(positions[at(p)], positions[at(q)], positions[at(r)]),
                     least_corner_first({p, q, r})};
  };
  parallel_chunks(num_points, kGrain, "compare triangles", execution, [&](std::int64_t begin, std::int64_t end) {
    Chunk& chunk = chunks[static_cast<std::size_t>(begin / kGrain)];
    for (auto p = static_cast<std::int32_t>(begin); p < end; ++p) {
      const auto first_of_p = static_cast<std::ptrdiff_t>(chunk.agreed.size());
      for (std::int64_t slot = stars.begin(p); slot < stars.end(p); ++slot) {
        if (stars.state(slot) != VoronoiStars::kFound) continue;
        const std::int32_t q = stars.neighbour(slot), r = stars.neighbour(stars.after(p, slot));
        const bool by_q = finds(q, r, p), by_r = finds(r, p, q);
        if (by_q && by_r) {
          states[static_cast<std::size_t>(slot)] = VoronoiStars::kTaken;
          if (p < q && p < r) chunk.agreed.push_back({p, q, r});
        } else if (!by_q && !by_r) {
          chunk.once.push_back(candidate(p, q, r));
        } else if ((by_q && p < q) || (by_r && p < r)) {
          chunk.twice.push_back(candidate(p, q, r));
        }
      }
      std::sort(chunk.agreed.begin() + first_of_p, chunk.agreed.end());
    }
  });
  stars.states = std::move(states);

  std::size_t num_agreed = 0, num_twice = 0, num_once = 0;
  for (const Chunk& chunk : chunks) {
    num_agreed += chunk.agreed.size();
    num_twice += chunk.twice.size();
    num_once += chunk.once.size();
  }
  std::vector<Triangle> triangles;
  std::vector<Candidate> twice, once;
  triangles.reserve(num_agreed + num_twice + num_once);
  twice.reserve(num_twice);
  once.reserve(num_once);
  for (Chunk& chunk : chunks) {
    triangles.insert(triangles.end(), chunk.agreed.begin(), chunk.agreed.end());
    twice.insert(twice.end(), chunk.twice.begin(), chunk.twice.end());
    once.insert(once.end(), chunk.once.begin(), chunk.once.end());
    chunk = {};
  }
  std::sort(twice.begin(), twice.end());
  std::sort(once.begin(), once.end());

  TakenTriangles taken(stars, positions, normals);
  // Goes over the candidates until none fits any more; gives the number taken.
  const auto take = [&](std::vector<Candidate>& candidates, int least_shared) {
    const std::size_t before = triangles.size();
    for (bool any = true; any;) {
      any = false;
      std::size_t kept = 0;
      for (std::size_t i = 0; i < candidates.size(); ++i) {
        if (i % kGrain == 0) execution.report("take triangles found twice or once", 0, 0);
        if (taken.try_take(candidates[i].corners, least_shared)) {
          triangles.push_back(candidates[i].corners);
          any = true;
        } else {
          candidates[kept++] = candidates[i];
        }
      }
      candidates.resize(kept);
    }
    return static_cast<std::int64_t>(triangles.size() - before);
  };
  const std::int64_t by_two = take(twice, 1), by_one = take(once, 2) + take(once, 1);
  if (counts != nullptr) {
    counts->by_three = static_cast<std::int64_t>(num_agreed);
    counts->by_two = by_two;
    counts->by_one = by_one;
    counts->refused = static_cast<std::int64_t>(twice.size() + once.size());
  }
  sort_added_triangles(triangles, num_agreed);
  return triangles;
}

}  // namespace meshmser
