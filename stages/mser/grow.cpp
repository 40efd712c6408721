#include "stages/mser/grow.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>

#include "stages/common/gather_by_owner.hpp"
#include "stages/common/large_pages.hpp"
#include "stages/common/parallel.hpp"
#include "stages/mser/patches.hpp"

namespace meshmser {
namespace {

constexpr std::int32_t kSteps = 4096;

/// Half-edges, each put once, waiting in kSteps queues, first in, first out in each, linked through one list.
class StepQueues {
 public:
  StepQueues() {
    first_.fill(-1);
    last_.fill(-1);
  }

  /// Puts a half-edge into a queue, or into the one being emptied if that is a later one.
  void push(std::int32_t half_edge, std::int32_t step) {
    const auto s = static_cast<std::size_t>(std::max(step, current_));
    const auto place = static_cast<std::int32_t>(waiting_.size());
    waiting_.push_back({-1, half_edge});
    if (first_[s] < 0)
      first_[s] = place;
    else
      waiting_[static_cast<std::size_t>(last_[s])].next = place;
    last_[s] = place;
  }

  /// The next half-edge, or -1.
  std::int32_t pop() {
    while (current_ < kSteps && first_[static_cast<std::size_t>(current_)] < 0) ++current_;
    if (current_ == kSteps) return -1;
    const Waiting& front = waiting_[static_cast<std::size_t>(first_[static_cast<std::size_t>(current_)])];
    first_[static_cast<std::size_t>(current_)] = front.next;
    return front.half_edge;
  }

 private:
  struct Waiting {
    std::int32_t next;  ///< place of the one behind, or -1
    std::int32_t half_edge;
  };
  std::vector<Waiting> waiting_;
  std::array<std::int32_t, kSteps> first_, last_;
  std::int32_t current_ = 0;
};

/// Floods across half-edges, in the order of step_of(half-edge, triangle behind it) as it is when the half-edge is met;
/// `entered(from, to)` tells when a triangle takes the label of another.
template <class StepOf, class Entered>
std::vector<std::int32_t> flood(const SurfaceView& surface, std::span<const std::int32_t> labels,
                                std::span<const std::uint8_t> excluded, StepOf step_of, Entered entered) {
  std::vector<std::int32_t> grown(labels.begin(), labels.end());
  StepQueues queues;
  const auto reach = [&](std::size_t from) {
    for (std::size_t h = 3 * from; h < 3 * from + 3; ++h) {
      if (surface.twins[h] < 0) continue;
      const auto to = static_cast<std::size_t>(surface.twins[h] / 3);
      if (grown[to] != 0 || (!excluded.empty() && excluded[to] != 0)) continue;
      queues.push(static_cast<std::int32_t>(h), step_of(h, to));
    }
  };
  for (std::size_t t = 0; t < labels.size(); ++t)
    if (labels[t] != 0) reach(t);
  for (std::int32_t h = queues.pop(); h >= 0; h = queues.pop()) {
    const auto from = static_cast<std::size_t>(h / 3);
    const auto to = static_cast<std::size_t>(surface.twins[static_cast<std::size_t>(h)] / 3);
    if (grown[to] != 0) continue;
    grown[to] = grown[from];
    entered(from, to);
    reach(to);
  }
  return grown;
}

/// The lesser of the values at the two ends of a half-edge.
template <class Values>
auto lesser_end(const SurfaceView& surface, const Values& values, std::size_t half_edge) {
  const auto& corners = surface.triangles[half_edge / 3];
  return std::min(values[static_cast<std::size_t>(corners[half_edge % 3])],
                  values[static_cast<std::size_t>(corners[(half_edge + 1) % 3])]);
}

/// Steps from 0 to the greatest x, as many to each doubling of 1 + x / unit, and of equal width within it.
class DoublingSteps {
 public:
  DoublingSteps(double unit, double greatest) : per_unit_(1 / (unit > 0 ? unit : 1)) {
    const double range = doublings(greatest);
    scale_ = range > 0 ? (kSteps - 1) / range : 0;
  }
  std::int32_t operator()(double x) const {
    return static_cast<std::int32_t>(std::min<double>(scale_ * doublings(x), kSteps - 1));
  }

 private:
  /// As a double has its exponent above its fraction, its bits count doublings, in units of 2^-52.
  double doublings(double x) const {
    return static_cast<double>(std::bit_cast<std::int64_t>(1 + x * per_unit_) - std::bit_cast<std::int64_t>(1.0));
  }

