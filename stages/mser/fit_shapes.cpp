#include "stages/mser/fit_shapes.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "stages/mser/node_attributes.hpp"

namespace meshmser {
namespace {

constexpr int kMostTrials = 40, kFewTrials = 8;
/// A step that lessens the mean square by a smaller share is the last.
constexpr double kEnoughGain = 1e-4;
/// Curvatures below this, in units of the points' spread, are none: the sagitta is lost in rounding.
constexpr double kLeastCurvature = 1e-7;

/// Points counted from their mean in units of their spread.
struct Cloud {
  std::span<const double> weights;
  std::span<const Eigen::Vector3d> normals;
  std::vector<Eigen::Vector3d> points;
  std::vector<double> chosen_weights;  ///< behind `weights`, where those are not the caller's
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double spread = 0, weight = 0;
  PrincipalAxes axes;
  std::size_t origin = 0;  ///< the point nearest to the mean: a place on the surface, never a centre
};

Cloud normalised(std::span<const Eigen::Vector3d> points, std::span<const double> weights,
                 std::span<const Eigen::Vector3d> normals) {
  Cloud cloud;
  cloud.weights = weights;
  cloud.normals = normals;
  cloud.points.assign(points.begin(), points.end());
  const Eigen::Vector3d first = points[0];
  for (std::size_t i = 0; i < points.size(); ++i) {
    cloud.weight += weights[i];
    cloud.mean += weights[i] * (points[i] - first);
  }
  cloud.mean = first + cloud.mean / cloud.weight;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    cloud.points[i] -= cloud.mean;
    covariance += weights[i] / cloud.weight * cloud.points[i] * cloud.points[i].transpose();
  }
  cloud.axes = principal_axes(covariance);
  cloud.spread = cloud.axes.deviations.norm();
  if (!(cloud.spread > 0)) return cloud;
  for (std::size_t i = 0; i < points.size(); ++i) {
    cloud.points[i] /= cloud.spread;
    if (cloud.points[i].squaredNorm() < cloud.points[cloud.origin].squaredNorm()) cloud.origin = i;
  }
  return cloud;
}

/// A sphere or cylinder near a place o on it: n is the direction from o to the centre or axis, s the distance from o to
/// the shape along n, k its curvature, of either sign; `axis` is across n. With q = p - o - s n and q' = q, or for a
/// cylinder q less its part along the axis,
///     g = k / 2 |q'|^2 - q . n,    distance = 2 g / (1 + sqrt(1 + 2 k g)),
/// which is exact, and runs smoothly through the plane at k = 0 [Lukacs et al. 1998, 4 and 5].
struct Round {
  bool cylinder = false;
  Eigen::Vector3d n = Eigen::Vector3d::UnitZ(), axis = Eigen::Vector3d::UnitX();
  double s = 0, k = 0;

  int num_parameters() const { return cylinder ? 5 : 4; }
  /// From the centre or axis through `centre`, o being 0.
  void place(const Eigen::Vector3d& centre) {
    Eigen::Vector3d way = centre;
    if (cylinder) way -= way.dot(axis) * axis;
    const double distance = way.norm();
    n = distance > 0 ? Eigen::Vector3d(way / distance) : n;
    s = distance - 1 / k;
    complete();
  }
  /// Makes the axis a unit vector across n.
  void complete() {
    axis -= axis.dot(n) * n;
    if (!(axis.norm() > 1e-6)) axis = n.unitOrthogonal();
    axis.normalize();
  }
  double distance(const Eigen::Vector3d& p) const {
    const Eigen::Vector3d q = p - s * n;
    const double along = cylinder ? q.dot(axis) : 0;
    const double g = 0.5 * k * (q.squaredNorm() - along * along) - q.dot(n);
    return 2 * g / (1 + std::sqrt(std::max(0.0, 1 + 2 * k * g)));
  }
  /// The same, and its derivatives by turns about the axis, about axis x n and (cylinder) about n, by s and by k.
  double distance(const Eigen::Vector3d& p, Eigen::Matrix<double, 5, 1>& slope) const {
    const Eigen::Vector3d q = p - s * n, across = n.cross(axis);
    const double along = cylinder ? q.dot(axis) : 0, down = q.dot(n), size2 = q.squaredNorm() - along * along;
    const double g = 0.5 * k * size2 - down;
    // 0 at the centre itself, where the distance has a tip.
    const double w = std::max(1e-3, std::sqrt(std::max(0.0, 1 + 2 * k * g)));
    const double d = 2 * g / (1 + w);
    // A turn by a small angle about u moves n by u x n and the axis by u x axis.
    slope[0] = -(1 + k * s) * p.dot(axis.cross(n));
    slope[1] = -(1 + k * s) * p.dot(across.cross(n)) - (cylinder ? k * along * p.dot(across.cross(axis)) : 0);
    slope[2] = cylinder ? -k * along * p.dot(across) : 0;
    slope[3] = 1 - k * down;
    slope[4] = 0.5 * size2 - 0.5 * d * d;
    slope /= w;
    return d;
  }
  /// After turns and changes by `step`.
  Round moved(const Eigen::Matrix<double, 5, 1>& step) const {
    Round next = *this;
    const Eigen::Vector3d turn = step[0] * axis + step[1] * n.cross(axis) + step[2] * n;
    next.n = (n + turn.cross(n)).normalized();
    next.axis = axis + turn.cross(axis);
    next.complete();
    next.s += step[3];
    next.k += step[4];
    return next;
  }
};

/// Mean square of the distances, o being the cloud's origin.
double mean_square(const Cloud& cloud, const Round& shape) {
  double sum = 0;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const double d = shape.distance(cloud.points[i] - cloud.points[cloud.origin]);
    sum += cloud.weights[i] * d * d;
  }
  return sum / cloud.weight;
}

