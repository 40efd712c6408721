#include "stages/mesh/voronoi_stars.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "stages/common/parallel.hpp"
#include "stages/mesh/point_blocks.hpp"

namespace meshmser {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// The search radius over max_edge: circumcircles of up to max_edge in radius are seen to be empty.
constexpr double kSearchPerEdge = 2.0;
/// Largest weight of a point, in squared sides of a block: far above rounding errors, far below anything measured.
constexpr double kTieWeight = 1e-6;

/// A number in 0 .. 1 that depends on the point's index alone (SplitMix64).
double tie_weight(std::int32_t point) {
  auto x = static_cast<std::uint64_t>(point) + 0x9E3779B97F4A7C15u;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
  x ^= x >> 31;
  return static_cast<double>(x >> 11) * 0x1p-53;
}

/// A point by its squared distance, then its index.
using Neighbour = std::pair<double, std::int32_t>;
/// Nearest neighbours that are put in order first; enough for most cells.
constexpr std::size_t kFirstBatch = 24;

/// A convex polygon around the origin that shrinks to the Voronoi cell; each side remembers whose bisector it is.
class Cell {
 public:
  struct Corner {
    Vector2d at;
    std::int32_t side;  ///< the neighbour of the side that begins here; -1 for the frame
  };

  void start(double half_width) {
    const double w = half_width;
    corners_.assign({{{-w, -w}, -1}, {{w, -w}, -1}, {{w, w}, -1}, {{-w, w}, -1}});
    squared_radius_ = 2 * w * w;
  }
  /// Keeps the part of the cell where x . direction <= bound.
  void clip(const Vector2d& direction, double bound, std::int32_t side) {
    const std::size_t n = corners_.size();
    excess_.resize(n);
    bool any = false;
    for (std::size_t i = 0; i < n; ++i) {
      excess_[i] = corners_[i].at.dot(direction) - bound;
      any = any || excess_[i] > 0;
    }
    if (!any) return;
    next_.clear();
    squared_radius_ = 0;
    const auto add = [&](const Vector2d& at, std::int32_t of) {
      next_.push_back({at, of});
      squared_radius_ = std::max(squared_radius_, at.squaredNorm());
    };
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t j = i + 1 == n ? 0 : i + 1;
      const bool inside = excess_[i] <= 0, next_inside = excess_[j] <= 0;
      if (inside) add(corners_[i].at, corners_[i].side);
      if (inside == next_inside) continue;
      const double share = excess_[i] / (excess_[i] - excess_[j]);
      const Vector2d crossing = corners_[i].at + share * (corners_[j].at - corners_[i].at);
      // Leaving the kept half-plane the new side begins; entering it, the rest of the old side does.
      add(crossing, inside ? side : corners_[i].side);
    }
    corners_.swap(next_);
  }

  const std::vector<Corner>& corners() const { return corners_; }
  double squared_radius() const { return squared_radius_; }

 private:
  std::vector<Corner> corners_, next_;
  std::vector<double> excess_;
  double squared_radius_ = 0;
};

/// What one thread needs to make stars.
class StarMaker {
 public:
  StarMaker(const std::vector<Vector3d>& positions, const std::vector<Vector3d>& normals, const PointBlocks& blocks,
            double weight, double max_edge)
      : positions_(positions),
        normals_(normals),
        blocks_(blocks),
        weight_(weight),
        squared_max_edge_(max_edge * max_edge),
        reach_(kSearchPerEdge * max_edge) {}

  /// Appends the stars of the block's points: the neighbours, their states, and the number of neighbours of each point.
  void make_block(std::int64_t block, std::vector<std::int32_t>& neighbours, std::vector<std::uint8_t>& states,
                  std::vector<std::int32_t>& counts) {
    near_.clear();
    far_.clear();
    blocks_.gather(block, 1, near_);
    load(near_);
    bool loaded_far = false;
    for (const std::int32_t* p = blocks_.begin(block); p != blocks_.end(block); ++p) {
      const std::size_t before = neighbours.size();
      if (!normals_[at(*p)].isZero(0)) {
        if (loaded_far) {
          load(near_);
          loaded_far = false;
        }
        const double near_reach = std::min(blocks_.size(), reach_);
        if (start(*p, near_reach) && 4 * cell_.squared_radius() > near_reach * near_reach && near_reach < reach_) {
          if (far_.empty()) blocks_.gather(block, static_cast<int>(std::ceil(reach_ / blocks_.size())), far_);
          load(far_);
          loaded_far = true;
          widen(*p, near_reach);
        }
        finish(*p, neighbours, states);
      }
      counts.push_back(static_cast<std::int32_t>(neighbours.size() - before));
    }
  }

