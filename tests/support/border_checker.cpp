#include "tests/support/border_checker.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <queue>
#include <set>
#include <tuple>
#include <utility>

namespace meshmser::testing {
namespace {

using Edge = std::pair<std::int32_t, std::int32_t>;

class Checker {
 public:
  Checker(std::span<const Eigen::Vector3d> positions, std::span<const std::array<std::int32_t, 3>> triangles,
          std::span<const std::uint8_t> excluded, std::span<const std::uint8_t> inside, const BorderLoops& loops,
          std::int32_t owner)
      : positions_(positions), triangles_(triangles), inside_(inside), loops_(loops), owner_(owner) {
    for (std::int32_t t = 0; t < static_cast<std::int32_t>(triangles.size()); ++t)
      if (excluded.empty() || excluded[static_cast<std::size_t>(t)] == 0)
        for (int k = 0; k < 3; ++k) triangle_of_edge_[edge(3 * t + k)] = t;
  }

  std::string run(std::int64_t* rims_missing) {
    find_expected();
    std::string problem;
    double last_length = 0;
    std::int32_t last_first = -1;
    bool any = false;
    for (std::size_t l = 0; l < loops_.num_loops(); ++l) {
      if (l > 0 && loops_.owner_of_loop[l] < loops_.owner_of_loop[l - 1]) return "owners are not ascending";
      if (loops_.owner_of_loop[l] != owner_) continue;
      const std::span<const std::int32_t> loop(
          loops_.half_edges.data() + loops_.first_edge_of_loop[l],
          static_cast<std::size_t>(loops_.first_edge_of_loop[l + 1] - loops_.first_edge_of_loop[l]));
      problem = check_loop(l, loop);
      if (!problem.empty()) return "loop " + std::to_string(l) + ": " + problem;
      const double length = loops_.level_length_of_loop[l] + loops_.hole_length_of_loop[l];
      if (any && (length > last_length || (length == last_length && loop[0] < last_first)))
        return "loop " + std::to_string(l) + " should stand before the one before it";
      last_length = length;
      last_first = loop[0];
      any = true;
    }
    problem = check_missing(rims_missing);
    if (problem.empty() && any) problem = check_enclosed();
    return problem;
  }

 private:
  Edge edge(std::int32_t h) const {
    const auto& c = triangles_[static_cast<std::size_t>(h / 3)];
    return {c[static_cast<std::size_t>(h % 3)], c[static_cast<std::size_t>((h + 1) % 3)]};
  }
  bool in(std::int32_t triangle) const { return inside_[static_cast<std::size_t>(triangle)] != 0; }

  /// What the definition asks for: half-edges of the region whose twin is outside or absent.
  void find_expected() {
    for (const auto& [e, t] : triangle_of_edge_) {
      if (!in(t)) continue;
      const auto behind = triangle_of_edge_.find({e.second, e.first});
      if (behind == triangle_of_edge_.end())
        expected_[e] = EdgeKind::kHole;
      else if (!in(behind->second))
        expected_[e] = EdgeKind::kLevel;
    }
  }

  std::string check_loop(std::size_t l, std::span<const std::int32_t> loop) {
    if (loop.empty()) return "is empty";
    double level_length = 0, hole_length = 0;
    std::int32_t smallest_level = -1;
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const std::int32_t h = loop[i];
      if (h < 0 || h >= static_cast<std::int32_t>(3 * triangles_.size())) return "names half-edge " + std::to_string(h);
      const Edge e = edge(h);
      const std::string name = "half-edge " + std::to_string(h);
      const auto expected = expected_.find(e);
      if (expected == expected_.end() || triangle_of_edge_.at(e) != h / 3) return name + " is no border of the region";
      const EdgeKind kind = loops_.kinds[static_cast<std::size_t>(loops_.first_edge_of_loop[l]) + i];
      if (kind != expected->second) return name + " is of the other kind";
      if (!seen_.insert(h).second) return name + " stands twice";
      const std::int32_t after = loop[(i + 1) % loop.size()];
      if (edge(after).first != e.second) return "is not closed after " + name;
      if (!same_wedge(e.second, h / 3, after / 3)) return "leaves the region's wedge after " + name;
      const double length =
          (positions_[static_cast<std::size_t>(e.second)] - positions_[static_cast<std::size_t>(e.first)]).norm();
      (kind == EdgeKind::kHole ? hole_length : level_length) += length;
      if (kind == EdgeKind::kLevel && (smallest_level < 0 || h < smallest_level)) smallest_level = h;
    }
    if (smallest_level != loop[0]) return "does not begin at its smallest level half-edge";
    if (std::abs(level_length - loops_.level_length_of_loop[l]) > 1e-9 * (1 + level_length))
      return "level length is wrong";
    if (std::abs(hole_length - loops_.hole_length_of_loop[l]) > 1e-9 * (1 + hole_length)) return "hole length is wrong";
    return "";
  }

