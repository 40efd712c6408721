#include "stages/mser/filters.hpp"

#include <algorithm>
#include <numeric>
#include <queue>

#include "stages/common/tree_nodes.hpp"
#include "stages/mser/stability.hpp"

namespace meshmser {
namespace {

template <class Keep>
std::vector<std::int32_t> keep_if(std::span<const std::int32_t> selected, Keep keep) {
  std::vector<std::int32_t> kept;
  std::copy_if(selected.begin(), selected.end(), std::back_inserter(kept), keep);
  return kept;
}

void tell_rival(NodeFates* fates, std::int32_t node, std::int32_t rival) {
  if (fates != nullptr) (*fates)[static_cast<std::size_t>(node)].rival = rival;
}

std::strong_ordering compare_nodes(const ComponentTree& tree, std::span<const std::int64_t> changes, std::int32_t a,
                                   std::int32_t b) {
  const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
  return compare_stability(changes[i], tree.area_of_node[i], changes[j], tree.area_of_node[j]);
}

std::vector<std::int32_t> filter_most_stable(const ComponentTree& tree, std::span<const std::int64_t> changes,
                                             std::span<const std::int32_t> selected, NodeFates* fates) {
  const std::vector<std::int32_t> smallest = smallest_triangle_of_nodes(tree);
  const std::vector<std::int32_t> ancestor = nearest_listed_ancestors(tree, selected);
  std::vector<std::int32_t> order(selected.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](std::int32_t i, std::int32_t j) {
    const std::int32_t a = selected[static_cast<std::size_t>(i)], b = selected[static_cast<std::size_t>(j)];
    const auto m = static_cast<std::size_t>(a), n = static_cast<std::size_t>(b);
    std::strong_ordering less = compare_nodes(tree, changes, a, b);
    if (less == 0)
      less = compare_area(tree.area_of_node[n], tree.area_exponent_of_node[n], tree.area_of_node[m],
                          tree.area_exponent_of_node[m]);
    if (less == 0) less = smallest[m] <=> smallest[n];
    if (less == 0) less = b <=> a;
    return less < 0;
  });
  std::vector<std::uint8_t> taken(selected.size(), 0);
  // One of the taken that each holds, itself included, or -1.
  std::vector<std::int32_t> holds_taken(selected.size(), -1);
  const auto node_at = [&](std::int32_t i) { return selected[static_cast<std::size_t>(i)]; };
  for (const std::int32_t i : order) {
    if (holds_taken[static_cast<std::size_t>(i)] >= 0) {
      tell_rival(fates, node_at(i), node_at(holds_taken[static_cast<std::size_t>(i)]));
      continue;
    }
    std::int32_t above = ancestor[static_cast<std::size_t>(i)];
    while (above >= 0 && taken[static_cast<std::size_t>(above)] == 0) above = ancestor[static_cast<std::size_t>(above)];
    if (above >= 0) {
      tell_rival(fates, node_at(i), node_at(above));
      continue;
    }
    taken[static_cast<std::size_t>(i)] = 1;
    for (above = i; above >= 0 && holds_taken[static_cast<std::size_t>(above)] < 0;
         above = ancestor[static_cast<std::size_t>(above)])
      holds_taken[static_cast<std::size_t>(above)] = i;
  }
  std::vector<std::int32_t> kept;
  for (std::size_t i = 0; i < selected.size(); ++i)
    if (taken[i] != 0) kept.push_back(selected[i]);
  return kept;
}

}  // namespace

std::vector<std::int32_t> filter_area(const ComponentTree& tree, std::span<const std::int32_t> selected, double least,
                                      double most) {
  return keep_if(selected, [&](std::int32_t node) {
    const double area = area_of_node(tree, node);
    return area >= least && area <= most;
  });
}

std::vector<std::int32_t> filter_variation(const ComponentTree& tree, std::span<const std::int64_t> changes,
                                           std::span<const std::int32_t> selected, double most) {
  return keep_if(selected, [&](std::int32_t node) { return stability_of_node(tree, changes, node) <= most; });
}

