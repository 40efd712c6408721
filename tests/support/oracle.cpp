#include "tests/support/oracle.hpp"

#include <algorithm>
#include <stdexcept>

namespace meshmser::oracle {
namespace {

bool contains(const Triangles& outer, const Triangles& inner) {
  return std::includes(outer.begin(), outer.end(), inner.begin(), inner.end());
}

std::int64_t total_area(const Surface& surface, const Triangles& triangles) {
  std::int64_t sum = 0;
  for (const int t : triangles) sum += surface.area[static_cast<std::size_t>(t)];
  return sum;
}

/// The two end points of half-edge 3 t + k.
std::pair<int, int> ends(const Surface& surface, int half_edge) {
  const auto& c = surface.corners[static_cast<std::size_t>(half_edge / 3)];
  return {c[static_cast<std::size_t>(half_edge % 3)], c[static_cast<std::size_t>((half_edge + 1) % 3)]};
}

/// The half-edge that runs the other way along the same edge; -1: none.
int opposite(const Surface& surface, int half_edge) {
  const auto [from, to] = ends(surface, half_edge);
  for (int other = 0; other < static_cast<int>(3 * surface.corners.size()); ++other)
    if (!surface.cut_out[static_cast<std::size_t>(other / 3)] && ends(surface, other) == std::pair{to, from})
      return other;
  return -1;
}

/// Indices of the nodes that hold no smaller node.
std::vector<int> leaves(const std::vector<Node>& nodes) {
  std::set<int> parents;
  for (const Node& node : nodes) parents.insert(node.parent);
  std::vector<int> found;
  for (int n = 0; n < static_cast<int>(nodes.size()); ++n)
    if (!parents.contains(n)) found.push_back(n);
  return found;
}

bool is_higher(const Node& a, const Node& b) {
  return a.hi != b.hi ? a.hi > b.hi : *a.triangles.begin() < *b.triangles.begin();
}

}  // namespace

int level_of(const std::array<int, 3>& corners, const std::vector<double>& values, const std::vector<double>& levels) {
  int best = 0;
  for (int k = 1; k <= static_cast<int>(levels.size()); ++k) {
    bool all = true;
    for (const int v : corners)
      all = all && values[static_cast<std::size_t>(v)] >= levels[static_cast<std::size_t>(k) - 1];
    if (all) best = k;
  }
  return best;
}

bool share_an_edge(const Surface& surface, int a, int b) {
  if (a == b || surface.cut_out[static_cast<std::size_t>(a)] || surface.cut_out[static_cast<std::size_t>(b)])
    return false;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const auto [from, to] = ends(surface, 3 * a + i);
      if (ends(surface, 3 * b + j) == std::pair{to, from}) return true;
    }
  return false;
}

std::vector<std::vector<int>> neighbours_of(const Surface& surface) {
  const int num_triangles = static_cast<int>(surface.corners.size());
  std::vector<std::vector<int>> neighbours(surface.corners.size());
  for (int a = 0; a < num_triangles; ++a)
    for (int b = 0; b < num_triangles; ++b)
      if (share_an_edge(surface, a, b)) neighbours[static_cast<std::size_t>(a)].push_back(b);
  return neighbours;
}

std::vector<Triangles> connected_parts(const std::vector<std::vector<int>>& neighbours, const Triangles& members) {
  std::vector<Triangles> parts;
  Triangles left = members;
  while (!left.empty()) {
    Triangles part = {*left.begin()}, rim = part;
    while (!rim.empty()) {
      Triangles next;
      for (const int t : rim)
        for (const int u : neighbours[static_cast<std::size_t>(t)])
          if (members.contains(u) && !part.contains(u)) next.insert(u);
      part.insert(next.begin(), next.end());
      rim = next;
    }
    for (const int t : part) left.erase(t);
    parts.push_back(part);
  }
  return parts;
}

std::vector<Node> all_nodes(const Surface& surface) {
  const auto neighbours = neighbours_of(surface);
  std::map<Triangles, std::set<int>> levels_of_set;
  for (int k = 1; k <= surface.num_levels; ++k) {
    Triangles at_least;
    for (int t = 0; t < static_cast<int>(surface.corners.size()); ++t)
      if (!surface.cut_out[static_cast<std::size_t>(t)] && surface.level[static_cast<std::size_t>(t)] >= k)
        at_least.insert(t);
    for (const Triangles& part : connected_parts(neighbours, at_least)) levels_of_set[part].insert(k);
  }
  std::vector<Node> nodes;
  for (const auto& [triangles, levels] : levels_of_set) {
    if (*levels.rbegin() - *levels.begin() + 1 != static_cast<int>(levels.size()))
      throw std::logic_error("a component vanishes and comes back");
    nodes.push_back({triangles, *levels.begin(), *levels.rbegin(), -1});
  }
  std::sort(nodes.begin(), nodes.end(), [](const Node& a, const Node& b) {
    return std::pair(a.triangles.size(), *a.triangles.begin()) < std::pair(b.triangles.size(), *b.triangles.begin());
  });
  for (std::size_t n = 0; n < nodes.size(); ++n)
    for (std::size_t m = n + 1; m < nodes.size() && nodes[n].parent < 0; ++m)
      if (contains(nodes[m].triangles, nodes[n].triangles)) nodes[n].parent = static_cast<int>(m);
  return nodes;
}

