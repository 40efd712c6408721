#include "tests/bench/plain_reference.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

namespace meshmser::bench {
namespace {

std::size_t at(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

struct UnionFind {
  UnionFind(std::size_t n, bool by_rank) : parent(n), rank(by_rank ? n : 0, 0) {
    std::iota(parent.begin(), parent.end(), 0);
  }

  std::int32_t find(std::int32_t x) {
    std::int32_t root = x;
    while (parent[at(root)] != root) root = parent[at(root)];
    while (parent[at(x)] != root) x = std::exchange(parent[at(x)], root);
    return root;
  }

  /// Returns the set's new representative: without ranks `a`.
  std::int32_t unite(std::int32_t a, std::int32_t b) {
    if (!rank.empty()) {
      if (rank[at(a)] < rank[at(b)]) std::swap(a, b);
      rank[at(a)] = static_cast<std::uint8_t>(rank[at(a)] + (rank[at(a)] == rank[at(b)]));
    }
    parent[at(b)] = a;
    return a;
  }

  std::vector<std::int32_t> parent;
  std::vector<std::uint8_t> rank;
};

}  // namespace

std::vector<std::int32_t> plain_twins(std::span<const std::array<std::int32_t, 3>> triangles, bool erase_met) {
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> first_seen;
  std::vector<std::int32_t> twins(3 * triangles.size(), -1);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t from = triangles[t][k], to = triangles[t][(k + 1) % 3];
      const auto h = static_cast<std::int32_t>(3 * t + k);
      const auto [place, is_new] = first_seen.try_emplace({std::min(from, to), std::max(from, to)}, h);
      if (is_new) continue;
      twins[at(h)] = place->second;
      twins[at(place->second)] = h;
      if (erase_met) first_seen.erase(place);
    }
  return twins;
}

template <class Value>
PlainTree plain_tree(std::span<const std::int32_t> twins, std::span<const double> areas, std::span<const Value> values,
                     bool by_rank) {
  const std::size_t n = values.size();
  std::vector<std::int32_t> order(n);
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) { return values[at(a)] > values[at(b)]; });
  PlainTree tree;
  tree.parent.assign(n, -1);
  UnionFind sets(n, by_rank);
  // The latest triangle of a set, under which it hangs; without ranks it stands for the set itself.
  std::vector<std::int32_t> last_of_set(by_rank ? n : 0);
  for (const std::int32_t t : order) {
    tree.parent[at(t)] = t;
    if (by_rank) last_of_set[at(t)] = t;
    std::int32_t set = t;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t twin = twins[3 * at(t) + k];
      if (twin < 0 || tree.parent[at(twin / 3)] < 0) continue;
      const std::int32_t other = sets.find(twin / 3);
      if (other == set) continue;
      tree.parent[at(by_rank ? last_of_set[at(other)] : other)] = t;
      set = sets.unite(set, other);
      if (by_rank) last_of_set[at(set)] = t;
    }
  }
  tree.area.assign(areas.begin(), areas.end());
  for (const std::int32_t t : order)
    if (tree.parent[at(t)] != t) tree.area[at(tree.parent[at(t)])] += tree.area[at(t)];
  for (std::size_t i = n; i-- > 0;) {
    const std::int32_t t = order[i], parent = tree.parent[at(t)];
    if (values[at(tree.parent[at(parent)])] == values[at(parent)]) tree.parent[at(t)] = tree.parent[at(parent)];
    tree.num_nodes += tree.parent[at(t)] == t || values[at(tree.parent[at(t)])] != values[at(t)];
  }
  return tree;
}

template PlainTree plain_tree(std::span<const std::int32_t>, std::span<const double>, std::span<const std::int32_t>,
                              bool);
template PlainTree plain_tree(std::span<const std::int32_t>, std::span<const double>, std::span<const double>, bool);

}  // namespace meshmser::bench