  double per_unit_, scale_;
};

/// The median of at most 65,536 of the values, taken at equal distances.
double typical(std::span<const double> values) {
  std::vector<double> some;
  const std::size_t stride = values.size() / 65536 + 1;
  for (std::size_t i = 0; i < values.size(); i += stride) some.push_back(values[i]);
  if (some.empty()) return 0;
  const auto middle = some.begin() + static_cast<std::ptrdiff_t>(some.size() / 2);
  std::nth_element(some.begin(), middle, some.end());
  return *middle;
}

}  // namespace

std::vector<double> triangle_means(const SurfaceView& surface, std::span<const double> values,
                                   const Execution& execution) {
  std::vector<double> means;
  reserve_on_large_pages(means, surface.triangles.size());
  means.resize(surface.triangles.size());
  parallel_chunks(
      static_cast<std::int64_t>(means.size()), 1 << 15, "", execution, [&](std::int64_t begin, std::int64_t end) {
        for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t) {
          const auto& corners = surface.triangles[t];
          means[t] = (values[static_cast<std::size_t>(corners[0])] + values[static_cast<std::size_t>(corners[1])] +
                      values[static_cast<std::size_t>(corners[2])]) /
                     3;
        }
      });
  return means;
}

std::vector<std::int32_t> absorb_small_patches(const SurfaceView& surface, std::span<const std::int32_t> labels,
                                               std::span<const double> areas, double min_area,
                                               const Execution& execution, bool whole_labels) {
  // Background is a patch as well, so that a small hole in a region closes.
  const Patches patches =
      split_patches(surface.twins, labels, areas, execution, {.background = true, .whole_numbers = whole_labels});
  const std::size_t num_patches = patches.num_patches();
  const std::vector<std::int32_t>& patch_of = patches.patch_of_triangle;
  // They are numbered by decreasing area.
  const auto first_small =
      static_cast<std::int32_t>(std::partition_point(patches.area_of_patch.begin() + 1, patches.area_of_patch.end(),
                                                     [&](double area) { return area >= min_area; }) -
                                patches.area_of_patch.begin());

  // Of the patches that join others: every edge at the border, by the patch behind it.
  const HalfEdgesByOwner edges = gather_by_owner(
      labels.size(), num_patches + 1,
      [&](std::size_t begin, std::size_t end, std::vector<OwnedHalfEdge>& list) {
        for (std::size_t t = begin; t < end; ++t) {
          const std::int32_t here = patch_of[t];
          if (here < first_small) continue;
          for (std::size_t h = 3 * t; h < 3 * t + 3; ++h)
            if (surface.twins[h] >= 0 && patch_of[static_cast<std::size_t>(surface.twins[h] / 3)] != here)
              list.push_back({here, static_cast<std::int32_t>(h)});
        }
      },
      execution);
  struct CommonBorder {
    std::int32_t patch;
    double length;
  };
  std::vector<std::vector<CommonBorder>> borders(num_patches + 1);
  for (std::size_t p = 1; p <= num_patches; ++p)
    for (std::int64_t i = edges.first_of_owner[p]; i < edges.first_of_owner[p + 1]; ++i) {
      const auto h = static_cast<std::size_t>(edges.half_edges[static_cast<std::size_t>(i)]);
      const auto& corners = surface.triangles[h / 3];
      const double length = (surface.positions[static_cast<std::size_t>(corners[h % 3])] -
                             surface.positions[static_cast<std::size_t>(corners[(h + 1) % 3])])
                                .norm();
      borders[p].push_back({patch_of[static_cast<std::size_t>(surface.twins[h] / 3)], length});
    }
  std::vector<std::int32_t> smallest_triangle = patches.first_of_patch;

  // A patch joins one that is still to come or has grown large enough, so that every chain of joins ends.
  std::vector<std::int32_t> joined(num_patches + 1);
  std::iota(joined.begin(), joined.end(), 0);
  const auto stands_for = [&](std::int32_t patch) {
    while (joined[static_cast<std::size_t>(patch)] != patch) {
      std::int32_t& next = joined[static_cast<std::size_t>(patch)];
      next = joined[static_cast<std::size_t>(next)];
      patch = next;
    }
    return patch;
  };
  std::vector<double> area = patches.area_of_patch;
  for (std::size_t p = num_patches; p > 0; --p) {
    if (area[p] >= min_area) continue;
    std::vector<CommonBorder>& mine = borders[p];
    for (CommonBorder& border : mine) border.patch = stands_for(border.patch);
    std::stable_sort(mine.begin(), mine.end(),
                     [](const CommonBorder& a, const CommonBorder& b) { return a.patch < b.patch; });
    std::int32_t best = -1;
    double longest = -1;
    for (std::size_t i = 0, next = 0; i < mine.size(); i = next) {
      double length = 0;
      for (next = i; next < mine.size() && mine[next].patch == mine[i].patch; ++next) length += mine[next].length;
      if (mine[i].patch == static_cast<std::int32_t>(p)) continue;
      const bool tie_won = best >= 0 && length == longest &&
                           smallest_triangle[static_cast<std::size_t>(mine[i].patch)] <
                               smallest_triangle[static_cast<std::size_t>(best)];
      if (length > longest || tie_won) {
        best = mine[i].patch;
        longest = length;
      }
    }
    if (best < 0) continue;
    const auto b = static_cast<std::size_t>(best);
    joined[p] = best;
    area[b] += area[p];
    smallest_triangle[b] = std::min(smallest_triangle[b], smallest_triangle[p]);
    if (best >= first_small) borders[b].insert(borders[b].end(), mine.begin(), mine.end());
    std::vector<CommonBorder>().swap(mine);
  }
  std::vector<std::int32_t> label_of_patch(num_patches + 1);
  for (std::size_t p = 0; p <= num_patches; ++p)
    label_of_patch[p] = patches.number_of_patch[static_cast<std::size_t>(stands_for(static_cast<std::int32_t>(p)))];
  std::vector<std::int32_t> absorbed(labels.size());
  for (std::size_t t = 0; t < labels.size(); ++t) absorbed[t] = label_of_patch[static_cast<std::size_t>(patch_of[t])];
  return absorbed;
}

