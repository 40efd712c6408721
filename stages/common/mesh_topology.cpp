#include "stages/common/mesh_topology.hpp"

#include <algorithm>
#include <functional>

namespace meshmser {
namespace {

std::size_t at(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

std::string triangle_text(const std::vector<std::array<std::int32_t, 3>>& triangles, std::size_t t) {
  const auto& corners = triangles[t];
  return "triangle " + std::to_string(t) + " (vertices " + std::to_string(corners[0]) + ", " +
         std::to_string(corners[1]) + ", " + std::to_string(corners[2]) + ")";
}

/// At one vertex, a triangle: the next vertex after it and the one before.
struct Corner {
  std::int32_t triangle, next, previous;
};

}  // namespace

std::int64_t MeshTopology::loops_longer_than(std::int64_t edges) const {
  return std::count_if(border_loops.begin(), border_loops.end(), [&](std::int64_t length) { return length > edges; });
}

MeshTopology describe_topology(const std::vector<std::array<std::int32_t, 3>>& triangles, std::size_t num_vertices,
                               const Execution& execution) {
  MeshTopology topology;
  topology.num_triangles = static_cast<std::int64_t>(triangles.size());

  std::vector<std::int64_t> first(num_vertices + 1, 0);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t v = triangles[t][k];
      if (v < 0 || at(v) >= num_vertices) {
        topology.defect =
            triangle_text(triangles, t) + " has a corner that is no vertex of " + std::to_string(num_vertices);
        return topology;
      }
      if (v == triangles[t][(k + 1) % 3]) {
        topology.defect = triangle_text(triangles, t) + " has one vertex twice";
        return topology;
      }
      ++first[at(v) + 1];
    }
  }
  for (std::size_t v = 0; v < num_vertices; ++v) first[v + 1] += first[v];
  std::vector<Corner> corners(3 * triangles.size());
  {
    std::vector<std::int64_t> place(first.begin(), first.end() - 1);
    for (std::size_t t = 0; t < triangles.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k)
        corners[static_cast<std::size_t>(place[at(triangles[t][k])]++)] = {
            static_cast<std::int32_t>(t), triangles[t][(k + 1) % 3], triangles[t][(k + 2) % 3]};
  }

  // Each vertex's triangles must chain into one fan: previous of one = next of the following. A border edge leaves the
  // vertex toward the `next` that is nobody's `previous`.
  std::vector<std::int32_t> border_successor(num_vertices, -1);
  std::vector<std::int32_t> union_parent(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) union_parent[t] = static_cast<std::int32_t>(t);
  const auto find = [&](std::int32_t t) {
    while (union_parent[at(t)] != t) t = union_parent[at(t)] = union_parent[at(union_parent[at(t)])];
    return t;
  };
  std::int64_t num_half_edges_with_twin = 0;
  for (std::size_t v = 0; v < num_vertices; ++v) {
    if (v % 65536 == 0) execution.check();
    const auto begin = corners.begin() + first[v], end = corners.begin() + first[v + 1];
    if (begin == end) continue;
    ++topology.num_vertices;
    const Corner* start = &*begin;
    for (auto corner = begin; corner != end; ++corner) {
      std::int64_t same = 0, before = 0;
      for (auto other = begin; other != end; ++other) {
        if (other->next == corner->next) ++same;
        if (other->previous == corner->next) {
          ++before;
          union_parent[at(find(other->triangle))] = find(corner->triangle);
        }
      }
      if (same > 1 || before > 1) {
        topology.defect = "the edge between the vertices " + std::to_string(v) + " and " +
                          std::to_string(corner->next) + " is used by several triangles in one direction, among them " +
                          triangle_text(triangles, at(corner->triangle));
        return topology;
      }
      num_half_edges_with_twin += before;
      if (before == 0) {
        if (border_successor[v] >= 0) {
          topology.defect = "the vertex " + std::to_string(v) + " has several fans of triangles";
          return topology;
        }
        border_successor[v] = corner->next;
        start = &*corner;
      }
    }
    std::int64_t chained = 1;
    const Corner* corner = start;
    for (bool found = true; found;) {
      found = false;
      for (auto other = begin; other != end; ++other) {
        if (other->next != corner->previous || &*other == start) continue;
        corner = &*other;
        ++chained;
        found = true;
        break;
      }
    }
    if (chained != end - begin) {
      topology.defect = "the vertex " + std::to_string(v) + " has several fans of triangles";
      return topology;
    }
  }

  const std::int64_t num_half_edges = 3 * topology.num_triangles;
  topology.num_border_edges = num_half_edges - num_half_edges_with_twin;
  topology.num_edges = num_half_edges_with_twin / 2 + topology.num_border_edges;
  topology.euler = topology.num_vertices - topology.num_edges + topology.num_triangles;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    if (find(static_cast<std::int32_t>(t)) == static_cast<std::int32_t>(t)) ++topology.num_components;
  for (std::size_t v = 0; v < num_vertices; ++v) {
    std::int64_t length = 0;
    for (std::int32_t u = static_cast<std::int32_t>(v); border_successor[at(u)] >= 0; ++length) {
      const std::int32_t next = border_successor[at(u)];
      border_successor[at(u)] = -1;
      u = next;
    }
    if (length > 0) topology.border_loops.push_back(length);
  }
  std::sort(topology.border_loops.begin(), topology.border_loops.end(), std::greater<>());
  return topology;
}

}  // namespace meshmser
