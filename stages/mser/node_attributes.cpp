#include "stages/mser/node_attributes.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <string_view>

#include "pipeline/execution/error.hpp"
#include "stages/common/adjacency.hpp"
#include "stages/common/least_eigen.hpp"
#include "stages/common/tree_nodes.hpp"
#include "stages/mser/stability.hpp"

namespace meshmser {
namespace {

__extension__ using Wide = __int128;

/// Lengths as whole numbers of a unit so small that those of any use are exact: sums do not depend on order, and what
/// is added at a node and taken off at its ancestor leaves nothing behind.
class LengthUnits {
 public:
  explicit LengthUnits(std::span<const Eigen::Vector3d> positions) {
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d& position : positions) box.extend(position);
    int exponent = 0;
    if (!box.isEmpty()) std::frexp(box.diagonal().norm(), &exponent);
    // No edge is longer than 2^exponent: 2^33 of them stay below 2^124 units.
    exponent_ = std::clamp(90 - exponent, -1000, 1000);
    scale_ = std::ldexp(1.0, exponent_);
  }
  Wide units(double length) const { return static_cast<Wide>(length * scale_); }
  double length(Wide units) const { return std::ldexp(static_cast<double>(units), -exponent_); }

 private:
  int exponent_ = 0;
  double scale_ = 1;
};

/// Integrals over triangles, of places and values counted from those of the first triangle.
struct Sums {
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  ///< centroid of the first triangle
  double value = 0;                                 ///< mean of its corners
  std::int64_t num_triangles = 0;
  double area = 0, first = 0, second = 0;            ///< of 1, S, S^2
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();  ///< of p
  SymmetricMatrix3 moments;                          ///< of p p^T
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  double least = std::numeric_limits<double>::infinity(), greatest = -std::numeric_limits<double>::infinity();
  Eigen::AlignedBox3d box;
  Wide level = 0, hole = 0;
  std::int64_t euler = 0;

  void add_product(double weight, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    moments.xx += weight * a.x() * b.x();
    moments.xy += weight * 0.5 * (a.x() * b.y() + a.y() * b.x());
    moments.xz += weight * 0.5 * (a.x() * b.z() + a.z() * b.x());
    moments.yy += weight * a.y() * b.y();
    moments.yz += weight * 0.5 * (a.y() * b.z() + a.z() * b.y());
    moments.zz += weight * a.z() * b.z();
  }

  void add_triangle(const SurfaceView& surface, std::span<const double> values, double triangle_area, std::size_t t) {
    const auto at = [&](std::size_t k) { return static_cast<std::size_t>(surface.triangles[t][k]); };
    const Eigen::Vector3d corners[3] = {surface.positions[at(0)], surface.positions[at(1)], surface.positions[at(2)]};
    const double s[3] = {values[at(0)], values[at(1)], values[at(2)]};
    if (num_triangles == 0) {
      place = (corners[0] + corners[1] + corners[2]) / 3;
      value = (s[0] + s[1] + s[2]) / 3;
    }
    ++num_triangles;
    ++euler;
    area += triangle_area;
    // The integral of a linear function is area / 3 times the sum of its corners; of the product of two, area / 12
    // times the sum of the corners' products and of the product of their sums.
    const double ds[3] = {s[0] - value, s[1] - value, s[2] - value};
    const double total = ds[0] + ds[1] + ds[2];
    first += triangle_area / 3 * total;
    second += triangle_area / 12 * (total * total + ds[0] * ds[0] + ds[1] * ds[1] + ds[2] * ds[2]);
    least = std::min({least, s[0], s[1], s[2]});
    greatest = std::max({greatest, s[0], s[1], s[2]});
    const Eigen::Vector3d a = corners[0] - place, b = corners[1] - place, c = corners[2] - place, sum = a + b + c;
    moment += triangle_area / 3 * sum;
    const double twelfth = triangle_area / 12;
    moments.xx += twelfth * (a.x() * a.x() + b.x() * b.x() + c.x() * c.x() + sum.x() * sum.x());
    moments.xy += twelfth * (a.x() * a.y() + b.x() * b.y() + c.x() * c.y() + sum.x() * sum.y());
    moments.xz += twelfth * (a.x() * a.z() + b.x() * b.z() + c.x() * c.z() + sum.x() * sum.z());
    moments.yy += twelfth * (a.y() * a.y() + b.y() * b.y() + c.y() * c.y() + sum.y() * sum.y());
    moments.yz += twelfth * (a.y() * a.z() + b.y() * b.z() + c.y() * c.z() + sum.y() * sum.z());
    moments.zz += twelfth * (a.z() * a.z() + b.z() * b.z() + c.z() * c.z() + sum.z() * sum.z());
    normal += 0.5 * (b - a).cross(c - a);
    for (const Eigen::Vector3d& corner : corners) box.extend(corner);
  }

