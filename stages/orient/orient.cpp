#include "stages/orient/orient.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "stages/common/least_eigen.hpp"
#include "stages/common/nearest_neighbors.hpp"
#include "stages/common/parallel.hpp"
#include "stages/orient/propagate.hpp"

namespace meshmser {
namespace {

using Eigen::Vector3d;
using Vectors = std::vector<Vector3d>;

// In spacings. Wider than the mesh's default longest edge: a relation across a small gap is better than two guesses.
constexpr double kMaxGap = 8;
// In spacings: half the distance of the sheets of a thin wall that must not mix.
constexpr double kMaxStep = 1.5;
// A normal nearer to the line of sight than 80 degrees cannot point away from the scanner.
constexpr double kGrazing = 0.17;
// A plane's normal more than 45 degrees from its neighbours' mean is noise: the mean stands in for it.
constexpr double kTrusted = 0.7;
// Of |sum of area normals| / area: 0 for a closed surface, 0.2 for a box without its bottom, 0.5 for a half sphere.
constexpr double kOpenness = 0.4;

Vectors given_normals(const PointCloud& cloud) {
  std::array<const Property*, 3> axes{};
  static constexpr std::array<const char*, 3> kNames{"nx", "ny", "nz"};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const Property& property : cloud.properties)
      if (property.name == kNames[axis]) axes[axis] = &property;
    if (axes[axis] == nullptr)
      throw StageError(std::string("the cloud carries no property '") + kNames[axis] +
                       "': normals given in the file need nx, ny and nz");
  }
  Vectors result(cloud.num_points(), Vector3d::Zero());
  for (std::size_t i = 0; i < result.size(); ++i) {
    const Vector3d n(axes[0]->values[i], axes[1]->values[i], axes[2]->values[i]);
    const double length = n.norm();
    if (std::isfinite(length) && length > 0) result[i] = n / length;
  }
  return result;
}

struct LocalPlanes {
  Vectors normals;            // unit, any sign; zero where the neighbours define no plane
  std::vector<double> areas;  // that a point stands for
};

LocalPlanes fit_planes(const PointCloud& cloud, const NearestNeighbors& neighbors, double max_gap,
                       const Execution& execution) {
  LocalPlanes result{Vectors(cloud.num_points(), Vector3d::Zero()), std::vector<double>(cloud.num_points(), 0)};
  const double gap2 = max_gap * max_gap;
  parallel_chunks(neighbors.num_points, 4096, "planes", execution, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      const Vector3d& p = cloud.positions[static_cast<std::size_t>(i)];
      Vector3d sum = Vector3d::Zero();
      SymmetricMatrix3 m;
      double count = 1, farthest = 0;
      for (const std::int32_t j : neighbors.of(i)) {
        const Vector3d d = cloud.positions[static_cast<std::size_t>(j)] - p;
        const double distance2 = d.squaredNorm();
        if (distance2 > gap2) break;
        sum += d;
        m.xx += d.x() * d.x(), m.xy += d.x() * d.y(), m.xz += d.x() * d.z();
        m.yy += d.y() * d.y(), m.yz += d.y() * d.z(), m.zz += d.z() * d.z();
        farthest = distance2;
        count += 1;
      }
      if (count < 3) continue;
      const Vector3d mean = sum / count;
      const SymmetricMatrix3 covariance{m.xx / count - mean.x() * mean.x(), m.xy / count - mean.x() * mean.y(),
                                        m.xz / count - mean.x() * mean.z(), m.yy / count - mean.y() * mean.y(),
                                        m.yz / count - mean.y() * mean.z(), m.zz / count - mean.z() * mean.z()};
      result.normals[static_cast<std::size_t>(i)] = least_eigen(covariance).vector;
      result.areas[static_cast<std::size_t>(i)] = farthest / count;  // times pi, which cancels everywhere
    }
  });
  return result;
}

