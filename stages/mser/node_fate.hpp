#pragma once
/// What became of a node of a component tree in selection and filters is written down in the branches that decide.

#include <cstddef>
#include <vector>

#include "pipeline/artifacts/node_fate.hpp"

namespace meshmser {

/// The fates of a tree's nodes (#N), or nullptr where nobody asks.
using NodeFates = std::vector<NodeFate>;

/// Writes a node's fate where somebody asks.
inline void tell_fate(NodeFates* fates, std::size_t node, const NodeFate& fate) {
  if (fates != nullptr) (*fates)[node] = fate;
}

}  // namespace meshmser
