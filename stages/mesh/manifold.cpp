#include "stages/mesh/manifold.hpp"

#include <numeric>
#include <utility>

#include "stages/common/adjacency.hpp"

namespace meshmser {
namespace {

std::size_t at(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

/// A half-edge of an unoriented soup under its edge.
struct EdgeUse {
  std::int32_t low, high;  ///< the edge's points
  std::int32_t half_edge;  ///< 3 t + k
  bool operator<(const EdgeUse& other) const {
    if (low != other.low) return low < other.low;
    if (high != other.high) return high < other.high;
    return half_edge < other.half_edge;
  }
};

std::vector<EdgeUse> sorted_edge_uses(const std::vector<Triangle>& triangles) {
  std::vector<EdgeUse> uses;
  uses.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t a = triangles[t][k], b = triangles[t][(k + 1) % 3];
      uses.push_back({std::min(a, b), std::max(a, b), static_cast<std::int32_t>(3 * t + k)});
    }
  }
  std::sort(uses.begin(), uses.end());
  return uses;
}

void keep_only(std::vector<Triangle>& triangles, const std::vector<std::uint8_t>& dropped) {
  std::size_t kept = 0;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    if (!dropped[t]) triangles[kept++] = triangles[t];
  triangles.resize(kept);
}

/// Corners ascending in each triangle.
std::int64_t drop_degenerate(std::vector<Triangle>& triangles) {
  const std::size_t before = triangles.size();
  std::erase_if(triangles, [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2]; });
  std::sort(triangles.begin(), triangles.end());
  triangles.erase(std::unique(triangles.begin(), triangles.end()), triangles.end());
  return static_cast<std::int64_t>(before - triangles.size());
}

std::int64_t drop_third_on_edge(std::vector<Triangle>& triangles) {
  const std::vector<EdgeUse> uses = sorted_edge_uses(triangles);
  std::vector<std::uint8_t> dropped(triangles.size(), 0);
  std::int64_t count = 0;
  for (std::size_t begin = 0, end = 0; begin < uses.size(); begin = end) {
    std::size_t used = 0;
    for (end = begin; end < uses.size() && uses[end].low == uses[begin].low && uses[end].high == uses[begin].high;
         ++end) {
      std::uint8_t& drop = dropped[at(uses[end].half_edge / 3)];
      if (!drop && ++used > 2) {
        drop = 1;
        ++count;
      }
    }
  }
  keep_only(triangles, dropped);
  return count;
}

/// Turns triangles so that neighbours agree; drops those that cannot.
std::int64_t orient(std::vector<Triangle>& triangles) {
  const std::vector<EdgeUse> uses = sorted_edge_uses(triangles);
  std::vector<std::int32_t> opposite(3 * triangles.size(), -1);
  for (std::size_t i = 0; i + 1 < uses.size(); ++i) {
    if (uses[i].low != uses[i + 1].low || uses[i].high != uses[i + 1].high) continue;
    opposite[at(uses[i].half_edge)] = uses[i + 1].half_edge;
    opposite[at(uses[i + 1].half_edge)] = uses[i].half_edge;
  }
  // Neighbours agree when they run along the common edge in opposite directions.
  const auto same_direction = [&](std::int32_t g, std::int32_t h) {
    return triangles[at(g / 3)][at(g % 3)] == triangles[at(h / 3)][at(h % 3)];
  };
  enum : std::uint8_t { kUnseen, kKept, kTurned, kDropped };
  std::vector<std::uint8_t> state(triangles.size(), kUnseen);
  std::vector<std::int32_t> queue;
  std::int64_t count = 0;
  for (std::size_t seed = 0; seed < triangles.size(); ++seed) {
    if (state[seed] != kUnseen) continue;
    state[seed] = kKept;
    queue.assign(1, static_cast<std::int32_t>(seed));
    for (std::size_t next = 0; next < queue.size(); ++next) {
      const std::int32_t t = queue[next];
      if (state[at(t)] == kDropped) continue;
      for (std::int32_t h = 3 * t; h < 3 * t + 3; ++h) {
        const std::int32_t twin = opposite[at(h)];
        if (twin < 0) continue;
        const bool turned = (state[at(t)] == kTurned) != same_direction(h, twin);
        std::uint8_t& other = state[at(twin / 3)];
        if (other == kUnseen) {
          other = turned ? kTurned : kKept;
          queue.push_back(twin / 3);
        } else if (other != kDropped && (other == kTurned) != turned) {
          other = kDropped;
          ++count;
        }
      }
    }
  }
  std::vector<std::uint8_t> dropped(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (state[t] == kTurned) std::swap(triangles[t][1], triangles[t][2]);
    dropped[t] = state[t] == kDropped;
  }
  keep_only(triangles, dropped);
  return count;
}

}  // namespace