// The direction that the neighbours' normals have most in common, whatever their signs (largest eigenvector of the sum
// of n n^T): steadier than the normals where the noise is as large as the spacing, and not led by the point's own.
// Points of another sheet are left out.
struct SmoothNormals {
  Vectors normals;              // unit or zero
  std::vector<double> clarity;  // root mean square cosine between it and them: 1 where all agree
};
SmoothNormals smooth_normals(const PointCloud& cloud, const NearestNeighbors& neighbors, const Vectors& normals,
                             const PropagationParameters& limits, const Execution& execution) {
  SmoothNormals result{Vectors(normals.size(), Vector3d::Zero()), std::vector<double>(normals.size(), 0)};
  const double gap2 = limits.max_gap * limits.max_gap;
  parallel_chunks(neighbors.num_points, 4096, "normals", execution, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      const auto index = static_cast<std::size_t>(i);
      const Vector3d own = normals[index];
      SymmetricMatrix3 away;
      double count = 0;
      const auto add = [&](const Vector3d& m) {
        away.xx += 1 - m.x() * m.x(), away.yy += 1 - m.y() * m.y(), away.zz += 1 - m.z() * m.z();
        away.xy -= m.x() * m.y(), away.xz -= m.x() * m.z(), away.yz -= m.y() * m.z();
        count += 1;
      };
      if (own == Vector3d::Zero()) continue;
      add(own);
      for (const std::int32_t j : neighbors.of(i)) {
        const auto other = static_cast<std::size_t>(j);
        const Vector3d d = cloud.positions[other] - cloud.positions[index];
        if (d.squaredNorm() > gap2) break;
        if (std::min(std::abs(own.dot(d)), std::abs(normals[other].dot(d))) > limits.max_step) continue;
        if (normals[other] != Vector3d::Zero()) add(normals[other]);
      }
      const LeastEigen mean = least_eigen(away);
      result.normals[index] = mean.is_plane() ? mean.vector : own;
      result.clarity[index] = std::sqrt(std::max(0.0, 1 - mean.value / count));
    }
  });
  return result;
}

struct Vote {
  double sum = 0, weight = 0;  // of signed and of absolute cosines
};

// What each component's normals say about a direction that should be outward; zero directions do not vote.
std::vector<Vote> votes(const Vectors& normals, const Vectors& outward,
                        const std::vector<std::int32_t>& component_of_point, std::size_t num_components) {
  std::vector<Vote> result(num_components);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    if (component_of_point[i] < 0) continue;
    const double cosine = normals[i].dot(outward[i]);
    Vote& vote = result[static_cast<std::size_t>(component_of_point[i])];
    vote.sum += cosine;
    vote.weight += std::abs(cosine);
  }
  return result;
}

// What is needed to say whether a component encloses a volume, and on which side.
struct Enclosure {
  double area = 0;
  Vector3d area_normal = Vector3d::Zero();
  Vector3d first_moment = Vector3d::Zero();
  double support = 0;  // sum of area (p - cloud's centroid).n
  double reach = 0;    // sum of area |p - cloud's centroid|
  double openness() const { return area > 0 ? area_normal.norm() / area : 1; }
};

std::vector<Enclosure> enclosures(const PointCloud& cloud, const Vectors& normals, const std::vector<double>& areas,
                                  const std::vector<std::int32_t>& component_of_point, std::size_t num_components,
                                  const Vector3d& centroid) {
  std::vector<Enclosure> result(num_components);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    if (component_of_point[i] < 0) continue;
    Enclosure& e = result[static_cast<std::size_t>(component_of_point[i])];
    const Vector3d from_centroid = cloud.positions[i] - centroid;
    e.area += areas[i];
    e.area_normal += areas[i] * normals[i];
    e.first_moment += areas[i] * from_centroid;
    e.support += areas[i] * from_centroid.dot(normals[i]);
    e.reach += areas[i] * from_centroid.norm();
  }
  return result;
}

Vectors directions_to_scanner(const PointCloud& cloud) {
  Vectors result(cloud.num_points(), Vector3d::Zero());
  for (std::size_t i = 0; i < result.size(); ++i) {
    const std::size_t scan = cloud.scan_of_point.empty() ? 0 : cloud.scan_of_point[i];
    if (scan < cloud.scans.size() && cloud.scans[scan].scanner_position)
      result[i] = (*cloud.scans[scan].scanner_position - cloud.positions[i]).normalized();
  }
  return result;
}