  /// Adds those of a child, whose places and values count from elsewhere.
  void add(const Sums& child) {
    const Eigen::Vector3d shift = child.place - place;
    const double ds = child.value - value;
    moments.xx += child.moments.xx;
    moments.xy += child.moments.xy;
    moments.xz += child.moments.xz;
    moments.yy += child.moments.yy;
    moments.yz += child.moments.yz;
    moments.zz += child.moments.zz;
    add_product(2, shift, child.moment);
    add_product(child.area, shift, shift);
    moment += child.moment + child.area * shift;
    second += child.second + 2 * ds * child.first + ds * ds * child.area;
    first += child.first + ds * child.area;
    area += child.area;
    num_triangles += child.num_triangles;
    normal += child.normal;
    least = std::min(least, child.least);
    greatest = std::max(greatest, child.greatest);
    box.extend(child.box);
    level += child.level;
    hole += child.hole;
    euler += child.euler;
  }

  NodeAttributes attributes(const LengthUnits& units) const {
    NodeAttributes result;
    result.num_triangles = num_triangles;
    result.level_length = units.length(level);
    result.hole_length = units.length(hole);
    result.scalar_min = least;
    result.scalar_max = greatest;
    result.scalar_mean = value;
    result.centroid = place;
    if (area > 0) {
      const double mean = first / area;
      const Eigen::Vector3d c = moment / area;
      result.scalar_mean += mean;
      result.scalar_deviation = std::sqrt(std::max(0.0, second / area - mean * mean));
      result.centroid += c;
      result.covariance << moments.xx, moments.xy, moments.xz, moments.xy, moments.yy, moments.yz, moments.xz,
          moments.yz, moments.zz;
      result.covariance = result.covariance / area - c * c.transpose();
    }
    result.box_min = box.min();
    result.box_max = box.max();
    result.vector_area = normal;
    result.euler = euler;
    return result;
  }
};

/// Sums of the nodes asked for, by their place in the list.
class Summation {
 public:
  Summation(const SurfaceView& surface, const ComponentTree& tree, std::span<const std::int32_t> place_of_node,
            std::size_t num_places)
      : surface_(surface), tree_(tree), place_of_node_(place_of_node), units_(surface.positions), sums_(num_places) {}

  std::vector<Sums> run(std::span<const double> values, std::span<const double> areas) {
    for (std::size_t t = 0; t < surface_.triangles.size(); ++t) {
      const std::int32_t place = place_of(node_of(t));
      if (place < 0) continue;
      sums_[static_cast<std::size_t>(place)].add_triangle(surface_, values, areas[t], t);
      for (std::size_t k = 0; k < 3; ++k) add_edge(3 * t + k, place);
    }
    add_closed_fans();
    return std::move(sums_);
  }
  const LengthUnits& units() const { return units_; }

