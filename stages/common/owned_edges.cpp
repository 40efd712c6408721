#include "stages/common/owned_edges.hpp"

#include "stages/common/large_pages.hpp"
#include "stages/common/parallel.hpp"
#include "stages/common/tree_nodes.hpp"

namespace meshmser {

NodePlaces places_of_nodes(const ComponentTree& tree, std::span<const std::int32_t> nodes, const Execution& execution) {
  // -1, none, becomes kNoPlace.
  const std::vector<std::int32_t> smallest = smallest_listed_nodes(tree, nodes),
                                  ancestors = nearest_listed_ancestors(tree, nodes);
  NodePlaces places;
  places.outer.assign(ancestors.begin(), ancestors.end());
  const std::size_t num_triangles = tree.node_of_triangle.size();
  places.of_triangle = make_on_large_pages<std::uint32_t>(num_triangles);
  parallel_chunks(static_cast<std::int64_t>(num_triangles), 1 << 16, "", execution,
                  [&](std::int64_t begin, std::int64_t end) {
                    for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t) {
                      const std::int32_t node = tree.node_of_triangle[t];
                      places.of_triangle[t] =
                          node < 0 ? kNoPlace : static_cast<std::uint32_t>(smallest[static_cast<std::size_t>(node)]);
                    }
                  });
  return places;
}

}  // namespace meshmser