Vectors directions_to(const PointCloud& cloud, const Vector3d& viewpoint) {
  Vectors result(cloud.num_points());
  for (std::size_t i = 0; i < result.size(); ++i)
    result[i] = (viewpoint - cloud.origin - cloud.positions[i]).normalized();
  return result;
}

// Turns whole components, and then, with `pointwise`, each point that is clearly on the wrong side by itself.
void turn_toward(const Vectors& outward, SignSource source, bool pointwise, PointNormals& result,
                 std::vector<std::uint8_t>& decided) {
  const auto vote = votes(result.normals, outward, result.component_of_point, result.components.size());
  for (std::size_t i = 0; i < result.normals.size(); ++i) {
    const std::int32_t c = result.component_of_point[i];
    if (c < 0 || decided[static_cast<std::size_t>(c)] || !(vote[static_cast<std::size_t>(c)].weight > 0)) continue;
    if (vote[static_cast<std::size_t>(c)].sum < 0) result.normals[i] = -result.normals[i];
    if (pointwise && result.normals[i].dot(outward[i]) < -kGrazing) result.normals[i] = -result.normals[i];
  }
  for (std::size_t c = 0; c < result.components.size(); ++c) {
    if (decided[c] || !(vote[c].weight > 0)) continue;
    decided[c] = 1;
    result.components[c].source = source;
    result.components[c].confidence = std::abs(vote[c].sum) / vote[c].weight;
  }
}

void turn_outward(const PointCloud& cloud, const std::vector<double>& areas, bool trust_any_volume,
                  PointNormals& result, const std::vector<std::uint8_t>& decided) {
  Vector3d centroid = Vector3d::Zero();
  for (const Vector3d& p : cloud.positions) centroid += p;
  centroid /= static_cast<double>(std::max<std::size_t>(1, cloud.num_points()));
  const auto enclosed =
      enclosures(cloud, result.normals, areas, result.component_of_point, result.components.size(), centroid);
  std::vector<std::uint8_t> turned(result.components.size(), 0);
  for (std::size_t c = 0; c < result.components.size(); ++c) {
    if (decided[c]) continue;
    const Enclosure& e = enclosed[c];
    NormalComponent& component = result.components[c];
    if (trust_any_volume || e.openness() < kOpenness) {
      // Three times the signed volume, about the component's own centroid so that an opening counts least.
      const double volume = e.support - (e.area > 0 ? e.first_moment.dot(e.area_normal) / e.area : 0);
      component.source = SignSource::kEnclosedVolume;
      component.confidence = 1 - e.openness();
      turned[c] = volume < 0;
    } else {
      component.source = SignSource::kGuess;
      component.confidence = e.reach > 0 ? std::abs(e.support) / e.reach : 0;
      turned[c] = e.support < 0;
    }
  }
  for (std::size_t i = 0; i < result.normals.size(); ++i) {
    const std::int32_t c = result.component_of_point[i];
    if (c >= 0 && turned[static_cast<std::size_t>(c)]) result.normals[i] = -result.normals[i];
  }
}

void flip(const OrientOptions& options, PointNormals& result) {
  if (options.flip_all)
    for (NormalComponent& component : result.components) component.flipped_by_user = true;
  for (const int rank : options.flip) {
    if (rank < 1 || static_cast<std::size_t>(rank) > result.components.size())
      throw StageError("flip names component " + std::to_string(rank) + ", but there are components 1 to " +
                       std::to_string(result.components.size()));
    result.components[static_cast<std::size_t>(rank - 1)].flipped_by_user = true;
  }
  for (std::size_t i = 0; i < result.normals.size(); ++i) {
    const std::int32_t c = result.component_of_point[i];
    if (c >= 0 && result.components[static_cast<std::size_t>(c)].flipped_by_user)
      result.normals[i] = -result.normals[i];
  }
}

}  // namespace