 private:
  std::int32_t node_of(std::size_t triangle) const { return tree_.node_of_triangle[triangle]; }
  std::int32_t place_of(std::int32_t node) const {
    return node < 0 ? -1 : place_of_node_[static_cast<std::size_t>(node)];
  }
  Wide length_of(std::size_t half_edge) const {
    const auto& corners = surface_.triangles[half_edge / 3];
    return units_.units((surface_.positions[static_cast<std::size_t>(corners[half_edge % 3])] -
                         surface_.positions[static_cast<std::size_t>(corners[(half_edge + 1) % 3])])
                            .norm());
  }

  /// Of two neighbours one's node is an ancestor of the other's. An edge between them is inside the ancestor and all
  /// above it, and a level edge of all nodes from the descendant up to just below the ancestor.
  void add_edge(std::size_t half_edge, std::int32_t place) {
    const std::int32_t twin = surface_.twins[half_edge];
    Sums& here = sums_[static_cast<std::size_t>(place)];
    if (twin < 0) {
      here.hole += length_of(half_edge);
      return;
    }
    const std::int32_t node = node_of(half_edge / 3), other = node_of(static_cast<std::size_t>(twin) / 3);
    if (other == node) {
      if (half_edge < static_cast<std::size_t>(twin)) --here.euler;
      return;
    }
    if (other >= 0 && other < node) return;  // told from the descendant's side
    const std::int32_t outer = place_of(other);
    if (outer >= 0) --sums_[static_cast<std::size_t>(outer)].euler;
    if (outer == place) return;
    const Wide length = length_of(half_edge);
    here.level += length;
    if (outer >= 0) sums_[static_cast<std::size_t>(outer)].level -= length;
  }

  /// With F triangles, I inner edges and V vertices counted by fans, V - E + F = F - I + C, where C is the number of
  /// fans that close: a fan of d triangles has d corners and d or, where it is open, d - 1 inner edges. A fan lies in a
  /// node wholly where the lowest of its triangles' nodes does, which holds all the others and so is the last.
  void add_closed_fans() {
    std::vector<bool> seen(surface_.twins.size(), false);
    for (std::size_t first = 0; first < surface_.twins.size(); ++first) {
      if (seen[first] || place_of(node_of(first / 3)) < 0) continue;
      std::int32_t last = -1;
      auto h = static_cast<std::int32_t>(first);
      // A half-edge seen before, other than the first, is of a fan that was found to be open.
      while (h >= 0 && !seen[static_cast<std::size_t>(h)]) {
        const std::int32_t node = node_of(static_cast<std::size_t>(h) / 3);
        if (node < 0) break;
        seen[static_cast<std::size_t>(h)] = true;
        last = std::max(last, node);
        h = surface_.twins[static_cast<std::size_t>(previous_half_edge(h))];
      }
      if (h != static_cast<std::int32_t>(first)) continue;
      if (const std::int32_t place = place_of(last); place >= 0) ++sums_[static_cast<std::size_t>(place)].euler;
    }
  }

  SurfaceView surface_;
  const ComponentTree& tree_;
  std::span<const std::int32_t> place_of_node_;
  LengthUnits units_;
  std::vector<Sums> sums_;
};

void expect(std::string_view what, std::size_t is, std::size_t expected) {
  if (is != expected)
    throw StageError("attributes: " + std::string(what) + " has " + std::to_string(is) + " entries; expected " +
                     std::to_string(expected));
}

}  // namespace

Eigen::Vector3d NodeAttributes::mean_normal() const {
  const double length = vector_area.norm();
  return length > 0 ? Eigen::Vector3d(vector_area / length) : Eigen::Vector3d::Zero();
}

double NodeAttributes::flatness() const {
  return area > 0 ? std::min(1.0, vector_area.norm() / area) : 0;
}

