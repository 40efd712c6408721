#include "stages/tree/fallen_rim.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "stages/common/cell_grid.hpp"
#include "stages/tree/rims.hpp"

namespace meshmser {
namespace {

constexpr double kPlace = 1, kInside = 4, kBand = 8, kReach = 12;  // radii
constexpr int kRefits = 6;
constexpr double kTukey = 4.685;  // 95 % efficiency on Gaussian residuals
constexpr double kDeviationOfMad = 1.4826;
constexpr double kLowShare = 0.02, kDepthOfLow = 1, kLeastDepth = 1.0 / 3;
constexpr std::size_t kFewest = 12;  // places to fit six coefficients to

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// The vertices of a cube, as one.
struct Places {
  std::vector<Eigen::Vector3d> centres, normals;
  std::vector<double> areas;
  std::vector<std::int32_t> place_of_vertex;  ///< -1: no area
};

Places gather_places(std::span<const Eigen::Vector3d> positions, std::span<const Eigen::Vector3d> normals,
                     std::span<const double> areas, double size, const Execution& execution) {
  // The vertex of least id stands for its cube until places are numbered, so that threads do not matter.
  std::vector<std::int32_t> least_of_vertex(positions.size(), -1);
  for_each_cell(CellGrid(positions, size), 0, "", execution, [&](const CellBlock& block) {
    const std::int32_t least = block.ids[static_cast<std::size_t>(block.own_begin)];
    for (std::int64_t i = block.own_begin; i < block.own_end; ++i)
      least_of_vertex[static_cast<std::size_t>(block.ids[static_cast<std::size_t>(i)])] = least;
  });
  Places places;
  places.place_of_vertex.assign(positions.size(), -1);
  std::vector<std::int32_t> place_of_least(positions.size(), -1);
  for (std::size_t v = 0; v < positions.size(); ++v) {
    if (!(areas[v] > 0)) continue;
    std::int32_t& place = place_of_least[static_cast<std::size_t>(least_of_vertex[v])];
    if (place < 0) {
      place = static_cast<std::int32_t>(places.centres.size());
      places.centres.push_back(Eigen::Vector3d::Zero());
      places.normals.push_back(Eigen::Vector3d::Zero());
      places.areas.push_back(0);
    }
    const auto p = static_cast<std::size_t>(place);
    places.place_of_vertex[v] = place;
    places.centres[p] += areas[v] * positions[v];
    places.normals[p] += areas[v] * normals[v];
    places.areas[p] += areas[v];
  }
  for (std::size_t p = 0; p < places.centres.size(); ++p) places.centres[p] /= places.areas[p];
  return places;
}

struct Frame {
  Eigen::Vector3d origin, u, v, n;
  Vector6 quadric = Vector6::Zero();