/// Levenberg and Marquardt's descent; returns the mean square reached.
double refine(const Cloud& cloud, Round& shape, int most_trials) {
  double cost = mean_square(cloud, shape), damping = 1e-3;
  while (most_trials > 0 && damping < 1e6) {
    Eigen::Matrix<double, 5, 5> normal = Eigen::Matrix<double, 5, 5>::Zero();
    Eigen::Matrix<double, 5, 1> right = Eigen::Matrix<double, 5, 1>::Zero(), slope;
    for (std::size_t i = 0; i < cloud.points.size(); ++i) {
      const double d = shape.distance(cloud.points[i] - cloud.points[cloud.origin], slope);
      const double weight = cloud.weights[i] / cloud.weight;
      for (int a = 0; a < 5; ++a)
        for (int b = 0; b <= a; ++b) normal(a, b) += weight * slope[a] * slope[b];
      right += weight * d * slope;
    }
    const double before = cost;
    for (; damping < 1e6 && most_trials > 0; damping *= 10, --most_trials) {
      Eigen::Matrix<double, 5, 5> damped = normal.selfadjointView<Eigen::Lower>();
      // A turn that changes nothing (a sphere's about n) must not make the system singular.
      for (int i = 0; i < 5; ++i) damped(i, i) += damping * damped(i, i) + 1e-14;
      const Round next = shape.moved(-damped.ldlt().solve(right));
      const double next_cost = mean_square(cloud, next);
      if (next_cost <= cost) {
        shape = next;
        cost = next_cost;
        damping = std::max(1e-12, damping / 10);
        --most_trials;
        break;
      }
    }
    if (cost > before * (1 - kEnoughGain)) break;
  }
  return cost;
}

/// The centre of the linear least-squares sphere (or circle, where points and normals have no part along `axis`).
Eigen::Vector3d algebraic_centre(const Cloud& cloud, const Eigen::Vector3d* axis) {
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    Eigen::Vector3d p = cloud.points[i] - cloud.points[cloud.origin];
    if (axis != nullptr) p -= p.dot(*axis) * *axis;
    const Eigen::Vector4d row(2 * p.x(), 2 * p.y(), 2 * p.z(), 1);
    const double weight = cloud.weights[i] / cloud.weight;
    normal += weight * row * row.transpose();
    right += weight * p.squaredNorm() * row;
  }
  return Eigen::CompleteOrthogonalDecomposition<Eigen::Matrix4d>(normal).solve(right).head<3>();
}

/// The shape about a centre, whose radius is the mean distance.
Round about(const Cloud& cloud, const Eigen::Vector3d& centre, const Eigen::Vector3d* axis) {
  Round shape;
  shape.cylinder = axis != nullptr;
  if (axis != nullptr) shape.axis = *axis;
  double radius = 0;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    Eigen::Vector3d p = cloud.points[i] - cloud.points[cloud.origin] - centre;
    if (axis != nullptr) p -= p.dot(*axis) * *axis;
    radius += cloud.weights[i] / cloud.weight * p.norm();
  }
  shape.k = 1 / std::max(radius, 1e-9);
  shape.place(centre);
  return shape;
}

/// The plane as a shape of no curvature.
Round flat(const Cloud& cloud, bool cylinder, const Eigen::Vector3d& axis) {
  Round shape;
  shape.cylinder = cylinder;
  shape.n = cloud.axes.axes.col(2);
  shape.axis = axis;
  shape.s = -shape.n.dot(cloud.points[cloud.origin]);
  shape.complete();
  return shape;
}

/// Every so-many-th point, enough to tell which start leads furthest down.
Cloud thinned(const Cloud& cloud) {
  constexpr std::size_t kEnough = 32;
  const std::size_t n = cloud.points.size(), stride = std::max<std::size_t>(1, n / kEnough);
  Cloud thin;
  thin.points.push_back(cloud.points[cloud.origin]);
  thin.chosen_weights.push_back(cloud.weights[cloud.origin]);
  for (std::size_t i = 0; i < n; i += stride) {
    thin.points.push_back(cloud.points[i]);
    thin.chosen_weights.push_back(cloud.weights[i]);
  }
  for (const double weight : thin.chosen_weights) thin.weight += weight;
  thin.weights = thin.chosen_weights;
  return thin;
}