 private:
  static std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

  /// Copies the positions of some points side by side.
  void load(const std::vector<std::int32_t>& points) {
    loaded_ = &points;
    x_.resize(points.size());
    y_.resize(points.size());
    z_.resize(points.size());
    squared_.resize(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vector3d& p = positions_[at(points[i])];
      x_[i] = p.x();
      y_[i] = p.y();
      z_[i] = p.z();
    }
  }

  /// Collects the loaded points with low < distance <= high from p. False where an equal point of smaller index stands
  /// for p.
  bool collect(std::int32_t p, double low, double high) {
    const Vector3d centre = positions_[at(p)];
    const std::size_t n = loaded_->size();
    for (std::size_t i = 0; i < n; ++i) {
      const double dx = x_[i] - centre.x(), dy = y_[i] - centre.y(), dz = z_[i] - centre.z();
      squared_[i] = dx * dx + dy * dy + dz * dz;
    }
    candidates_.clear();
    const double squared_low = low > 0 ? low * low : -1, squared_high = high * high;
    for (std::size_t i = 0; i < n; ++i) {
      if (!(squared_[i] <= squared_high) || squared_[i] <= squared_low) continue;
      const std::int32_t q = (*loaded_)[i];
      if (squared_[i] == 0 && q < p) return false;
      if (squared_[i] > 0) candidates_.emplace_back(squared_[i], q);
    }
    return true;
  }

  /// Clips the cell by the bisectors with the collected points, nearest first, until no farther one can matter. They
  /// are put in order batch by batch, so that a dense spot costs no more than looking at its points.
  void clip_by_candidates(std::int32_t p) {
    const Vector3d &centre = positions_[at(p)], &normal = normals_[at(p)];
    const double own = weight_ * tie_weight(p);
    auto begin = candidates_.begin();
    for (std::size_t batch = kFirstBatch; begin != candidates_.end(); batch *= 2) {
      auto end = candidates_.end();
      if (static_cast<std::size_t>(end - begin) > batch) {
        end = begin + static_cast<std::ptrdiff_t>(batch);
        std::nth_element(begin, end, candidates_.end());
      }
      std::sort(begin, end);
      for (; begin != end; ++begin) {
        const auto [squared, q] = *begin;
        if (squared > 4 * cell_.squared_radius() + 2 * weight_) return;
        if (normals_[at(q)].dot(normal) < 0) continue;
        const Vector3d offset = positions_[at(q)] - centre;
        const Vector2d flat(offset.dot(u_), offset.dot(v_));
        const double length = flat.norm(), distance = std::sqrt(squared);
        if (length <= 1e-6 * distance) continue;  // straight above: no direction in the plane
        cell_.clip(flat * (distance / length), 0.5 * (squared + own - weight_ * tie_weight(q)), q);
      }
    }
  }

  bool start(std::int32_t p, double near_reach) {
    tangent_frame(normals_[at(p)], u_, v_);
    cell_.start(reach_);
    if (!collect(p, 0, near_reach)) {
      cell_.start(0);
      return false;
    }
    clip_by_candidates(p);
    return true;
  }

  void widen(std::int32_t p, double near_reach) {
    collect(p, near_reach, reach_);
    clip_by_candidates(p);
  }

  void finish(std::int32_t p, std::vector<std::int32_t>& neighbours, std::vector<std::uint8_t>& states) {
    const auto& corners = cell_.corners();
    const std::size_t n = corners.size();
    const double squared_max_radius = reach_ * reach_ / 4;
    const auto near = [&](std::int32_t a, std::int32_t b) {
      return (positions_[at(a)] - positions_[at(b)]).squaredNorm() <= squared_max_edge_;
    };
    // Corner i lies between the sides i - 1 and i: the triangle of p and their neighbours.
    found_.assign(n, 0);
    for (std::size_t i = 0; i < n; ++i) {
      const std::int32_t a = corners[i == 0 ? n - 1 : i - 1].side, b = corners[i].side;
      found_[i] = a >= 0 && b >= 0 && a != b && corners[i].at.squaredNorm() <= squared_max_radius && near(p, a) &&
                  near(p, b) && near(a, b);
    }
    for (std::size_t i = 0; i < n; ++i) {
      const bool after = found_[i + 1 == n ? 0 : i + 1] != 0;
      if (!found_[i] && !after) continue;
      neighbours.push_back(corners[i].side);
      states.push_back(after ? VoronoiStars::kFound : VoronoiStars::kGap);
    }
  }

