#include "stages/mser/merge.hpp"

#include <tbb/enumerable_thread_specific.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "stages/mser/label_graph.hpp"
#include "stages/mser/patch_walk.hpp"

namespace meshmser {
namespace {

/// How many triangles of a patch have a curvature in each of many steps equal in its logarithm: its quantiles without a
/// list of its triangles. Steps of 2^(1/8) from 2^-16 to 2^16 of a unit near the data; what is less is in the first.
class CurvatureHistogram {
 public:
  static std::size_t step_of(double relative) {
    return relative > 0 ? static_cast<std::size_t>(std::clamp(8 * (std::log2(relative) + 16), 0.0, kSteps - 1.0)) : 0;
  }
  void add(std::size_t step) { ++count_[step]; }
  void add(const CurvatureHistogram& other) {
    for (std::size_t i = 0; i < kSteps; ++i) count_[i] += other.count_[i];
  }
  /// Interpolated within its step.
  double quantile(double q) const {
    std::int64_t total = 0;
    for (const std::int32_t count : count_) total += count;
    const double wanted = q * static_cast<double>(total);
    std::int64_t below = 0;
    for (std::size_t i = 0; i < kSteps; ++i) {
      if (static_cast<double>(below + count_[i]) > wanted) {
        const double part = (wanted - static_cast<double>(below)) / count_[i];
        return i == 0 ? 0 : std::exp2((static_cast<double>(i) + part) / 8 - 16);
      }
      below += count_[i];
    }
    return 0;
  }