  static Vector6 terms(double x, double y) { return (Vector6() << 1, x, y, x * x, x * y, y * y).finished(); }
  /// Height of a point above the quadric.
  double above(const Eigen::Vector3d& point, double scale) const {
    const Eigen::Vector3d d = (point - origin) / scale;
    return scale * (d.dot(n) - quadric.dot(terms(d.dot(u), d.dot(v))));
  }
};

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The surface inside about one place; false where there is too little of it.
bool fit_inside(const Places& places, std::span<const std::int32_t> near, std::span<const std::uint8_t> at_rim,
                std::size_t here, double reach, Frame& frame) {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  std::vector<std::int32_t> used;
  std::size_t inside = 0;
  for (const std::int32_t id : near) {
    const auto p = static_cast<std::size_t>(id);
    // The other side of a thin wall is another surface.
    if ((places.centres[p] - places.centres[here]).squaredNorm() > reach * reach ||
        places.normals[p].dot(places.normals[here]) <= 0)
      continue;
    used.push_back(id);
    if (at_rim[p] != 0) continue;
    ++inside;
    normal += places.normals[p];
  }
  if (inside < kFewest || !(normal.norm() > 0)) return false;
  frame.origin = places.centres[here];
  frame.n = normal.normalized();
  int least = 0;
  frame.n.cwiseAbs().minCoeff(&least);
  frame.u = frame.n.cross(Eigen::Vector3d::Unit(least)).normalized();
  frame.v = frame.n.cross(frame.u);
  std::vector<Vector6> terms;
  std::vector<double> heights, weights, residuals(used.size());
  for (const std::int32_t id : used) {
    const auto p = static_cast<std::size_t>(id);
    const Eigen::Vector3d d = (places.centres[p] - frame.origin) / reach;
    terms.push_back(Frame::terms(d.dot(frame.u), d.dot(frame.v)));
    heights.push_back(d.dot(frame.n));
    weights.push_back(at_rim[p] != 0 ? 0 : places.areas[p]);
  }
  for (int fit = 0; fit <= kRefits; ++fit) {
    Matrix6 matrix = Matrix6::Zero();
    Vector6 right = Vector6::Zero();
    double total = 0;
    for (std::size_t i = 0; i < used.size(); ++i) {
      if (!(weights[i] > 0)) continue;
      matrix.selfadjointView<Eigen::Lower>().rankUpdate(terms[i], weights[i]);
      right += weights[i] * heights[i] * terms[i];
      total += weights[i];
    }
    if (!(total > 0)) return false;
    matrix.diagonal().array() += 1e-9 * total;  // places in a row determine no quadric across it: none there
    frame.quadric = matrix.selfadjointView<Eigen::Lower>().ldlt().solve(right);
    std::vector<double> known;
    for (std::size_t i = 0; i < used.size(); ++i) {
      residuals[i] = heights[i] - frame.quadric.dot(terms[i]);
      if (weights[i] > 0) known.push_back(std::abs(residuals[i]));
    }
    const double width = kTukey * kDeviationOfMad * median(std::move(known));
    if (!(width > 0)) return true;
    for (std::size_t i = 0; i < used.size(); ++i) {
      const double t = residuals[i] / width, keep = 1 - t * t;
      weights[i] = std::abs(t) < 1 ? places.areas[static_cast<std::size_t>(used[i])] * keep * keep : 0;
    }
  }
  return true;
}

double low_quantile(std::vector<double> values, double share) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Keeps of `deep` what is joined to the half-edges through deep vertices.
void keep_joined(std::span<const std::array<std::int32_t, 3>> triangles, std::span<const std::int32_t> rim,
                 std::vector<std::uint8_t>& deep) {
  std::vector<std::vector<std::int32_t>> triangles_of_vertex(deep.size());
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (const std::int32_t corner : triangles[t])
      if (deep[static_cast<std::size_t>(corner)] != 0)
        triangles_of_vertex[static_cast<std::size_t>(corner)].push_back(static_cast<std::int32_t>(t));
  std::vector<std::uint8_t> joined(deep.size(), 0);
  std::vector<std::int32_t> stack;
  const auto reach = [&](std::int32_t vertex) {
    const auto v = static_cast<std::size_t>(vertex);
    if (deep[v] == 0 || joined[v] != 0) return;
    joined[v] = 1;
    stack.push_back(vertex);
  };
  for (const std::int32_t edge : rim)
    for (const std::int32_t corner : triangles[static_cast<std::size_t>(edge) / 3]) reach(corner);
  while (!stack.empty()) {
    const auto v = static_cast<std::size_t>(stack.back());
    stack.pop_back();
    for (const std::int32_t t : triangles_of_vertex[v])
      for (const std::int32_t corner : triangles[static_cast<std::size_t>(t)]) reach(corner);
  }
  deep = std::move(joined);
}

}  // namespace

FallenRim fallen_rim(std::span<const Eigen::Vector3d> positions, std::span<const Eigen::Vector3d> normals,
                     std::span<const double> areas, std::span<const std::array<std::int32_t, 3>> triangles,
                     std::span<const std::int32_t> twins, const FallenRimParameters& parameters,
                     const Execution& execution) {
  FallenRim result;
  result.fallen_of_vertex.assign(positions.size(), 0);
  const double r = parameters.radius;
  const LongRims rims = find_long_rims(positions, triangles, twins, parameters.min_rim);
  if (rims.segments.empty()) return result;

  const Places places = gather_places(positions, normals, areas, kPlace * r, execution);
  const std::vector<std::uint8_t> at_rim = points_near(places.centres, rims.segments, kInside * r, execution);
  const std::vector<std::uint8_t> in_band = points_near(places.centres, rims.segments, kBand * r, execution);
  std::vector<Frame> frame_of_place(places.centres.size());
  std::vector<std::uint8_t> is_fitted(places.centres.size(), 0);
  for_each_cell(CellGrid(places.centres, kReach * r), 1, "rims", execution, [&](const CellBlock& block) {
    const std::span<const std::int32_t> near(block.ids.data(), static_cast<std::size_t>(block.num_candidates));
    for (std::int64_t i = block.own_begin; i < block.own_end; ++i) {
      const auto p = static_cast<std::size_t>(block.ids[static_cast<std::size_t>(i)]);
      if (in_band[p] != 0) is_fitted[p] = fit_inside(places, near, at_rim, p, kReach * r, frame_of_place[p]);
    }
  });

  std::vector<double> above(positions.size(), std::numeric_limits<double>::quiet_NaN());
  std::vector<double> inside;
  for (std::size_t v = 0; v < positions.size(); ++v) {
    if (places.place_of_vertex[v] < 0) continue;
    const auto p = static_cast<std::size_t>(places.place_of_vertex[v]);
    if (is_fitted[p] == 0) continue;
    above[v] = frame_of_place[p].above(positions[v], kReach * r);
    if (at_rim[p] == 0) inside.push_back(above[v]);
  }
  result.depth = parameters.depth;
  if (!(result.depth > 0)) {
    result.depth = kLeastDepth * r;
    if (!inside.empty())
      result.depth = std::max(result.depth, -kDepthOfLow * low_quantile(std::move(inside), kLowShare));
  }
  for (std::size_t v = 0; v < positions.size(); ++v) result.fallen_of_vertex[v] = above[v] < -result.depth;
  keep_joined(triangles, rims.half_edges, result.fallen_of_vertex);
  return result;
}

}  // namespace meshmser
