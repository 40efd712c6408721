#include "stages/curvature/line_scale.hpp"

#include <algorithm>
#include <cmath>

#include "stages/common/cell_grid.hpp"
#include "stages/curvature/scale_space.hpp"

namespace meshmser {
namespace {

constexpr int kSteps = 4;
constexpr double kFirst = 3, kLast = 48;  // spacings
// Cells of a quarter radius keep about 50 averaged points in a neighbourhood, as many as 4 spacings hold.
constexpr double kCellsPerRadius = 4;
// Averaging over fewer than two points a cell saves nothing.
constexpr double kWorthwhile = 1.4;

struct Averaged {
  std::vector<Eigen::Vector3d> points, normals;
};

// Mean point and normal of each occupied cell, in the order of the cells' least point ids.
Averaged average_over_cells(std::span<const Eigen::Vector3d> points, std::span<const Eigen::Vector3d> normals,
                            double cell, const Execution& execution) {
  Averaged at_least_id{std::vector<Eigen::Vector3d>(points.size()), std::vector<Eigen::Vector3d>(points.size())};
  std::vector<std::uint8_t> used(points.size(), 0);
  for_each_cell(CellGrid(points, cell), 0, "thinning", execution, [&](const CellBlock& block) {
    Eigen::Vector3d point = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::Zero();
    for (std::int64_t i = block.own_begin; i < block.own_end; ++i) {
      const auto id = static_cast<std::size_t>(block.ids[static_cast<std::size_t>(i)]);
      point += points[id];
      normal += normals[id];
    }
    const auto least = static_cast<std::size_t>(block.ids[static_cast<std::size_t>(block.own_begin)]);
    const double length = normal.norm();
    used[least] = 1;
    at_least_id.points[least] = point / static_cast<double>(block.own_end - block.own_begin);
    at_least_id.normals[least] = length > 0 ? Eigen::Vector3d(normal / length) : Eigen::Vector3d::Zero();
  });
  Averaged result;
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) continue;
    result.points.push_back(at_least_id.points[i]);
    result.normals.push_back(at_least_id.normals[i]);
  }
  return result;
}

double response_at(const Averaged& cloud, double radius, double spacing, const Execution& execution) {
  const ScaleSpaceParameters parameters{radius, kSteps};
  ScaleSpace space = scale_space(cloud.points, cloud.normals, parameters, execution);
  std::vector<double>& h = space.mean_curvature;
  std::erase_if(h, [](double value) { return std::isnan(value); });
  if (h.empty()) return 0;
  const auto quantile = [&](double share) {
    const auto at = h.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(h.size() - 1));
    std::nth_element(h.begin(), at, h.end());
    return *at;
  };
  // Lines cover a good part of a surface made of them; a broken edge, much more curved but narrow, is to lie beyond the
  // quantiles. Of a Gaussian, those of 15 % and 85 % are 2.07 standard deviations apart.
  const double width = quantile(0.85) - quantile(0.15);
  const double noise = 2.07 * mean_curvature_noise(space.noise, spacing, parameters);
  return radius * std::sqrt(std::max(0.0, width * width - noise * noise));
}

}  // namespace

LineScale measure_line_scale(std::span<const Eigen::Vector3d> points, std::span<const Eigen::Vector3d> normals,
                             double spacing, const Execution& execution) {
  if (!(spacing > 0))
    throw StageError("line_width: auto needs a cloud of more than 16 points; give the width outright");
  LineScale result;
  const double factor = std::exp2(1.0 / 3);
  Averaged cloud{{points.begin(), points.end()}, {normals.begin(), normals.end()}};
  double present = spacing;
  auto& r = result.response;
  for (double radius = kFirst * spacing; radius < kLast * spacing; radius *= factor) {
    const double cell = radius / kCellsPerRadius;
    if (cell > kWorthwhile * present) {
      // Always from the full cloud: averages of averages would weigh points unevenly.
      cloud = average_over_cells(points, normals, cell, execution);
      present = cell;
    }
    r.emplace_back(radius, response_at(cloud, radius, present, execution));
    if (r.size() >= 2 && r.back().second < r[r.size() - 2].second) break;
  }
  const auto top =
      std::max_element(r.begin(), r.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  result.radius = top->first;
  if (top != r.begin() && top + 1 != r.end()) {
    const double before = (top - 1)->second, here = top->second, after = (top + 1)->second;
    const double bend = before - 2 * here + after;
    if (bend < 0) result.radius *= std::pow(factor, (before - after) / (2 * bend));
  }
  return result;
}

}  // namespace meshmser
