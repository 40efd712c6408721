#include "stages/orient/propagate.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "stages/common/parallel.hpp"
#include "stages/orient/signed_union_find.hpp"

namespace meshmser {
namespace {

constexpr std::uint16_t kNoEdge = 0xffff;
constexpr int kClasses = 4096;
// Below this cosine the surface bends so much along an edge that the normals themselves say little.
constexpr double kBent = 0.7;

// Edges above this cosine (25 degrees) are taken one by one; below it, sets vote.
constexpr double kClear = 0.9;

// An edge that rises by more than 45 degrees above both of its points' planes.
constexpr double kSteep = 0.7;

// -1 .. 1: the sign says whether the normals have the same one, the size how sure that is.
double agreement(const Eigen::Vector3d& step, const Eigen::Vector3d& n, const Eigen::Vector3d& m) {
  const double cosine = n.dot(m), length2 = step.squaredNorm();
  const double rise_n = n.dot(step), rise_m = m.dot(step);
  const double steepness2 = std::min(rise_n * rise_n, rise_m * rise_m) / length2;
  if (std::abs(cosine) >= kBent && steepness2 <= kSteep * kSteep) return cosine * (1 - steepness2);
  // The turn of a circle through both points: right round a sharp edge and from one sheet of a wall to the other, but
  // always less sure than an unbent edge, because noise turns short edges.
  return kBent * (cosine - 2 * rise_n * rise_m / length2);
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

// What all edges between two sets say about their signs.
struct SetVote {
  std::uint32_t a, b;  // roots, a < b
  double sum;          // > 0: same sign
};

// Joins sets across edges too bent to be trusted one by one: all edges between two sets vote, and two sets that are
// each other's clearest neighbour are joined; then again, until no edge runs between two sets. So the side of a sharp
// or noisy edge is decided by its whole length.
template <class EndsOf>
void join_by_votes(std::span<const std::uint32_t> edges, const std::vector<std::uint16_t>& classes,
                   const EndsOf& ends_of, SignedUnionFind& sets, const Execution& execution) {
  std::vector<SetVote> votes;
  votes.reserve(edges.size());
  for (const std::uint32_t edge : edges) {
    const auto [i, j] = ends_of(edge);
    const double weight = 1 - (classes[edge >> 1] & (kClasses - 1)) / double{kClasses};
    votes.push_back({i, j, (edge & 1u) != 0 ? -weight : weight});
  }
  while (!votes.empty()) {
    execution.check();
    // In terms of the present roots.
    std::size_t kept = 0;
    for (const SetVote& vote : votes) {
      const auto a = sets.find(vote.a), b = sets.find(vote.b);
      if (a.root == b.root) continue;
      votes[kept++] = {std::min(a.root, b.root), std::max(a.root, b.root),
                       a.opposed != b.opposed ? -vote.sum : vote.sum};
    }
    votes.resize(kept);
    std::stable_sort(votes.begin(), votes.end(),
                     [](const SetVote& x, const SetVote& y) { return x.a != y.a ? x.a < y.a : x.b < y.b; });
    kept = 0;
    for (const SetVote& vote : votes) {
      if (kept > 0 && votes[kept - 1].a == vote.a && votes[kept - 1].b == vote.b)
        votes[kept - 1].sum += vote.sum;
      else
        votes[kept++] = vote;
    }
    votes.resize(kept);
    // The clearest vote of each set; among equals the first, in an order that is the same at both ends.
    std::unordered_map<std::uint32_t, std::size_t> best;
    const auto clearer = [&](std::size_t x, std::size_t y) {
      const double vx = std::abs(votes[x].sum), vy = std::abs(votes[y].sum);
      return vx != vy ? vx > vy : x < y;
    };
    for (std::size_t v = 0; v < votes.size(); ++v)
      for (const std::uint32_t set : {votes[v].a, votes[v].b}) {
        const auto [entry, is_new] = best.try_emplace(set, v);
        if (!is_new && clearer(v, entry->second)) entry->second = v;
      }
    // A vote that is the clearest of either of its sets; these never close a cycle, since their order is strict.
    for (std::size_t v = 0; v < votes.size(); ++v)
      if (best[votes[v].a] == v || best[votes[v].b] == v) sets.join(votes[v].a, votes[v].b, votes[v].sum < 0);
  }
}

}  // namespace

Propagation propagate_signs(std::span<const Eigen::Vector3d> points, std::span<const Eigen::Vector3d> normals,
                            std::span<const double> clarity, const NearestNeighbors& neighbors,
                            const PropagationParameters& parameters, const Execution& execution) {
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
            level ? class_of(std::min(clarity[static_cast<std::size_t>(i)], clarity[static_cast<std::size_t>(j)]) *
                             agreement(step, normal, other))
                  : across(normal.dot(other));
      }
    }
  });

  // Counting sort of the edges by class; within a class by point.
  std::array<std::uint32_t, kClasses + 1> place{};
  for (const std::uint16_t c : classes)
    if (c != kNoEdge) ++place[(c & (kClasses - 1)) + 1u];
  for (std::size_t c = 0; c < kClasses; ++c) place[c + 1] += place[c];
  Propagation result;
  const std::size_t num_clear = place[class_of(kClear)], num_level = place[kClasses - 1];
  const std::size_t num_unbent = place[class_of(kBent)];
  result.num_edges = static_cast<std::int64_t>(num_unbent);
  std::vector<std::uint32_t> edges(place[kClasses]);  // place in the neighbour table; opposed in the lowest bit
  for (std::size_t e = 0; e < classes.size(); ++e) {
    const std::uint16_t c = classes[e];
    if (c == kNoEdge) continue;
    edges[place[c & (kClasses - 1)]++] = static_cast<std::uint32_t>(e << 1) | (c >= kClasses ? 1u : 0u);
  }
  SignedUnionFind sets(static_cast<std::size_t>(n));
  const auto ends_of = [&](std::uint32_t edge) {
    return std::pair{static_cast<std::uint32_t>((edge >> 1) / k), static_cast<std::uint32_t>(neighbors.ids[edge >> 1])};
  };
  const auto contradicts = [&](std::uint32_t edge) {
    const auto [i, j] = ends_of(edge);
    return (sets.find(i).opposed != sets.find(j).opposed) != ((edge & 1u) != 0);
  };
  for (std::size_t e = 0; e < num_clear; ++e) {
    if (e % 65536 == 0)
      execution.report("signs", static_cast<std::int64_t>(e), static_cast<std::int64_t>(edges.size()));
    const auto [i, j] = ends_of(edges[e]);
    if (!sets.join(i, j, (edges[e] & 1u) != 0) && contradicts(edges[e])) ++result.num_disagreeing;
  }
  const auto unclear = std::span(edges).subspan(num_clear, num_level - num_clear);
  join_by_votes(unclear, classes, ends_of, sets, execution);
  for (const std::uint32_t edge : unclear.first(num_unbent - num_clear)) result.num_disagreeing += contradicts(edge);
  for (const std::uint32_t edge : std::span(edges).subspan(num_level)) {
    // Strays join the sheet they hover over; two sheets stay apart.
    const auto [i, j] = ends_of(edge);
    if (std::min(sets.size_of(i), sets.size_of(j)) <= static_cast<std::uint32_t>(k)) sets.join(i, j, (edge & 1u) != 0);
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