std::vector<Triangle> oriented_manifold(std::vector<Triangle> triangles, ManifoldRepair* repair) {
  ManifoldRepair counts;
  // The orientation of the input must not decide anything.
  for (Triangle& t : triangles) std::sort(t.begin(), t.end());
  counts.degenerate = drop_degenerate(triangles);
  counts.third_on_edge = drop_third_on_edge(triangles);
  counts.inconsistent = orient(triangles);
  sort_triangles(triangles);
  if (repair != nullptr) *repair = counts;
  return triangles;
}

CompactMesh split_pinched_vertices(const std::vector<Triangle>& triangles, std::size_t num_points) {
  const std::vector<std::int32_t> twins = twin_half_edges(triangles, num_points);
  const auto num_corners = static_cast<std::int32_t>(twins.size());
  const auto point = [&](std::int32_t corner) { return triangles[at(corner / 3)][at(corner % 3)]; };

  // Number the fans of each point in the order of their first corners.
  std::vector<std::int32_t> fan_of_corner(twins.size(), -1);
  std::vector<std::int32_t> num_fans(num_points, 0);
  for (std::int32_t corner = 0; corner < num_corners; ++corner) {
    if (fan_of_corner[at(corner)] >= 0) continue;
    const std::int32_t fan = num_fans[at(point(corner))]++;
    fan_of_corner[at(corner)] = fan;
    std::int32_t c = corner;
    for (std::int32_t twin; (twin = twins[at(previous_half_edge(c))]) >= 0 && fan_of_corner[at(twin)] < 0;) {
      c = twin;
      fan_of_corner[at(c)] = fan;
    }
    c = corner;
    for (std::int32_t twin; (twin = twins[at(c)]) >= 0 && fan_of_corner[at(next_half_edge(twin))] < 0;) {
      c = next_half_edge(twin);
      fan_of_corner[at(c)] = fan;
    }
  }

  CompactMesh mesh;
  std::vector<std::int32_t> first_vertex(num_points, 0);
  for (std::size_t p = 0; p < num_points; ++p) {
    first_vertex[p] = static_cast<std::int32_t>(mesh.point_of_vertex.size());
    for (std::int32_t fan = 0; fan < num_fans[p]; ++fan) mesh.point_of_vertex.push_back(static_cast<std::int32_t>(p));
    if (num_fans[p] == 0) ++mesh.num_unused;
    if (num_fans[p] > 1) mesh.num_split += num_fans[p] - 1;
  }
  mesh.triangles.resize(triangles.size());
  for (std::int32_t corner = 0; corner < num_corners; ++corner)
    mesh.triangles[at(corner / 3)][at(corner % 3)] = first_vertex[at(point(corner))] + fan_of_corner[at(corner)];
  return mesh;
}

std::vector<std::int32_t> edge_components(const std::vector<std::int32_t>& twins, std::int32_t* num_components) {
  const std::size_t num_triangles = twins.size() / 3;
  std::vector<std::int32_t> component(num_triangles, -1);
  std::vector<std::int32_t> stack;
  std::int32_t count = 0;
  for (std::size_t seed = 0; seed < num_triangles; ++seed) {
    if (component[seed] >= 0) continue;
    component[seed] = count;
    stack.push_back(static_cast<std::int32_t>(seed));
    while (!stack.empty()) {
      const std::int32_t t = stack.back();
      stack.pop_back();
      for (std::int32_t h = 3 * t; h < 3 * t + 3; ++h) {
        if (twins[at(h)] < 0) continue;
        const std::int32_t neighbour = twins[at(h)] / 3;
        if (component[at(neighbour)] >= 0) continue;
        component[at(neighbour)] = count;
        stack.push_back(neighbour);
      }
    }
    ++count;
  }
  if (num_components != nullptr) *num_components = count;
  return component;
}

}  // namespace meshmser