int compare(const Ratio& a, const Ratio& b) {
  if (a.second == 0 || b.second == 0) return (a.second == 0 ? 1 : 0) - (b.second == 0 ? 1 : 0);
  const auto left = static_cast<long double>(a.first) * static_cast<long double>(b.second);
  const auto right = static_cast<long double>(b.first) * static_cast<long double>(a.second);
  return (left > right ? 1 : 0) - (left < right ? 1 : 0);
}

std::vector<Ratio> stability(const Surface& surface, const std::vector<Node>& nodes, int delta) {
  const auto neighbours = neighbours_of(surface);
  std::vector<Ratio> q;
  for (const Node& node : nodes) {
    const int middle = (node.lo + node.hi) / 2;
    const int lower = std::max(1, middle - delta), upper = middle + delta;
    Triangles at_least;
    for (int t = 0; t < static_cast<int>(surface.corners.size()); ++t)
      if (!surface.cut_out[static_cast<std::size_t>(t)] && surface.level[static_cast<std::size_t>(t)] >= lower)
        at_least.insert(t);
    std::int64_t up = -1, down = 0;
    for (const Triangles& part : connected_parts(neighbours, at_least))
      if (contains(part, node.triangles)) up = total_area(surface, part);
    for (const int t : node.triangles)
      if (surface.level[static_cast<std::size_t>(t)] >= upper) down += surface.area[static_cast<std::size_t>(t)];
    q.emplace_back(up - down, total_area(surface, node.triangles));
  }
  return q;
}

std::set<Triangles> selection(const Surface& surface, const std::vector<Node>& nodes, const std::vector<Ratio>& q,
                              bool main_child_only) {
  const auto neighbours = neighbours_of(surface);
  const auto num_nodes = static_cast<int>(nodes.size());
  const auto node_area = [&](int n) { return total_area(surface, nodes[static_cast<std::size_t>(n)].triangles); };
  std::set<std::pair<int, int>> linked;
  for (int parent = 0; parent < num_nodes; ++parent) {
    std::vector<int> children;
    for (int n = 0; n < num_nodes; ++n)
      if (nodes[static_cast<std::size_t>(n)].parent == parent) children.push_back(n);
    if (main_child_only && !children.empty())
      children = {*std::min_element(children.begin(), children.end(), [&](int a, int b) {
        return std::pair(-node_area(a), *nodes[static_cast<std::size_t>(a)].triangles.begin()) <
               std::pair(-node_area(b), *nodes[static_cast<std::size_t>(b)].triangles.begin());
      })};
    for (const int child : children) {
      linked.emplace(parent, child);
      linked.emplace(child, parent);
    }
  }
  std::set<Triangles> selected;
  for (int n = 0; n < num_nodes; ++n) {
    const Node& node = nodes[static_cast<std::size_t>(n)];
    const Ratio& mine = q[static_cast<std::size_t>(n)];
    if (node.parent < 0) {
      bool open = false;
      for (const int t : node.triangles)
        for (const int u : neighbours[static_cast<std::size_t>(t)])
          open = open || surface.level[static_cast<std::size_t>(u)] == 0;
      if (!open) continue;
    }
    std::set<int> plateau = {n};
    for (bool grew = true; grew;) {
      grew = false;
      for (const auto& [a, b] : linked)
        if (plateau.contains(a) && !plateau.contains(b) && compare(mine, q[static_cast<std::size_t>(b)]) == 0) {
          plateau.insert(b);
          grew = true;
        }
    }
    bool lowest = true, largest = true;
    for (const auto& [a, b] : linked)
      if (plateau.contains(a) && compare(q[static_cast<std::size_t>(b)], mine) < 0) lowest = false;
    for (const int m : plateau)
      if (nodes[static_cast<std::size_t>(m)].triangles.size() > node.triangles.size()) largest = false;
    const bool zero = mine.second != 0 && mine.first == 0;
    if (zero || (lowest && largest)) selected.insert(node.triangles);
  }
  return selected;
}

