#include "stages/load/pass_distance.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

#include "stages/common/parallel.hpp"
#include "stages/load/canonical_order.hpp"

namespace meshmser {
namespace {

constexpr double kRadius = 4;            // in spacings
constexpr std::size_t kLeastPoints = 8;  // of each scan around a sample
constexpr std::int64_t kSamples = 20'000;
constexpr std::size_t kLeastSamples = 50;   // of a pair of scans
constexpr double kMedianOfNormal = 0.6745;  // of |N(0, 1)|

struct Sample {
  std::uint32_t first, second;
  double distance;        // along the normal
  double standard_error;  // of it, from the scans' own roughness
};

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Points of one scan near a sample, in the frame of the sample's plane: (u, v) along it, z along the normal.
struct Patch {
  std::vector<Eigen::Vector3d> points;

  /// On all sides of the sample: no half-plane through it, of eight tried, is empty.
  bool surrounds() const {
    for (int k = 0; k < 8; ++k) {
      const double angle = k * (M_PI / 4);
      const Eigen::Vector2d side(std::cos(angle), std::sin(angle));
      if (std::none_of(points.begin(), points.end(),
                       [&](const Eigen::Vector3d& p) { return side.dot(p.head<2>()) > 0.1; }))
        return false;
    }
    return true;
  }
};

struct Heights {
  double first, second, standard_error;
};

/// Least squares for one quadratic surface shared by both scans, but for a height of its own each: what the surface
/// does cancels, even where the scans are sampled differently.
Heights fit_parallel_surfaces(const Patch& a, const Patch& b) {
  constexpr int kUnknowns = 7;
  using Row = Eigen::Matrix<double, kUnknowns, 1>;
  auto row_of = [&](const Patch* patch, const Eigen::Vector3d& p) {
    Row row;
    row << (patch == &a ? 1 : 0), (patch == &b ? 1 : 0), p.x(), p.y(), p.x() * p.x(), p.x() * p.y(), p.y() * p.y();
    return row;
  };
  Eigen::Matrix<double, kUnknowns, kUnknowns> normal = Eigen::Matrix<double, kUnknowns, kUnknowns>::Zero();
  Row right = Row::Zero();
  for (const Patch* patch : {&a, &b})
    for (const Eigen::Vector3d& p : patch->points) {
      const Row row = row_of(patch, p);
      normal += row * row.transpose();
      right += row * p.z();
    }
  const Row solution = normal.ldlt().solve(right);
  double squares = 0;
  for (const Patch* patch : {&a, &b})
    for (const Eigen::Vector3d& p : patch->points) {
      const double residual = p.z() - row_of(patch, p).dot(solution);
      squares += residual * residual;
    }
  const double na = static_cast<double>(a.points.size()), nb = static_cast<double>(b.points.size());
  return {solution[0], solution[1], std::sqrt(squares / (na + nb - kUnknowns) * (1 / na + 1 / nb))};
}

/// The cloud's points by the Morton codes of their own box: that of the raw scan may have been larger.
struct SortedPoints {
  std::vector<std::uint64_t> codes;
  std::vector<Eigen::Vector3d> positions;
  std::vector<std::uint32_t> scans;
  double spacing;

  SortedPoints(const PointCloud& points, const MortonGrid& grid) : spacing(points.spacing) {
    std::vector<std::pair<std::uint64_t, std::uint32_t>> order;
    order.reserve(points.num_points());
    for (const Eigen::Vector3d& p : points.positions)
      order.emplace_back(grid.code(p), static_cast<std::uint32_t>(order.size()));
    std::sort(order.begin(), order.end());
    for (const auto& [code, point] : order) {
      codes.push_back(code);
      positions.push_back(points.positions[point]);
      scans.push_back(points.scan_of_point[point]);
    }
  }
};

void sample_at(std::int64_t centre_index, const SortedPoints& points, const MortonIndex& index,
               std::vector<Sample>& samples) {
  const Eigen::Vector3d& centre = points.positions[static_cast<std::size_t>(centre_index)];
  const std::uint32_t own = points.scans[static_cast<std::size_t>(centre_index)];
  std::map<std::uint32_t, Patch> patches;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  double count = 0;
  index.for_each_within(centre, kRadius * points.spacing, [&](std::int64_t i) {
    const Eigen::Vector3d q = (points.positions[static_cast<std::size_t>(i)] - centre) / points.spacing;
    patches[points.scans[static_cast<std::size_t>(i)]].points.push_back(q);
    mean += q;
    squares += q * q.transpose();
    count += 1;
  });
  if (patches.size() < 2 || patches[own].points.size() < kLeastPoints) return;
  mean /= count;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(squares / count - mean * mean.transpose());
  const Eigen::Matrix3d frame = solver.eigenvectors();  // least eigenvalue first
  for (auto& [scan, patch] : patches)
    for (Eigen::Vector3d& q : patch.points)
      q = Eigen::Vector3d(frame.col(2).dot(q), frame.col(1).dot(q), frame.col(0).dot(q));
  const Patch& mine = patches[own];
  if (!mine.surrounds()) return;
  for (const auto& [scan, patch] : patches) {
    if (scan == own || patch.points.size() < kLeastPoints || !patch.surrounds()) continue;
    const Heights heights = fit_parallel_surfaces(mine, patch);
    samples.push_back({std::min(own, scan), std::max(own, scan),
                       std::abs(heights.second - heights.first) * points.spacing,
                       heights.standard_error * points.spacing});
  }
}

double without_noise(std::vector<double>& distances, std::vector<double>& errors) {
  const double seen = median(distances), noise = kMedianOfNormal * median(errors);
  return std::sqrt(std::max(0.0, seen * seen - noise * noise));
}

}  // namespace

PassDistances measure_pass_distances(const PointCloud& points, const Execution& execution) {
  PassDistances result;
  if (points.scans.size() < 2 || points.spacing <= 0) return result;
  const MortonGrid grid = morton_grid(points.positions);
  const SortedPoints sorted(points, grid);
  const MortonIndex index(grid, sorted.codes, sorted.positions);

  const auto n = static_cast<std::int64_t>(points.num_points());
  const std::int64_t step = std::max<std::int64_t>(1, n / kSamples), sampled = (n + step - 1) / step;
  constexpr std::int64_t kGrain = 250;
  std::vector<std::vector<Sample>> parts(static_cast<std::size_t>((sampled + kGrain - 1) / kGrain));
  parallel_chunks(sampled, kGrain, "passes", execution, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i)
      sample_at(i * step, sorted, index, parts[static_cast<std::size_t>(begin / kGrain)]);
  });

  std::map<std::pair<std::uint32_t, std::uint32_t>, std::pair<std::vector<double>, std::vector<double>>> by_pair;
  std::vector<double> distances, errors;
  for (const std::vector<Sample>& part : parts)
    for (const Sample& sample : part) {
      auto& [pair_distances, pair_errors] = by_pair[{sample.first, sample.second}];
      pair_distances.push_back(sample.distance);
      pair_errors.push_back(sample.standard_error);
      distances.push_back(sample.distance);
      errors.push_back(sample.standard_error);
    }
  for (auto& [pair, values] : by_pair)
    if (values.first.size() >= kLeastSamples)
      result.pairs.push_back({pair.first, pair.second, static_cast<std::int64_t>(values.first.size()),
                              without_noise(values.first, values.second)});
  result.num_samples = static_cast<std::int64_t>(distances.size());
  if (distances.size() >= kLeastSamples) result.median_distance = without_noise(distances, errors);
  return result;
}

}  // namespace meshmser