  /// Whether two triangles of the region around a vertex hang together through edges at that vertex, inside the region.
  bool same_wedge(std::int32_t vertex, std::int32_t from, std::int32_t to) const {
    std::set<std::int32_t> reached{from};
    std::queue<std::int32_t> queue({from});
    while (!queue.empty()) {
      const std::int32_t t = queue.front();
      queue.pop();
      for (int k = 0; k < 3; ++k) {
        const Edge e = edge(3 * t + k);
        if (e.first != vertex && e.second != vertex) continue;
        const auto other = triangle_of_edge_.find({e.second, e.first});
        if (other != triangle_of_edge_.end() && in(other->second) && reached.insert(other->second).second)
          queue.push(other->second);
      }
    }
    return reached.count(to) > 0;
  }

  std::string check_missing(std::int64_t* rims_missing) {
    std::map<std::int32_t, std::vector<std::int32_t>> missing_from;  // vertex -> triangles of missing hole half-edges
    std::int64_t in_degree = 0;
    std::set<Edge> missing;
    for (const auto& [e, kind] : expected_) {
      const std::int32_t t = triangle_of_edge_.at(e);
      const auto& c = triangles_[static_cast<std::size_t>(t)];
      const int k = c[0] == e.first ? 0 : c[1] == e.first ? 1 : 2;
      if (seen_.count(3 * t + k)) continue;
      if (kind == EdgeKind::kLevel) return "level half-edge " + std::to_string(3 * t + k) + " is in no loop";
      missing.insert(e);
      missing_from[e.first].push_back(t);
      ++in_degree;
    }
    // Whole rims: each missing half-edge is followed, within the region's wedge, by another missing one.
    std::int64_t rims = 0;
    while (!missing.empty()) {
      ++rims;
      const Edge first = *missing.begin();
      Edge e = first;
      do {
        if (missing.erase(e) == 0) return "a rim runs into itself";
        const std::int32_t t = triangle_of_edge_.at(e);
        Edge after{-1, -1};
        for (const std::int32_t candidate : missing_from[e.second]) {
          if (!same_wedge(e.second, t, candidate)) continue;
          for (int k = 0; k < 3; ++k) {
            const Edge out = edge(3 * candidate + k);
            if (out.first == e.second && expected_.count(out)) after = out;
          }
        }
        if (after.first < 0) return "part of a rim is missing after vertex " + std::to_string(e.second);
        e = after;
      } while (e != first);
    }
    if (rims_missing != nullptr) *rims_missing += rims;
    return "";
  }

  std::string check_enclosed() const {
    std::set<std::int32_t> reached;
    std::queue<std::int32_t> queue;
    for (const std::int32_t h : seen_)
      if (reached.insert(h / 3).second) queue.push(h / 3);
    while (!queue.empty()) {
      const std::int32_t t = queue.front();
      queue.pop();
      for (int k = 0; k < 3; ++k) {
        if (seen_.count(3 * t + k)) continue;
        const Edge e = edge(3 * t + k);
        const auto other = triangle_of_edge_.find({e.second, e.first});
        if (other != triangle_of_edge_.end() && reached.insert(other->second).second) queue.push(other->second);
      }
    }
    for (std::int32_t t = 0; t < static_cast<std::int32_t>(triangles_.size()); ++t)
      if ((reached.count(t) > 0) != in(t))
        return "triangle " + std::to_string(t) + (in(t) ? " is not enclosed" : " is enclosed but outside");
    return "";
  }

  std::span<const Eigen::Vector3d> positions_;
  std::span<const std::array<std::int32_t, 3>> triangles_;
  std::span<const std::uint8_t> inside_;
  const BorderLoops& loops_;
  std::int32_t owner_;
  std::map<Edge, std::int32_t> triangle_of_edge_;
  std::map<Edge, EdgeKind> expected_;
  std::set<std::int32_t> seen_;
};

}  // namespace

std::string check_border_loops(std::span<const Eigen::Vector3d> positions,
                               std::span<const std::array<std::int32_t, 3>> triangles,
                               std::span<const std::uint8_t> excluded, std::span<const std::uint8_t> inside,
                               const BorderLoops& loops, std::int32_t owner, std::int64_t* rims_missing) {
  return Checker(positions, triangles, excluded, inside, loops, owner).run(rims_missing);
}

}  // namespace meshmser::testing
