#pragma once
/// Half-edges of several owners found in one walk over the triangles, put side by side by owner.

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

#include "pipeline/execution/execution.hpp"
#include "stages/common/parallel.hpp"

namespace meshmser {

struct OwnedHalfEdge {
  std::int32_t owner;
  std::int32_t half_edge;
};

struct HalfEdgesByOwner {
  std::vector<std::int32_t> half_edges;      ///< by owner, then in the order found
  std::vector<std::int64_t> first_of_owner;  ///< #owners + 1
};

/// `emit(begin, end, list)` appends to `list` what the triangles begin .. end have, with owners in 0 .. num_owners - 1,
/// in the order wanted within an owner; it is called for chunks of fixed borders, on several threads. A half-edge may
/// have many owners or none. Time linear in triangles, owners and what is found; 12 bytes for each found at most.
template <class Emit>
HalfEdgesByOwner gather_by_owner(std::size_t num_triangles, std::size_t num_owners, Emit&& emit,
                                 const Execution& execution) {
  constexpr std::size_t kTrianglesPerChunk = std::size_t{1} << 16;
  std::vector<std::vector<OwnedHalfEdge>> of_chunk((num_triangles + kTrianglesPerChunk - 1) / kTrianglesPerChunk);
  parallel_chunks(static_cast<std::int64_t>(num_triangles), kTrianglesPerChunk, "", execution,
                  [&](std::int64_t begin, std::int64_t end) {
                    // To its own size: all lists together are what takes most memory here.
                    std::vector<OwnedHalfEdge> list;
                    emit(static_cast<std::size_t>(begin), static_cast<std::size_t>(end), list);
                    of_chunk[static_cast<std::size_t>(begin) / kTrianglesPerChunk].assign(list.begin(), list.end());
                  });
  HalfEdgesByOwner found;
  found.first_of_owner.assign(num_owners + 1, 0);
  for (const std::vector<OwnedHalfEdge>& list : of_chunk)
    for (const OwnedHalfEdge& e : list) ++found.first_of_owner[static_cast<std::size_t>(e.owner) + 1];
  std::partial_sum(found.first_of_owner.begin(), found.first_of_owner.end(), found.first_of_owner.begin());
  found.half_edges.resize(static_cast<std::size_t>(found.first_of_owner.back()));
  std::vector<std::int64_t> place(found.first_of_owner.begin(), found.first_of_owner.end() - 1);
  for (std::vector<OwnedHalfEdge>& list : of_chunk) {
    for (const OwnedHalfEdge& e : list)
      found.half_edges[static_cast<std::size_t>(place[static_cast<std::size_t>(e.owner)]++)] = e.half_edge;
    std::vector<OwnedHalfEdge>().swap(list);
  }
  return found;
}

}  // namespace meshmser