Orientation orient(const PointCloud& cloud, const OrientOptions& options, const Execution& execution) {
  const std::size_t n = cloud.num_points();
  Orientation result;
  result.report.num_unoriented = static_cast<std::int64_t>(n);
  result.normals.normals.assign(n, Vector3d::Zero());
  result.normals.component_of_point.assign(n, -1);
  if (n < 3) return result;

  const NearestNeighbors neighbors = nearest_neighbors(cloud.positions, options.neighbors, execution);
  PropagationParameters limits;
  // A cloud too small for a spacing is one neighbourhood.
  constexpr double kUnlimited = 1e300;
  limits.max_gap = options.max_gap > 0 ? options.max_gap : cloud.spacing > 0 ? kMaxGap * cloud.spacing : 1e150;
  limits.max_step = cloud.spacing > 0 ? kMaxStep * cloud.spacing : kUnlimited;

  LocalPlanes planes = fit_planes(cloud, neighbors, limits.max_gap, execution);
  Vectors given;
  if (options.normals == NormalChoice::kGiven || options.sign == SignChoice::kGiven) given = given_normals(cloud);
  const SmoothNormals smoothed = smooth_normals(cloud, neighbors, planes.normals, limits, execution);
  const Propagation propagation =
      propagate_signs(cloud.positions, smoothed.normals, smoothed.clarity, neighbors, limits, execution);

  result.report.num_edges = propagation.num_edges;
  result.report.num_disagreeing = propagation.num_disagreeing;
  result.report.num_unoriented = 0;
  PointNormals& out = result.normals;
  out.component_of_point = propagation.component_of_point;
  out.components.resize(static_cast<std::size_t>(propagation.num_components));
  result.report.centers.assign(out.components.size(), Vector3d::Zero());
  for (std::size_t i = 0; i < n; ++i) {
    const std::int32_t c = out.component_of_point[i];
    if (c < 0) {
      ++result.report.num_unoriented;
      continue;
    }
    const double cosine = planes.normals[i].dot(smoothed.normals[i]);
    const double sign = propagation.signs[i];
    out.normals[i] = std::abs(cosine) < kTrusted ? Vector3d(sign * smoothed.normals[i])
                                                 : Vector3d((cosine < 0 ? -sign : sign) * planes.normals[i]);
    ++out.components[static_cast<std::size_t>(c)].num_points;
    result.report.centers[static_cast<std::size_t>(c)] += cloud.positions[i];
  }
  for (std::size_t c = 0; c < out.components.size(); ++c)
    result.report.centers[c] =
        result.report.centers[c] / static_cast<double>(out.components[c].num_points) + cloud.origin;

  std::vector<std::uint8_t> decided(out.components.size(), 0);
  const bool any = options.sign == SignChoice::kAuto;
  if (!given.empty()) turn_toward(given, SignSource::kGiven, true, out, decided);
  if (options.sign == SignChoice::kViewpoint && !options.viewpoint)
    throw StageError("sign: viewpoint needs the option 'viewpoint'");
  if (options.viewpoint && (any || options.sign == SignChoice::kViewpoint))
    turn_toward(directions_to(cloud, *options.viewpoint), SignSource::kViewpoint, false, out, decided);
  const bool known = std::any_of(cloud.scans.begin(), cloud.scans.end(),
                                 [](const Scan& scan) { return scan.scanner_position.has_value(); });
  if (options.sign == SignChoice::kScanner && !known)
    throw StageError("sign: scanner needs scans whose scanner position is known");
  if (known && (any || options.sign == SignChoice::kScanner))
    turn_toward(directions_to_scanner(cloud), SignSource::kScanner, true, out, decided);
  turn_outward(cloud, planes.areas, options.sign == SignChoice::kVolume, out, decided);
  if (options.normals == NormalChoice::kGiven)
    for (std::size_t i = 0; i < n; ++i)
      if (given[i] != Vector3d::Zero()) out.normals[i] = given[i];
  flip(options, out);
  return result;
}

}  // namespace meshmser
