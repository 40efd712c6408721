#pragma once
/// The sides of triangles across which some nodes of a component tree end.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "pipeline/artifacts/level_set_trees.hpp"
#include "pipeline/execution/execution.hpp"
#include "stages/common/gather_by_owner.hpp"

namespace meshmser {

/// No node of the list; after all others, since children come before their parents.
inline constexpr std::uint32_t kNoPlace = ~std::uint32_t{0};

/// Places in a list of nodes of a component tree, ascending.
struct NodePlaces {
  std::unique_ptr<std::uint32_t[]> of_triangle;  ///< of the smallest node of the list that holds it, or kNoPlace
  std::vector<std::uint32_t> outer;              ///< of places, that of the nearest node around it, or kNoPlace
};

/// O(N + F).
NodePlaces places_of_nodes(const ComponentTree& tree, std::span<const std::int32_t> nodes, const Execution& execution);

/// Lists half-edges of triangles by the nodes that end there. Of two neighbouring triangles one's node is an
/// ancestor of the other's, so what parts them are the listed nodes from one's smallest up to the other's.
class OwnedEdges {
 public:
  /// `list` gets longer than what is found, until `finish`.
  OwnedEdges(std::vector<OwnedHalfEdge>& list, const NodePlaces& places) : list_(list), outer_(places.outer.data()) {}

  /// `here`: the place of triangle t; `there`: those of its neighbours, `here` where there is none. `owner_of(place)`:
  /// what is put down.
  template <class OwnerOf>
  void put(std::size_t t, std::uint32_t here, const std::array<std::uint32_t, 3>& there, OwnerOf&& owner_of) {
    const std::uint32_t farthest = std::max({there[0], there[1], there[2]});
    for (std::uint32_t at = here; at < farthest; at = outer_[at]) {
      if (list_.size() < count_ + 4) list_.resize(2 * count_ + 1024);
      // Which of the three it is is hard to foresee, so each is written and stays there or not.
      const std::int32_t owner = owner_of(at);
      for (std::size_t k = 0; k < 3; ++k) {
        list_[count_] = {owner, static_cast<std::int32_t>(3 * t + k)};
        count_ += static_cast<std::size_t>(at < there[k]);
      }
    }
  }

  void finish() { list_.resize(count_); }

 private:
  std::vector<OwnedHalfEdge>& list_;
  const std::uint32_t* outer_;
  std::size_t count_ = 0;
};

}  // namespace meshmser