std::vector<std::int32_t> flood_by_strength(const SurfaceView& surface, std::span<const std::int32_t> labels,
                                            std::span<const double> strength, std::span<const std::uint8_t> excluded,
                                            const Execution& execution) {
  const double greatest = strength.empty() ? 0 : *std::max_element(strength.begin(), strength.end());
  const DoublingSteps steps(typical(strength), greatest);
  // Steps ascend with the strength, so that the weaker end is the end of the lesser step.
  std::vector<std::int32_t> step_of_vertex(strength.size());
  parallel_chunks(
      static_cast<std::int64_t>(strength.size()), 1 << 15, "", execution, [&](std::int64_t begin, std::int64_t end) {
        std::transform(strength.begin() + begin, strength.begin() + end, step_of_vertex.begin() + begin, steps);
      });
  return flood(
      surface, labels, excluded,
      [&](std::size_t half_edge, std::size_t) { return lesser_end(surface, step_of_vertex, half_edge); },
      [](std::size_t, std::size_t) {});
}

std::vector<std::int32_t> flood_facets(const SurfaceView& surface, std::span<const std::int32_t> labels,
                                       std::span<const double> curvature, std::span<const Eigen::Vector3d> normals,
                                       double width, std::span<const std::uint8_t> excluded) {
  constexpr float kFollow = 0.03F;
  constexpr double kFinestTurn = 0.05, kGreatestTurn = 2;
  const double greatest = curvature.empty() ? 0 : *std::max_element(curvature.begin(), curvature.end());
  const DoublingSteps steps(kFinestTurn, kGreatestTurn + width * greatest);
  const auto normal_of = [&](std::size_t t) -> Eigen::Vector3f {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const std::int32_t v : surface.triangles[t]) sum += normals[static_cast<std::size_t>(v)];
    return sum.normalized().cast<float>();
  };
  // The normal that a labelled triangle hands on.
  std::vector<Eigen::Vector3f> expected(labels.size());
  for (std::size_t t = 0; t < labels.size(); ++t)
    if (labels[t] != 0) expected[t] = normal_of(t);
  return flood(
      surface, labels, excluded,
      [&](std::size_t half_edge, std::size_t to) {
        const double bend = curvature.empty() ? 0 : width * lesser_end(surface, curvature, half_edge);
        return steps(bend + static_cast<double>((expected[half_edge / 3] - normal_of(to)).norm()));
      },
      [&](std::size_t from, std::size_t to) {
        expected[to] = (expected[from] + kFollow * normal_of(to)).normalized();
      });
}

std::vector<std::int32_t> flood_by_likeness(const SurfaceView& surface, std::span<const std::int32_t> labels,
                                            std::span<const double> values, std::span<const double> areas,
                                            std::span<const std::uint8_t> excluded) {
  const std::int32_t most = labels.empty() ? 0 : *std::max_element(labels.begin(), labels.end());
  std::vector<double> mean(static_cast<std::size_t>(most) + 1, 0), weight(mean.size(), 0);
  for (std::size_t t = 0; t < labels.size(); ++t) {
    mean[static_cast<std::size_t>(labels[t])] += areas[t] * values[t];
    weight[static_cast<std::size_t>(labels[t])] += areas[t];
  }
  for (std::size_t i = 0; i < mean.size(); ++i)
    if (weight[i] > 0) mean[i] /= weight[i];
  const double centre = typical(values);
  std::vector<double> spread(values.size());
  for (std::size_t t = 0; t < values.size(); ++t) spread[t] = std::abs(values[t] - centre);
  const double greatest = spread.empty() ? 0 : *std::max_element(spread.begin(), spread.end());
  const DoublingSteps steps(typical(spread), 2 * greatest);
  // Which label asks is known by the half-edge: labels of its triangle change only from 0.
  std::vector<std::int32_t> label_of(labels.begin(), labels.end());
  return flood(
      surface, labels, excluded,
      [&](std::size_t half_edge, std::size_t to) {
        return steps(std::abs(values[to] - mean[static_cast<std::size_t>(label_of[half_edge / 3])]));
      },
      [&](std::size_t from, std::size_t to) { label_of[to] = label_of[from]; });
}

}  // namespace meshmser
