#include "stages/mser/meaningful.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "stages/common/parallel.hpp"

namespace meshmser {

std::vector<double> triangle_gradients(const SurfaceView& surface, std::span<const double> values,
                                       const Execution& execution) {
  std::vector<double> gradients(surface.triangles.size());
  parallel_chunks(
      static_cast<std::int64_t>(gradients.size()), 1 << 15, "", execution, [&](std::int64_t begin, std::int64_t end) {
        for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t) {
          const auto& corners = surface.triangles[t];
          const auto at = [&](std::size_t k) { return static_cast<std::size_t>(corners[k]); };
          const Eigen::Vector3d ab = surface.positions[at(1)] - surface.positions[at(0)];
          const Eigen::Vector3d ac = surface.positions[at(2)] - surface.positions[at(0)];
          const double to_b = values[at(1)] - values[at(0)], to_c = values[at(2)] - values[at(0)];
          const double double_area = ab.cross(ac).norm();
          gradients[t] =
              double_area > 0 ? (to_b * ac - to_c * ab).norm() / double_area : std::numeric_limits<double>::infinity();
        }
      });
  return gradients;
}

GradientShare::GradientShare(std::span<const double> gradients, std::span<const double> areas) {
  std::vector<std::int32_t> order;
  for (std::size_t t = 0; t < gradients.size(); ++t)
    if (std::isfinite(gradients[t])) order.push_back(static_cast<std::int32_t>(t));
  std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
    const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
    return gradients[i] != gradients[j] ? gradients[i] < gradients[j] : a < b;
  });
  gradients_.resize(order.size());
  share_.resize(order.size());
  double length = 0;
  for (std::size_t i = order.size(); i-- > 0;) {
    gradients_[i] = gradients[static_cast<std::size_t>(order[i])];
    share_[i] = length += areas[static_cast<std::size_t>(order[i])] * gradients_[i];
  }
  if (length > 0)
    for (double& share : share_) share /= length;
}

double GradientShare::at_least(double gradient) const {
  const auto found = std::lower_bound(gradients_.begin(), gradients_.end(), gradient);
  return found == gradients_.end() ? 0 : share_[static_cast<std::size_t>(found - gradients_.begin())];
}

std::vector<double> log_false_alarms(std::size_t num_nodes, std::span<const LevelLine> lines,
                                     const GradientShare& share, const ChanceParameters& parameters) {
  const double log_lines = std::log10(static_cast<double>(parameters.num_lines));
  std::vector<double> log_alarms(num_nodes, std::numeric_limits<double>::infinity());
  for (const LevelLine& line : lines) {
    // With nothing but triangles without area beyond it.
    if (!std::isfinite(line.least_gradient)) continue;
    double& of_node = log_alarms[static_cast<std::size_t>(line.node)];
    of_node = std::min(
        of_node, log_lines + line.length / parameters.independent * std::log10(share.at_least(line.least_gradient)));
  }
  return log_alarms;
}

std::vector<std::int32_t> select_meaningful(const ComponentTree& tree, std::span<const double> log_alarms_of_node,
                                            double log_most, std::span<const std::uint8_t> open_root_of_node,
                                            NodeFates* fates) {
  const std::size_t num_nodes = tree.num_nodes();
  std::vector<std::int32_t> num_children(num_nodes, 0);
  for (const std::int32_t parent : tree.parent_of_node)
    if (parent >= 0) ++num_children[static_cast<std::size_t>(parent)];
  const auto has_no_line = [&](std::size_t n) {
    return tree.parent_of_node[n] < 0 && (open_root_of_node.empty() || open_root_of_node[n] == 0);
  };
  // Each section is stood for by its largest node, which knows the best of the section so far.
  std::vector<std::int32_t> section(num_nodes), best(num_nodes, -1);
  for (std::size_t n = num_nodes; n-- > 0;) {
    const std::int32_t parent = tree.parent_of_node[n];
    const bool joined = parent >= 0 && num_children[static_cast<std::size_t>(parent)] == 1 &&
                        tree.side(static_cast<std::int32_t>(n)) == tree.side(parent);
    section[n] = joined ? section[static_cast<std::size_t>(parent)] : static_cast<std::int32_t>(n);
    if (has_no_line(n)) continue;
    std::int32_t& of_section = best[static_cast<std::size_t>(section[n])];
    if (of_section < 0 || log_alarms_of_node[n] < log_alarms_of_node[static_cast<std::size_t>(of_section)])
      of_section = static_cast<std::int32_t>(n);
  }
  std::vector<std::int32_t> selected;
  for (std::size_t n = 0; n < num_nodes; ++n) {
    const std::int32_t winner = best[static_cast<std::size_t>(section[n])];
    if (has_no_line(n))
      tell_fate(fates, n, {NodeFate::Kind::kRoot});
    else if (log_alarms_of_node[n] > log_most)
      tell_fate(fates, n, {NodeFate::Kind::kFalseAlarm});
    else if (winner == static_cast<std::int32_t>(n))
      selected.push_back(winner);
    else
      tell_fate(fates, n, {NodeFate::Kind::kLessMeaningful, -1, winner});
  }
  return selected;
}

}  // namespace meshmser