std::map<Triangles, Lifetime> lifetimes(const std::vector<Node>& nodes, const std::vector<double>& heights) {
  std::map<Triangles, Lifetime> result;
  const std::vector<int> all_leaves = leaves(nodes);
  for (const int leaf : all_leaves) {
    const Node& mine = nodes[static_cast<std::size_t>(leaf)];
    Lifetime life{heights.back() - heights.front(), mine.triangles};
    for (int n = leaf; n >= 0; n = nodes[static_cast<std::size_t>(n)].parent) {
      const Node& node = nodes[static_cast<std::size_t>(n)];
      bool beaten = false;
      for (const int other : all_leaves)
        beaten = beaten || (contains(node.triangles, nodes[static_cast<std::size_t>(other)].triangles) &&
                            is_higher(nodes[static_cast<std::size_t>(other)], mine));
      if (beaten) {
        life.persistence =
            heights[static_cast<std::size_t>(mine.hi) - 1] - heights[static_cast<std::size_t>(node.hi) - 1];
        break;
      }
      life.top = node.triangles;
    }
    result[mine.triangles] = life;
  }
  return result;
}

std::set<Triangles> persistent(const Surface& surface, const std::vector<Node>& nodes,
                               const std::vector<double>& heights, double min_persistence, std::int64_t min_area,
                               const std::vector<Ratio>* q) {
  std::vector<Triangles> significant;
  for (const auto& [leaf, life] : lifetimes(nodes, heights))
    if (life.persistence > min_persistence && total_area(surface, life.top) >= min_area) significant.push_back(leaf);
  const auto count = [&](const Node& node) {
    return std::count_if(significant.begin(), significant.end(),
                         [&](const Triangles& leaf) { return contains(node.triangles, leaf); });
  };
  std::set<Triangles> chosen;
  for (const Node& node : nodes) {
    if (node.parent < 0 || count(node) != 1 || count(nodes[static_cast<std::size_t>(node.parent)]) == 1) continue;
    if (q == nullptr) {
      chosen.insert(node.triangles);
      continue;
    }
    const Triangles& maximum = *std::find_if(significant.begin(), significant.end(),
                                             [&](const Triangles& leaf) { return contains(node.triangles, leaf); });
    std::size_t best = nodes.size();
    for (std::size_t m = 0; m < nodes.size(); ++m)
      if (contains(node.triangles, nodes[m].triangles) && contains(nodes[m].triangles, maximum) &&
          (nodes[m].triangles == node.triangles || total_area(surface, nodes[m].triangles) >= min_area) &&
          (best == nodes.size() || compare((*q)[m], (*q)[best]) <= 0))
        best = m;
    chosen.insert(nodes[best].triangles);
  }
  return chosen;
}

std::set<Triangles> diverse(const Surface& surface, const std::map<Triangles, Ratio>& selected, double share) {
  std::vector<Triangles> by_size;
  std::set<Triangles> left;
  for (const auto& [set, q] : selected) {
    by_size.push_back(set);
    left.insert(set);
  }
  std::stable_sort(by_size.begin(), by_size.end(),
                   [](const Triangles& a, const Triangles& b) { return a.size() < b.size(); });
  for (const Triangles& outer : by_size) {
    std::set<Triangles> met;
    while (left.contains(outer)) {
      const Triangles* next = nullptr;
      for (const Triangles& inner : left) {
        if (inner == outer || !contains(outer, inner) || met.contains(inner)) continue;
        const bool nearest = std::none_of(left.begin(), left.end(), [&](const Triangles& between) {
          return between != outer && between != inner && contains(outer, between) && contains(between, inner);
        });
        if (!nearest) continue;
        if (next == nullptr || *inner.begin() < *next->begin() ||
            (*inner.begin() == *next->begin() && inner.size() > next->size()))
          next = &inner;
      }
      if (next == nullptr) break;
      const Triangles inner = *next;
      met.insert(inner);
      const auto area = static_cast<double>(total_area(surface, outer));
      if (area - static_cast<double>(total_area(surface, inner)) >= share * area) continue;
      left.erase(compare(selected.at(inner), selected.at(outer)) < 0 ? outer : inner);
    }
  }
  return left;
}

std::set<Triangles> most_stable(const Surface& surface, const std::map<Triangles, Ratio>& selected) {
  std::set<Triangles> left, taken;
  for (const auto& [set, q] : selected) left.insert(set);
  while (!left.empty()) {
    const Triangles best = *std::min_element(left.begin(), left.end(), [&](const Triangles& a, const Triangles& b) {
      const int order = compare(selected.at(a), selected.at(b));
      if (order != 0) return order < 0;
      const std::int64_t area_a = total_area(surface, a), area_b = total_area(surface, b);
      if (area_a != area_b) return area_a > area_b;
      return *a.begin() != *b.begin() ? *a.begin() < *b.begin() : a.size() > b.size();
    });
    taken.insert(best);
    std::erase_if(left, [&](const Triangles& set) { return contains(set, best) || contains(best, set); });
  }
  return taken;
}

