#include <algorithm>

#include "stages/export/export_files.hpp"

namespace meshmser {
namespace {

template <class ElementOf>
std::vector<std::int32_t> vote(std::size_t num_elements, const TriangleMesh& mesh,
                               std::span<const std::int32_t> label_of_triangle, ElementOf&& element_of) {
  // Labels around each element, gathered by counting: triangles in order, so that the result depends on nothing else.
  std::vector<std::int64_t> first(num_elements + 1, 0);
  for (const auto& triangle : mesh.triangles)
    for (const std::int32_t v : triangle) ++first[static_cast<std::size_t>(element_of(v)) + 1];
  for (std::size_t e = 0; e < num_elements; ++e) first[e + 1] += first[e];
  std::vector<std::int32_t> around(static_cast<std::size_t>(first.back()));
  std::vector<std::int64_t> next(first.begin(), first.end() - 1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const std::int32_t v : mesh.triangles[t])
      around[static_cast<std::size_t>(next[static_cast<std::size_t>(element_of(v))]++)] = label_of_triangle[t];
  std::vector<std::int32_t> winner(num_elements, -1);
  for (std::size_t e = 0; e < num_elements; ++e) {
    const auto begin = around.begin() + first[e], end = around.begin() + first[e + 1];
    std::sort(begin, end);
    std::ptrdiff_t most = 0;
    for (auto run = begin; run != end;) {
      const auto stop = std::upper_bound(run, end, *run);
      if (stop - run > most || (stop - run == most && winner[e] == 0)) {
        most = stop - run;
        winner[e] = *run;
      }
      run = stop;
    }
  }
  return winner;
}

}  // namespace

std::vector<std::int32_t> label_of_vertices(const TriangleMesh& mesh, std::span<const std::int32_t> label_of_triangle) {
  return vote(mesh.num_vertices(), mesh, label_of_triangle, [](std::int32_t v) { return v; });
}

std::vector<std::int32_t> label_of_points(std::size_t num_points, const TriangleMesh& mesh,
                                          std::span<const std::int32_t> label_of_triangle) {
  return vote(num_points, mesh, label_of_triangle,
              [&](std::int32_t v) { return mesh.point_of_vertex[static_cast<std::size_t>(v)]; });
}

}  // namespace meshmser