  const std::vector<Vector3d>& positions_;
  const std::vector<Vector3d>& normals_;
  const PointBlocks& blocks_;
  double weight_, squared_max_edge_, reach_;
  std::vector<std::int32_t> near_, far_;
  const std::vector<std::int32_t>* loaded_ = nullptr;
  std::vector<double> x_, y_, z_, squared_;
  std::vector<Neighbour> candidates_;
  Vector3d u_, v_;
  Cell cell_;
  std::vector<std::uint8_t> found_;
};

}  // namespace

void tangent_frame(const Vector3d& normal, Vector3d& u, Vector3d& v) {
  // Duff et al., "Building an orthonormal basis, revisited", 2017.
  const double sign = std::copysign(1.0, normal.z());
  const double a = -1 / (sign + normal.z()), b = normal.x() * normal.y() * a;
  u = {1 + sign * normal.x() * normal.x() * a, sign * b, -sign * normal.x()};
  v = {b, sign + normal.y() * normal.y() * a, -normal.y()};
}

VoronoiStars make_voronoi_stars(const std::vector<Vector3d>& positions, const std::vector<Vector3d>& normals,
                                double spacing, double max_edge, const Execution& execution) {
  const double size = block_size(spacing, max_edge);
  execution.report("sort points into blocks", 0, 0);
  const PointBlocks blocks(positions, size);
  execution.check();

  struct Chunk {
    std::vector<std::int32_t> neighbours, counts;
    std::vector<std::uint8_t> states;
  };
  constexpr std::int64_t kGrain = 256;
  std::vector<Chunk> chunks(static_cast<std::size_t>((blocks.num_blocks() + kGrain - 1) / kGrain));
  parallel_chunks(blocks.num_blocks(), kGrain, "find neighbours in tangent planes", execution,
                  [&](std::int64_t begin, std::int64_t end) {
                    Chunk& chunk = chunks[static_cast<std::size_t>(begin / kGrain)];
                    StarMaker maker(positions, normals, blocks, kTieWeight * size * size, max_edge);
                    for (std::int64_t block = begin; block < end; ++block)
                      maker.make_block(block, chunk.neighbours, chunk.states, chunk.counts);
                    chunk.neighbours.shrink_to_fit();
                    chunk.states.shrink_to_fit();
                  });

  VoronoiStars stars;
  stars.first.assign(positions.size() + 1, 0);
  const auto for_each_point = [&](auto&& body) {
    for (std::int64_t block = 0; block < blocks.num_blocks(); ++block) {
      const auto of_block = static_cast<std::size_t>(block / kGrain);
      for (const std::int32_t* p = blocks.begin(block); p != blocks.end(block); ++p)
        body(*p, of_block, block % kGrain == 0 && p == blocks.begin(block));
    }
  };
  std::size_t next = 0;
  for_each_point([&](std::int32_t p, std::size_t chunk, bool new_chunk) {
    if (new_chunk) next = 0;
    stars.first[static_cast<std::size_t>(p) + 1] = chunks[chunk].counts[next++];
  });
  for (std::size_t p = 0; p < positions.size(); ++p) stars.first[p + 1] += stars.first[p];
  stars.neighbours.resize(static_cast<std::size_t>(stars.first.back()));
  stars.states.resize(stars.neighbours.size());
  std::size_t read = 0, last_chunk = 0;
  for_each_point([&](std::int32_t p, std::size_t chunk, bool new_chunk) {
    if (new_chunk) {
      chunks[last_chunk].neighbours = {};
      chunks[last_chunk].states = {};
      last_chunk = chunk;
      read = 0;
    }
    for (std::int64_t slot = stars.begin(p); slot < stars.end(p); ++slot, ++read) {
      stars.neighbours[static_cast<std::size_t>(slot)] = chunks[chunk].neighbours[read];
      stars.states[static_cast<std::size_t>(slot)] = chunks[chunk].states[read];
    }
  });
  return stars;
}

}  // namespace meshmser