std::vector<std::int32_t> filter_persistence(const Maxima& maxima, std::span<const std::int32_t> selected,
                                             double least) {
  return keep_if(selected, [&](std::int32_t node) { return maxima.persistence_of_node(node) >= least; });
}

std::vector<std::int32_t> filter_diversity(const ComponentTree& tree, std::span<const std::int64_t> changes,
                                           std::span<const std::int32_t> selected, double least, NodeFates* fates) {
  if (least <= 0 || selected.empty()) return {selected.begin(), selected.end()};
  const std::vector<std::int32_t> smallest = smallest_triangle_of_nodes(tree);
  const std::vector<std::int32_t> ancestor = nearest_listed_ancestors(tree, selected);
  const auto node_at = [&](std::int32_t i) { return selected[static_cast<std::size_t>(i)]; };
  // Smallest triangle first; of nodes that share it the larger, which comes later in the postorder.
  const auto later = [&](std::int32_t i, std::int32_t j) {
    const std::int32_t a = smallest[static_cast<std::size_t>(node_at(i))],
                       b = smallest[static_cast<std::size_t>(node_at(j))];
    return a != b ? a > b : i < j;
  };
  // The nodes that stay nearest below each, as far as resolved.
  std::vector<std::vector<std::int32_t>> below(selected.size());
  std::vector<std::uint8_t> stays(selected.size(), 1);
  for (std::size_t i = 0; i < selected.size(); ++i) {
    const auto self = static_cast<std::int32_t>(i);
    const double area = area_of_node(tree, node_at(self));
    std::priority_queue<std::int32_t, std::vector<std::int32_t>, decltype(later)> waiting(later, std::move(below[i]));
    std::vector<std::int32_t> nearest;
    while (!waiting.empty()) {
      const std::int32_t other = waiting.top();
      waiting.pop();
      const bool alike = stays[i] != 0 && area - area_of_node(tree, node_at(other)) < least * area;
      if (alike && compare_nodes(tree, changes, node_at(other), node_at(self)) >= 0) {
        stays[static_cast<std::size_t>(other)] = 0;
        tell_rival(fates, node_at(other), node_at(self));
        for (const std::int32_t next : below[static_cast<std::size_t>(other)]) waiting.push(next);
        continue;
      }
      if (alike) {
        stays[i] = 0;
        tell_rival(fates, node_at(self), node_at(other));
      }
      nearest.push_back(other);
    }
    below[i] = std::move(nearest);
    if (ancestor[i] < 0) continue;
    std::vector<std::int32_t>& above = below[static_cast<std::size_t>(ancestor[i])];
    if (stays[i] != 0)
      above.push_back(self);
    else
      above.insert(above.end(), below[i].begin(), below[i].end());
  }
  std::vector<std::int32_t> kept;
  for (std::size_t i = 0; i < selected.size(); ++i)
    if (stays[i] != 0) kept.push_back(selected[i]);
  return kept;
}

std::vector<std::int32_t> filter_nested(const ComponentTree& tree, std::span<const std::int64_t> changes,
                                        std::span<const std::int32_t> selected, Nested nested, NodeFates* fates) {
  if (nested == Nested::kKeep) return {selected.begin(), selected.end()};
  if (nested == Nested::kMostStable) return filter_most_stable(tree, changes, selected, fates);
  const std::vector<std::int32_t> ancestor = nearest_listed_ancestors(tree, selected);
  // For whom each goes: the nearest around it, or the first within it; an index into `selected`, or -1.
  std::vector<std::int32_t> rival(nested == Nested::kOutermost ? ancestor
                                                               : std::vector<std::int32_t>(selected.size(), -1));
  if (nested == Nested::kInnermost)
    for (std::size_t i = selected.size(); i-- > 0;)
      if (ancestor[i] >= 0) rival[static_cast<std::size_t>(ancestor[i])] = static_cast<std::int32_t>(i);
  std::vector<std::int32_t> kept;
  for (std::size_t i = 0; i < selected.size(); ++i)
    if (rival[i] < 0)
      kept.push_back(selected[i]);
    else
      tell_rival(fates, selected[i], selected[static_cast<std::size_t>(rival[i])]);
  return kept;
}

}  // namespace meshmser