 private:
  static constexpr std::size_t kSteps = 256;
  std::array<std::int32_t, kSteps> count_{};
};

/// The curvature that a patch may have at a border by its own bending: what it has nearly everywhere (a low quantile),
/// or, where its median is not far above that, so that it bends evenly, a little more than the median, because floods
/// meet where a face happens to bend most. A median far above comes from edges blurred into a small or wrinkled patch
/// and says nothing; between the two the low quantile takes over step by step.
double bending_of(const CurvatureHistogram& histogram, double low_quantile) {
  constexpr double kEven = 1.6, kMoreAtBorders = 1.15;
  const double low = histogram.quantile(low_quantile);
  if (low <= 0) return 0;
  const double ratio = histogram.quantile(0.5) / low;
  return low * std::max(1.0, kMoreAtBorders * std::min(ratio, 2 * kEven - ratio));
}

Eigen::Vector3d position(const SurfaceView& surface, std::int32_t triangle, std::int32_t corner) {
  return surface.positions[static_cast<std::size_t>(
      surface.triangles[static_cast<std::size_t>(triangle)][static_cast<std::size_t>(corner)])];
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// How far a border reaches: its length, or the diagonal of the box around it, which zigzags do not lengthen.
double extent_of(const SurfaceView& surface, const CommonBorder& border) {
  double length = 0;
  Eigen::AlignedBox3d box;
  for (const std::int32_t h : border.half_edges) {
    const Eigen::Vector3d from = position(surface, h / 3, h % 3), to = position(surface, h / 3, (h + 1) % 3);
    length += (from - to).norm();
    box.extend(from);
    box.extend(to);
  }
  return std::min(length, box.diagonal().norm());
}

/// One side of a border sample.
struct Side {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double weight = 0;
};

/// The triangles of the patch of `first` within the radius of a place.
Side look(const SurfaceView& surface, const LabelGraph& graph, std::span<const std::int32_t> labels,
          const Eigen::Vector3d& place, double radius, std::int32_t first, PatchWalk& walk) {
  const std::int32_t label = graph.stands_for(labels[static_cast<std::size_t>(first)]);
  Side side;
  walk.walk(
      surface, place, radius, first,
      [&](std::int32_t t) { return graph.stands_for(labels[static_cast<std::size_t>(t)]) == label; },
      [&](std::int32_t t, const Eigen::Vector3d& centroid) {
        const Eigen::Vector3d a = position(surface, t, 0), b = position(surface, t, 1), c = position(surface, t, 2);
        const double distance2 = (centroid - place).squaredNorm();
        side.normal += distance2 * (b - a).cross(c - a);
        const double weight = distance2 * (b - a).cross(c - a).norm();
        side.centre += weight * centroid;
        side.weight += weight;
      });
  if (side.weight > 0) side.centre /= side.weight;
  return side;
}

}  // namespace

std::vector<std::int32_t> merge_by_saliency(const SurfaceView& surface, std::span<const std::int32_t> labels,
                                            std::span<const double> strength, std::span<const double> areas,
                                            double threshold, const Execution& execution) {
  LabelGraph graph(surface, labels);
  std::vector<double> sum(static_cast<std::size_t>(graph.num_labels()) + 1, 0), area(sum.size(), 0);
  for (std::size_t t = 0; t < labels.size(); ++t) {
    const auto& corners = surface.triangles[t];
    double mean = 0;
    for (const std::int32_t v : corners) mean += strength[static_cast<std::size_t>(v)] / 3;
    sum[static_cast<std::size_t>(labels[t])] += areas[t] * mean;
    area[static_cast<std::size_t>(labels[t])] += areas[t];
  }
  const auto mean_of = [&](std::int32_t label) {
    const auto i = static_cast<std::size_t>(label);
    return area[i] > 0 ? sum[i] / area[i] : 0;
  };
  const auto measure = [&](std::int32_t a, std::int32_t b, const CommonBorder& border) {
    double total = 0, length = 0;
    for (const std::int32_t h : border.half_edges) {
      const auto& corners = surface.triangles[static_cast<std::size_t>(h / 3)];
      const auto v = static_cast<std::size_t>(corners[static_cast<std::size_t>(h % 3)]);
      const auto w = static_cast<std::size_t>(corners[static_cast<std::size_t>((h + 1) % 3)]);
      const double edge = (surface.positions[v] - surface.positions[w]).norm();
      total += edge * 0.5 * (strength[v] + strength[w]);
      length += edge;
    }
    return (length > 0 ? total / length : 0) - std::max(mean_of(a), mean_of(b));
  };
  const auto join = [&](std::int32_t a, std::int32_t b) {
    sum[static_cast<std::size_t>(a)] += sum[static_cast<std::size_t>(b)];
    area[static_cast<std::size_t>(a)] += area[static_cast<std::size_t>(b)];
  };
  graph.join_while_weak(threshold, measure, join, execution);
  return graph.joined_labels(labels);
}

std::vector<std::int32_t> merge_by_turning(const SurfaceView& surface, std::span<const std::int32_t> labels,
                                           std::span<const double> curvature, std::span<const double> areas,
                                           const TurningParameters& parameters, const Execution& execution) {
  LabelGraph graph(surface, labels);
  std::vector<double> area(static_cast<std::size_t>(graph.num_labels()) + 1, 0);
  for (std::size_t t = 0; t < labels.size(); ++t) area[static_cast<std::size_t>(labels[t])] += areas[t];
  std::vector<CurvatureHistogram> histograms(curvature.empty() ? 0 : static_cast<std::size_t>(graph.num_labels()) + 1);
  std::vector<double> own(static_cast<std::size_t>(graph.num_labels()) + 1, 0);
  for (std::size_t t = 0; t < curvature.size(); ++t)
    histograms[static_cast<std::size_t>(labels[t])].add(CurvatureHistogram::step_of(curvature[t] * parameters.radius));
  const auto measure_own = [&](std::size_t label) {
    if (!histograms.empty())
      own[label] = bending_of(histograms[label], parameters.curvature_quantile) / parameters.radius;
  };
  for (std::size_t label = 1; label < own.size(); ++label) measure_own(label);

  tbb::enumerable_thread_specific<PatchWalk> walks;
  const auto measure = [&](std::int32_t a, std::int32_t b, const CommonBorder& border) {
    // Facets that touch at a corner have nothing that turns between them, and are two.
    const double smaller = std::min(area[static_cast<std::size_t>(a)], area[static_cast<std::size_t>(b)]);
    if (smaller > std::numbers::pi * parameters.radius * parameters.radius &&
        extent_of(surface, border) < parameters.radius)
      return std::numbers::pi;
    const double explained = std::max(own[static_cast<std::size_t>(a)], own[static_cast<std::size_t>(b)]);
    const auto num_edges = static_cast<std::int64_t>(border.half_edges.size());
    const std::int64_t num_samples = std::min<std::int64_t>(num_edges, parameters.samples);
    std::vector<double> turns, distances;
    for (std::int64_t i = 0; i < num_samples; ++i) {
      const std::int32_t h = border.half_edges[static_cast<std::size_t>((2 * i + 1) * num_edges / (2 * num_samples))];
      const std::int32_t t = h / 3;
      const Eigen::Vector3d place = (position(surface, t, h % 3) + position(surface, t, (h + 1) % 3)) / 2;
      PatchWalk& walk = walks.local();
      const Side one = look(surface, graph, labels, place, parameters.radius, t, walk);
      const Side other =
          look(surface, graph, labels, place, parameters.radius, surface.twins[static_cast<std::size_t>(h)] / 3, walk);
      if (one.weight <= 0 || other.weight <= 0) continue;
      // The turn along the way from centre to centre, with its sign, so that noise averages out.
      const Eigen::Vector3d way = other.centre - one.centre;
      const double distance = way.norm();
      if (distance <= 0) continue;
      const double turn = (other.normal.normalized() - one.normal.normalized()).dot(way) / distance;
      turns.push_back(2 * std::asin(std::clamp(turn / 2, -1.0, 1.0)));
      distances.push_back(distance);
    }
    // A border where nothing can be measured has no area on one side at least: it parts nothing.
    if (turns.empty()) return 0.0;
    return std::abs(median(turns)) - explained * median(distances);
  };
  const auto join = [&](std::int32_t a, std::int32_t b) {
    area[static_cast<std::size_t>(a)] += area[static_cast<std::size_t>(b)];
    if (histograms.empty()) return;
    histograms[static_cast<std::size_t>(a)].add(histograms[static_cast<std::size_t>(b)]);
    measure_own(static_cast<std::size_t>(a));
  };
  graph.join_while_weak(parameters.threshold, measure, join, execution);
  return graph.joined_labels(labels);
}

}  // namespace meshmser