std::vector<int> region_numbers(const Surface& surface, const std::vector<Triangles>& regions_upper,
                                const std::vector<Triangles>& regions_lower) {
  std::vector<Triangles> regions = regions_upper;
  regions.insert(regions.end(), regions_lower.begin(), regions_lower.end());
  std::vector<std::size_t> order(regions.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  const auto is_lower = [&](std::size_t i) { return i >= regions_upper.size(); };
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const std::int64_t area_a = total_area(surface, regions[a]), area_b = total_area(surface, regions[b]);
    if (area_a != area_b) return area_a > area_b;
    if (*regions[a].begin() != *regions[b].begin()) return *regions[a].begin() < *regions[b].begin();
    if (is_lower(a) != is_lower(b)) return is_lower(b);
    return regions[a].size() > regions[b].size();
  });
  std::vector<int> number(surface.corners.size(), 0);
  for (int t = 0; t < static_cast<int>(number.size()); ++t) {
    // Of one polarity the smallest set; of two the one of smaller area, ties to upper.
    std::size_t best[2] = {order.size(), order.size()};
    for (std::size_t place = 0; place < order.size(); ++place) {
      const Triangles& region = regions[order[place]];
      if (!region.contains(t)) continue;
      std::size_t& mine = best[is_lower(order[place]) ? 1 : 0];
      if (mine == order.size() || region.size() < regions[order[mine]].size()) mine = place;
    }
    std::size_t chosen = best[0];
    if (best[0] == order.size() || (best[1] != order.size() && total_area(surface, regions[order[best[1]]]) <
                                                                   total_area(surface, regions[order[best[0]]])))
      chosen = best[1];
    if (chosen != order.size()) number[static_cast<std::size_t>(t)] = static_cast<int>(chosen) + 1;
  }
  return number;
}

std::vector<int> split_numbers(const Surface& surface, const std::vector<int>& numbers) {
  const auto neighbours = neighbours_of(surface);
  std::vector<Triangles> parts;
  for (const int number : std::set<int>(numbers.begin(), numbers.end())) {
    if (number == 0) continue;
    Triangles members;
    for (int t = 0; t < static_cast<int>(numbers.size()); ++t)
      if (numbers[static_cast<std::size_t>(t)] == number) members.insert(t);
    for (const Triangles& part : connected_parts(neighbours, members)) parts.push_back(part);
  }
  std::sort(parts.begin(), parts.end(), [&](const Triangles& a, const Triangles& b) {
    return std::pair(-total_area(surface, a), *a.begin()) < std::pair(-total_area(surface, b), *b.begin());
  });
  std::vector<int> label(numbers.size(), 0);
  for (std::size_t i = 0; i < parts.size(); ++i)
    for (const int t : parts[i]) label[static_cast<std::size_t>(t)] = static_cast<int>(i) + 1;
  return label;
}

Loops border_loops(const Surface& surface, const Triangles& region) {
  std::map<int, bool> is_hole;
  for (const int t : region)
    for (int k = 0; k < 3; ++k) {
      const int behind = opposite(surface, 3 * t + k);
      if (behind < 0)
        is_hole[3 * t + k] = true;
      else if (!region.contains(behind / 3))
        is_hole[3 * t + k] = false;
    }
  // Turn about the end point, through triangles of the region only, until the next edge of the border.
  std::map<int, int> follows;
  for (const auto& [half_edge, hole] : is_hole) {
    int candidate = half_edge - half_edge % 3 + (half_edge + 1) % 3;
    while (!is_hole.contains(candidate)) {
      const int across = opposite(surface, candidate);
      candidate = across - across % 3 + (across + 1) % 3;
    }
    follows[half_edge] = candidate;
  }
  Loops result;
  std::set<int> left;
  for (const auto& [half_edge, hole] : is_hole) left.insert(half_edge);
  while (!left.empty()) {
    std::vector<int> loop;
    for (int half_edge = *left.begin(); left.erase(half_edge) == 1; half_edge = follows.at(half_edge))
      loop.push_back(half_edge);
    int start = -1;
    for (const int half_edge : loop)
      if (!is_hole.at(half_edge) && (start < 0 || half_edge < start)) start = half_edge;
    if (start < 0) {
      ++result.dropped;
      continue;
    }
    std::rotate(loop.begin(), std::find(loop.begin(), loop.end(), start), loop.end());
    result.loops.push_back(loop);
  }
  std::sort(result.loops.begin(), result.loops.end());
  return result;
}

}  // namespace meshmser::oracle
