#include "stages/orient/propagate.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "stages/common/parallel.hpp"
#include "stages/orient/signed_union_find.hpp"

namespace meshmser {
namespace {

constexpr std::uint16_t kNoEdge = 0xffff;
constexpr int kClasses = 4096;
// Below this cosine the surface bends so much along an edge that the normals themselves say little.
constexpr double kBent = 0.7;

// +-|agreement| in 0 .. 1; the sign says whether the normals have the same one.
double agreement(const Eigen::Vector3d& step, const Eigen::Vector3d& n, const Eigen::Vector3d& m) {
  const double cosine = n.dot(m);
  if (std::abs(cosine) >= kBent) return cosine;
  // The turn of a circle through both points; always less trusted than an unbent edge.
  const double turned = cosine - 2 * n.dot(step) * m.dot(step) / step.squaredNorm();
  return kBent * turned;
}

// The last class: edges between two sheets, or to a stray point above its sheet.
constexpr std::uint16_t across(double cosine) {
  return static_cast<std::uint16_t>((kClasses - 1) | (cosine < 0 ? kClasses : 0));
}

// Class 0 holds the best edges; bit 12 is set where the signs oppose.
std::uint16_t class_of(double value) {
  const double badness = 1 - std::min(1.0, std::abs(value));
  const int bucket = std::min(kClasses - 2, static_cast<int>(badness * kClasses));
  return static_cast<std::uint16_t>(bucket | (value < 0 ? kClasses : 0));
}

}  // namespace

Propagation propagate_signs(std::span<const Eigen::Vector3d> points, std::span<const Eigen::Vector3d> normals,
                            const NearestNeighbors& neighbors, const PropagationParameters& parameters,
                            const Execution& execution) {
  const std::int64_t n = static_cast<std::int64_t>(points.size());
  const std::int64_t k = neighbors.num_neighbors;
  if (n * k >= (std::int64_t{1} << 31))
    throw StageError(std::to_string(n) + " points with " + std::to_string(k) +
                     " neighbours each are more than 2^31 edges: use fewer neighbours");

  std::vector<std::uint16_t> classes(static_cast<std::size_t>(n * k), kNoEdge);
  const double gap2 = parameters.max_gap * parameters.max_gap;
  parallel_chunks(n, 4096, "edges", execution, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      const Eigen::Vector3d &p = points[static_cast<std::size_t>(i)], &normal = normals[static_cast<std::size_t>(i)];
      if (normal == Eigen::Vector3d::Zero()) continue;
      const auto list = neighbors.of(i);
      for (std::int64_t slot = 0; slot < k; ++slot) {
        const std::int32_t j = list[static_cast<std::size_t>(slot)];
        const Eigen::Vector3d& other = normals[static_cast<std::size_t>(j)];
        const Eigen::Vector3d step = points[static_cast<std::size_t>(j)] - p;
        if (step.squaredNorm() > gap2 || other == Eigen::Vector3d::Zero()) continue;
        if (j < i) {  // listed at j already?
          const auto back = neighbors.of(j);
          if (std::find(back.begin(), back.end(), static_cast<std::int32_t>(i)) != back.end()) continue;
        }
        const bool level = std::min(std::abs(normal.dot(step)), std::abs(other.dot(step))) <= parameters.max_step;
        classes[static_cast<std::size_t>(i * k + slot)] =
            level ? class_of(agreement(step, normal, other)) : across(normal.dot(other));
      }
    }
  });

  // Counting sort of the edges by class; within a class by point.
  std::array<std::uint32_t, kClasses + 1> place{};
  for (const std::uint16_t c : classes)
    if (c != kNoEdge) ++place[(c & (kClasses - 1)) + 1u];
  for (std::size_t c = 0; c < kClasses; ++c) place[c + 1] += place[c];
  Propagation result;
  const std::size_t num_level = place[kClasses - 1];
  result.num_edges = static_cast<std::int64_t>(num_level);
  std::vector<std::uint32_t> edges(place[kClasses]);  // place in the neighbour table; opposed in the lowest bit
  for (std::size_t e = 0; e < classes.size(); ++e) {
    const std::uint16_t c = classes[e];
    if (c == kNoEdge) continue;
    edges[place[c & (kClasses - 1)]++] = static_cast<std::uint32_t>(e << 1) | (c >= kClasses ? 1u : 0u);
  }
  classes = {};

  SignedUnionFind sets(static_cast<std::size_t>(n));
  for (std::size_t e = 0; e < edges.size(); ++e) {
    if (e % 65536 == 0)
      execution.report("signs", static_cast<std::int64_t>(e), static_cast<std::int64_t>(edges.size()));
    const std::uint32_t slot = edges[e] >> 1;
    const bool opposed = (edges[e] & 1u) != 0;
    const auto i = static_cast<std::uint32_t>(slot / k), j = static_cast<std::uint32_t>(neighbors.ids[slot]);
    if (e >= num_level) {
      // Strays join the sheet they hover over; two sheets stay apart.
      if (std::min(sets.size_of(i), sets.size_of(j)) <= static_cast<std::uint32_t>(k)) sets.join(i, j, opposed);
      continue;
    }
    if (sets.join(i, j, opposed)) continue;
    if ((sets.find(i).opposed != sets.find(j).opposed) != opposed) ++result.num_disagreeing;
  }

  // Number the sets by falling size, then least point id.
  struct Component {
    std::int64_t size;
    std::uint32_t root;
  };
  std::vector<Component> components;
  std::vector<std::int32_t> number(static_cast<std::size_t>(n), -1);
  result.signs.assign(static_cast<std::size_t>(n), 0);
  for (std::int64_t i = 0; i < n; ++i) {
    if (normals[static_cast<std::size_t>(i)] == Eigen::Vector3d::Zero()) continue;
    const auto found = sets.find(static_cast<std::uint32_t>(i));
    result.signs[static_cast<std::size_t>(i)] = found.opposed ? -1 : 1;
    std::int32_t& index = number[found.root];
    if (index < 0) {
      index = static_cast<std::int32_t>(components.size());
      components.push_back({0, found.root});
    }
    ++components[static_cast<std::size_t>(index)].size;
  }
  std::stable_sort(components.begin(), components.end(),
                   [](const Component& a, const Component& b) { return a.size > b.size; });
  for (std::size_t c = 0; c < components.size(); ++c) number[components[c].root] = static_cast<std::int32_t>(c);
  result.num_components = static_cast<std::int32_t>(components.size());
  result.component_of_point.assign(static_cast<std::size_t>(n), -1);
  for (std::int64_t i = 0; i < n; ++i)
    if (result.signs[static_cast<std::size_t>(i)] != 0)
      result.component_of_point[static_cast<std::size_t>(i)] = number[sets.find(static_cast<std::uint32_t>(i)).root];
  return result;
}

}  // namespace meshmser