PrincipalAxes principal_axes(const Eigen::Matrix3d& covariance) {
  PrincipalAxes result;
  const double size = covariance.cwiseAbs().maxCoeff();
  if (!(size > 0) || !std::isfinite(size)) return result;
  // Jacobi's rotations need + - * / and square roots alone, which are the same on every processor.
  Eigen::Matrix3d a = covariance / size, v = Eigen::Matrix3d::Identity();
  for (int sweep = 0; sweep < 30; ++sweep) {
    bool diagonal = true;
    for (int p = 0; p < 2; ++p)
      for (int q = p + 1; q < 3; ++q) {
        if (std::abs(a(p, q)) <= 1e-300) continue;
        diagonal = false;
        const double theta = (a(q, q) - a(p, p)) / (2 * a(p, q));
        const double t = (theta >= 0 ? 1 : -1) / (std::abs(theta) + std::sqrt(theta * theta + 1));
        const double c = 1 / std::sqrt(t * t + 1), s = t * c;
        const double app = a(p, p) - t * a(p, q), aqq = a(q, q) + t * a(p, q);
        const int r = 3 - p - q;
        const double arp = c * a(r, p) - s * a(r, q), arq = s * a(r, p) + c * a(r, q);
        a(p, p) = app;
        a(q, q) = aqq;
        a(p, q) = a(q, p) = 0;
        a(r, p) = a(p, r) = arp;
        a(r, q) = a(q, r) = arq;
        const Eigen::Vector3d vp = v.col(p), vq = v.col(q);
        v.col(p) = c * vp - s * vq;
        v.col(q) = s * vp + c * vq;
      }
    if (diagonal) break;
  }
  int order[3] = {0, 1, 2};
  std::stable_sort(order, order + 3, [&](int i, int j) { return a(i, i) > a(j, j); });
  for (int i = 0; i < 3; ++i) {
    result.deviations[i] = std::sqrt(std::max(0.0, a(order[i], order[i]) * size));
    if (i == 2) break;
    Eigen::Vector3d axis = v.col(order[i]).normalized();
    Eigen::Index largest = 0;
    axis.cwiseAbs().maxCoeff(&largest);
    result.axes.col(i) = axis[largest] < 0 ? Eigen::Vector3d(-axis) : axis;
  }
  result.axes.col(2) = result.axes.col(0).cross(result.axes.col(1)).normalized();
  return result;
}

std::vector<NodeAttributes> attributes_of_nodes(const SurfaceView& surface, const ComponentTree& tree,
                                                std::span<const std::int32_t> nodes, std::span<const double> values,
                                                std::span<const double> areas) {
  expect("the scalar", values.size(), surface.positions.size());
  expect("the list of areas", areas.size(), surface.triangles.size());
  expect("the adjacency", surface.twins.size(), 3 * surface.triangles.size());
  expect("the tree's list of triangles", tree.node_of_triangle.size(), surface.triangles.size());
  const std::vector<std::int32_t> place_of_node = smallest_listed_nodes(tree, nodes);
  Summation summation(surface, tree, place_of_node, nodes.size());
  std::vector<Sums> sums = summation.run(values, areas);
  const std::vector<std::int32_t> ancestor = nearest_listed_ancestors(tree, nodes);
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (ancestor[i] >= 0) sums[static_cast<std::size_t>(ancestor[i])].add(sums[i]);
  std::vector<NodeAttributes> result(nodes.size());
  for (std::size_t i = nodes.size(); i-- > 0;) {
    result[i] = sums[i].attributes(summation.units());
    result[i].area = area_of_node(tree, nodes[i]);
    if (ancestor[i] >= 0) result[i].depth = result[static_cast<std::size_t>(ancestor[i])].depth + 1;
  }
  return result;
}

std::vector<NodeAttributes> attributes_of_nodes(const SurfaceView& surface, const ComponentTree& tree,
                                                std::span<const double> values, std::span<const double> areas) {
  std::vector<std::int32_t> all(tree.num_nodes());
  std::iota(all.begin(), all.end(), 0);
  return attributes_of_nodes(surface, tree, all, values, areas);
}

}  // namespace meshmser
