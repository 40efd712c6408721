#include "stages/mser/stability.hpp"

#include <algorithm>
#include <limits>

#include "pipeline/execution/error.hpp"
#include "stages/common/maxima.hpp"

namespace meshmser {
namespace {

__extension__ using Wide = __int128;

/// Index of the first element of the ascending `values` that is >= `bound`, or the size. Searches from the end in steps
/// that double: what is sought lies about delta elements from the end.
std::size_t first_at_least(const std::vector<std::int32_t>& values, std::int32_t bound) {
  std::size_t high = values.size();
  std::size_t step = 1;
  while (high > 0 && values[high - std::min(step, high)] >= bound) {
    high -= std::min(step, high);
    step *= 2;
  }
  const std::size_t low = high - std::min(step, high);
  return static_cast<std::size_t>(std::lower_bound(values.begin() + static_cast<std::ptrdiff_t>(low),
                                                   values.begin() + static_cast<std::ptrdiff_t>(high), bound) -
                                  values.begin());
}

/// With `lower(m)` and `upper(m)` the levels below and above a middle level m between which change is measured; both
/// rise with m.
template <class Lower, class Upper>
std::vector<std::int64_t> changes_between(const ComponentTree& tree, Lower lower, Upper upper) {
  const auto num_nodes = static_cast<std::int32_t>(tree.num_nodes());
  std::vector<std::int64_t> up(tree.num_nodes());
  // Down, as differences along the way to the root; they may wrap in between, so they are unsigned.
  std::vector<std::uint64_t> down(tree.num_nodes(), 0);
  // The nodes from the root to the present one, with the levels hi and upper(m) of each: both ascend.
  std::vector<std::int32_t> path, path_hi, path_target;
  for (std::int32_t node = num_nodes - 1; node >= 0; --node) {
    const auto n = static_cast<std::size_t>(node);
    const std::int32_t parent = tree.parent_of_node[n];
    while (!path.empty() && path.back() != parent) path.pop_back();
    path_hi.resize(path.size());
    path_target.resize(path.size());
    const std::int32_t hi = tree.hi_of_node[n];
    const std::int32_t below = path.empty() ? 0 : path_hi.back();
    const auto middle = static_cast<std::int32_t>((std::int64_t{below} + 1 + hi) / 2);
    const std::int32_t target = upper(middle);
    path.push_back(node);
    path_hi.push_back(hi);
    path_target.push_back(target);
    up[n] = tree.area_of_node[static_cast<std::size_t>(path[first_at_least(path_hi, lower(middle))])];
    // This node is what is left of every ancestor (or itself) that asks for a level in below + 1 .. hi.
    const std::size_t begin = first_at_least(path_target, below + 1);
    const std::size_t end = first_at_least(path_target, hi + 1);
    if (begin < end) {
      const auto area = static_cast<std::uint64_t>(tree.area_of_node[n]);
      down[static_cast<std::size_t>(path[end - 1])] += area;
      if (begin > 0) down[static_cast<std::size_t>(path[begin - 1])] -= area;
    }
  }
  for (std::size_t n = 0; n < tree.num_nodes(); ++n) {
    const std::int32_t parent = tree.parent_of_node[n];
    if (parent >= 0) down[static_cast<std::size_t>(parent)] += down[n];
    up[n] -= static_cast<std::int64_t>(down[n]);
  }
  return up;
}

}  // namespace

std::vector<std::int64_t> change_of_nodes(const ComponentTree& tree, std::int32_t delta) {
  if (delta < 1)
    throw StageError("delta is " + std::to_string(delta) + " level steps; expected a whole number of at least 1");
  constexpr std::int32_t kMost = std::numeric_limits<std::int32_t>::max();
  return changes_between(
      tree, [&](std::int32_t middle) { return std::max(1, middle - delta); },
      [&](std::int32_t middle) { return delta > kMost - middle ? kMost : middle + delta; });
}

std::vector<std::int64_t> change_of_nodes_by_value(const ComponentTree& tree, double delta) {
  if (!(delta > 0)) throw StageError("delta is " + std::to_string(delta) + "; expected more than 0");
  if (tree.polarity == Polarity::kShapes)
    throw StageError("a tree of shapes counts level lines: its delta is a whole number of them, not a value of S");
  const std::vector<double> levels = finite_levels(tree.levels);
  std::vector<std::int32_t> lower, upper;
  for (const double level : levels) {
    lower.push_back(std::max(
        1, static_cast<std::int32_t>(std::upper_bound(levels.begin(), levels.end(), level - delta) - levels.begin())));
    upper.push_back(
        1 + static_cast<std::int32_t>(std::lower_bound(levels.begin(), levels.end(), level + delta) - levels.begin()));
  }
  return changes_between(
      tree, [&](std::int32_t middle) { return lower[static_cast<std::size_t>(middle) - 1]; },
      [&](std::int32_t middle) { return upper[static_cast<std::size_t>(middle) - 1]; });
}

std::strong_ordering compare_stability(std::int64_t change_a, std::int64_t area_a, std::int64_t change_b,
                                       std::int64_t area_b) {
  if (area_a == 0 || area_b == 0) return (area_a == 0) <=> (area_b == 0);
  return Wide{change_a} * area_b <=> Wide{change_b} * area_a;
}

double stability_of_node(const ComponentTree& tree, std::span<const std::int64_t> changes, std::int32_t node) {
  const auto n = static_cast<std::size_t>(node);
  if (tree.area_of_node[n] == 0) return std::numeric_limits<double>::infinity();
  return static_cast<double>(changes[n]) / static_cast<double>(tree.area_of_node[n]);
}

std::strong_ordering compare_area(std::int64_t a, std::int32_t exponent_a, std::int64_t b, std::int32_t exponent_b) {
  if (a == 0 || b == 0 || exponent_a == exponent_b) return a <=> b;
  // Brought to the finer unit; 64 doublings or more outgrow any 63-bit number.
  const std::int64_t finer = std::int64_t{exponent_a} - exponent_b;
  if (finer >= 64) return std::strong_ordering::less;
  if (finer <= -64) return std::strong_ordering::greater;
  return finer > 0 ? Wide{a} <=> (Wide{b} << finer) : (Wide{a} << -finer) <=> Wide{b};
}

}  // namespace meshmser
