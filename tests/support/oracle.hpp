#pragma once
/// Component trees, stability, selections, labels and border loops straight from their definitions, with sets of
/// triangle ids and nothing clever: slow, and independent of the program.

#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

namespace meshmser::oracle {

using Triangles = std::set<int>;

/// A mesh with a level on each triangle (0: in no node) and a whole-number area on each. Triangles that are cut out do
/// not exist but for their place in the numbering.
struct Surface {
  std::vector<std::array<int, 3>> corners;
  std::vector<bool> cut_out;
  std::vector<int> level;
  std::vector<std::int64_t> area;
  int num_levels = 0;
};

/// The greatest k with min over the corners of the value >= levels[k - 1]; 0 where there is none.
int level_of(const std::array<int, 3>& corners, const std::vector<double>& values, const std::vector<double>& levels);

/// Do two different triangles have two corners in common along an edge of both?
bool share_an_edge(const Surface& surface, int a, int b);

/// Pairs of triangles that share an edge, for each triangle.
std::vector<std::vector<int>> neighbours_of(const Surface& surface);

/// The classes of `members` under the relation "joined by a chain of shared edges within `members`".
std::vector<Triangles> connected_parts(const std::vector<std::vector<int>>& neighbours, const Triangles& members);

struct Node {
  Triangles triangles;
  int lo = 0, hi = 0;
  int parent = -1;  ///< index of the smallest node that properly contains this one
};

/// All distinct components of all level sets, by ascending number of triangles, then smallest triangle.
std::vector<Node> all_nodes(const Surface& surface);

/// q as numerator and denominator; a denominator of 0 stands for infinity.
using Ratio = std::pair<std::int64_t, std::int64_t>;
int compare(const Ratio& a, const Ratio& b);
std::vector<Ratio> stability(const Surface& surface, const std::vector<Node>& nodes, int delta);

/// The selected nodes, as sets of triangles. `open_roots`: a root that shares an edge with a triangle of level 0 may be
/// selected too.
std::set<Triangles> selection(const Surface& surface, const std::vector<Node>& nodes, const std::vector<Ratio>& q,
                              bool main_child_only);

/// How long the maximum of each leaf lasts, with `heights[k - 1]` the height of level k, and the largest node in which
/// it is the highest; keyed by the leaf's triangles.
struct Lifetime {
  double persistence = 0;
  Triangles top;
};
std::map<Triangles, Lifetime> lifetimes(const std::vector<Node>& nodes, const std::vector<double>& heights);

/// The largest nodes that hold exactly one maximum which lasts longer than `min_persistence` and is the highest of a
/// node of at least `min_area`; no roots. With `q`, instead of each the node of least q from it to its maximum, of those of
/// at least `min_area` and itself.
std::set<Triangles> persistent(const Surface& surface, const std::vector<Node>& nodes,
                               const std::vector<double>& heights, double min_persistence, std::int64_t min_area,
                               const std::vector<Ratio>* q);

/// What remains of selected sets (with their q) when of two nested ones of like area, A(outer) - A(inner) <
/// share A(outer), only that of less q may stay, ties the outer: each set, small ones first, meets those that are left
/// nearest within it, by smallest triangle, then the larger first.
std::set<Triangles> diverse(const Surface& surface, const std::map<Triangles, Ratio>& selected, double share);

/// Least q first, ties to the larger area, the smaller triangle, the more triangles; what it holds and what holds it
/// goes.
std::set<Triangles> most_stable(const Surface& surface, const std::map<Triangles, Ratio>& selected);

/// The number of each triangle: regions (selected sets) numbered from 1 by decreasing area, smallest triangle, then as
/// given (upper before lower); a triangle bears the number of the smallest that holds it. Sets of equal area: the
/// first.
std::vector<int> region_numbers(const Surface& surface, const std::vector<Triangles>& regions_upper,
                                const std::vector<Triangles>& regions_lower);

/// Connected parts of equal nonzero number, numbered from 1 by decreasing area, then smallest triangle.
std::vector<int> split_numbers(const Surface& surface, const std::vector<int>& numbers);

/// The border loops of a set of triangles that have a level edge, as half-edges 3 t + k, each started at its smallest
/// level half-edge; sorted by first half-edge. `dropped`: how many loops of hole edges alone there were.
struct Loops {
  std::vector<std::vector<int>> loops;
  int dropped = 0;
};
Loops border_loops(const Surface& surface, const Triangles& region);

}  // namespace meshmser::oracle
