#pragma once
/// What one would write in an afternoon: honest, in vectors, no tricks. The yardstick of the benchmarks.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace meshmser::bench {

/// Twin half-edges by std::map from an edge's two vertices. `erase_met`: an edge leaves the map when its second
/// triangle has come, so that where ids are in order the map holds a front of the mesh only and stays in the
/// processor's cache: two to three times as fast there, the same where ids are shuffled.
std::vector<std::int32_t> plain_twins(std::span<const std::array<std::int32_t, 3>> triangles, bool erase_met);

/// A component tree over triangles: one triangle of each node stands for it.
struct PlainTree {
  std::vector<std::int32_t>
      parent;                ///< #F: of a node's triangle its parent's; of others their own node's; a root's own
  std::vector<double> area;  ///< #F: of the node, where the triangle stands for one
  std::int64_t num_nodes = 0;
};

/// The component tree by std::sort of the triangles by value and the textbook union-find of component trees, with path
/// compression, whose sets stand under the triangle met last, then canonisation (Berger et al. 2007; Carlinet and
/// Géraud 2014, algorithm 1). `by_rank`: sets are joined by rank and know their last triangle beside (Najman and
/// Couprie 2006; there algorithm 2): more to write, and less than twice as slow on shuffled ids as on ordered ones
/// where the other is thrice. `Value`: levels, or the scalar itself.
template <class Value>
PlainTree plain_tree(std::span<const std::int32_t> twins, std::span<const double> areas, std::span<const Value> values,
                     bool by_rank);

}  // namespace meshmser::bench