Round best_round(const Cloud& cloud, bool cylinder, double& square) {
  std::vector<Round> starts{flat(cloud, cylinder, cloud.axes.axes.col(0))};
  if (!cylinder) {
    starts.push_back(about(cloud, algebraic_centre(cloud, nullptr), nullptr));
  } else {
    starts.push_back(flat(cloud, true, cloud.axes.axes.col(1)));
    // Normals of a cylinder lie across its axis.
    Eigen::Matrix3d normals = Eigen::Matrix3d::Zero();
    for (const Eigen::Vector3d& normal : cloud.normals) normals += normal * normal.transpose();
    const Eigen::Vector3d across = principal_axes(normals).axes.col(2);
    Round by_points;
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d axis = cloud.axes.axes.col(i);
      const Round shape = about(cloud, algebraic_centre(cloud, &axis), &axis);
      if (const double here = mean_square(cloud, shape); here < least) {
        least = here;
        by_points = shape;
      }
    }
    starts.push_back(by_points);
    starts.push_back(about(cloud, algebraic_centre(cloud, &across), &across));
  }
  const Cloud thin = thinned(cloud);
  Round best = starts[0];
  double least = std::numeric_limits<double>::infinity();
  for (const Round& start : starts) {
    Round shape = start;
    refine(thin, shape, kFewTrials);
    const double here = mean_square(cloud, shape);
    if (!(here < least)) continue;
    least = here;
    best = shape;
  }
  square = refine(cloud, best, kMostTrials);
  // The plane is one of these shapes: none may be worse.
  if (const double plain = mean_square(cloud, starts[0]); plain < square) {
    square = plain;
    best = starts[0];
  }
  return best;
}

/// The curvature's sign tells on which side of the normals the centre lies.
double signed_radius(const Cloud& cloud, const Round& shape, const Eigen::Vector3d& centre) {
  double outward = 0;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    Eigen::Vector3d from = cloud.points[i] - centre;
    if (shape.cylinder) from -= from.dot(shape.axis) * shape.axis;
    outward += cloud.normals[i].dot(from);
  }
  return (outward < 0 ? -1 : 1) * cloud.spread / std::abs(shape.k);
}

/// Schwarz' criterion; see the header.
double criterion(double residual, const Cloud& cloud, double num_parameters) {
  const auto n = std::min(50.0, static_cast<double>(cloud.points.size()));
  const double least = std::max(residual, 1e-6 * cloud.spread);
  return n * std::log(least * least * n / (n - num_parameters)) + num_parameters * std::log(n);
}

}  // namespace

FittedShapes fit_shapes(std::span<const Eigen::Vector3d> points, std::span<const double> weights,
                        std::span<const Eigen::Vector3d> normals) {
  FittedShapes result;
  if (points.size() < 3) return result;
  const Cloud cloud = normalised(points, weights, normals);
  if (!(cloud.spread > 0) || !std::isfinite(cloud.spread)) return result;
  result.plane_residual = cloud.axes.deviations[2];
  result.plane_point = cloud.mean;
  result.plane_normal = cloud.axes.axes.col(2);
  if (points.size() < 5) return result;
  result.best = FittedShape::kPlane;
  double best = criterion(result.plane_residual, cloud, 3);
  for (const bool cylinder : {false, true}) {
    if (points.size() < (cylinder ? 7U : 6U)) break;
    double square = 0;
    const Round shape = best_round(cloud, cylinder, square);
    double radius = std::numeric_limits<double>::infinity();
    Eigen::Vector3d centre = Eigen::Vector3d::Constant(FittedShapes::kNone);
    if (std::abs(shape.k) > kLeastCurvature) {
      centre = cloud.points[cloud.origin] + (shape.s + 1 / shape.k) * shape.n;
      if (cylinder) centre -= centre.dot(shape.axis) * shape.axis;
      radius = signed_radius(cloud, shape, centre);
      centre = cloud.mean + cloud.spread * centre;
    }
    const double residual = std::sqrt(square) * cloud.spread;
    if (cylinder) {
      Eigen::Index largest = 0;
      shape.axis.cwiseAbs().maxCoeff(&largest);
      result.cylinder_axis = shape.axis[largest] < 0 ? Eigen::Vector3d(-shape.axis) : shape.axis;
      result.cylinder_residual = residual;
      result.cylinder_radius = radius;
      result.cylinder_point = centre;
    } else {
      result.sphere_residual = residual;
      result.sphere_radius = radius;
      result.sphere_centre = centre;
    }
    if (const double here = criterion(residual, cloud, cylinder ? 5 : 4); here < best) {
      best = here;
      result.best = cylinder ? FittedShape::kCylinder : FittedShape::kSphere;
    }
  }
  return result;
}

}  // namespace meshmser
