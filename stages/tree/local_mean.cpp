#include "stages/tree/local_mean.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "stages/common/parallel.hpp"
#include "stages/common/simd.hpp"

namespace meshmser {
namespace {

/// Cubes across the radius: the ramp at the ball's surface is an eighth of it.
constexpr double kCubesAcrossRadius = 8;
/// Rows of cubes are looked up in a table; more than this and the cubes are enlarged.
constexpr double kMaxRows = 1 << 24;

/// What a cube holds, at its centre of mass.
struct Cube {
  Eigen::Vector3d centre;
  double weight;
  double sum;  ///< of weight x value
  std::int32_t row, column;
};

struct Grid {
  std::vector<Cube> cubes;                  ///< by row, then column
  std::vector<std::int32_t> first_of_row;   ///< #rows + 1
  std::vector<std::int32_t> vertices;       ///< by cube
  std::vector<std::int32_t> first_of_cube;  ///< #cubes + 1, into vertices
  std::int32_t rows_y = 0, rows_z = 0;
  double size = 0;
};

Grid make_grid(std::span<const Eigen::Vector3d> positions, std::span<const double> values,
               std::span<const double> weights, double radius) {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  double area = 0;
  std::size_t count = 0;
  for (std::size_t v = 0; v < positions.size(); ++v) {
    if (!positions[v].allFinite()) continue;
    low = low.cwiseMin(positions[v]);
    high = high.cwiseMax(positions[v]);
    area += weights[v];
    ++count;
  }
  Grid grid;
  if (count == 0) return grid;
  const Eigen::Vector3d extent = high - low;
  // Rows run along the longest side, so that there are fewest of them.
  int along = 0;
  extent.maxCoeff(&along);
  const int across = (along + 1) % 3, upward = (along + 2) % 3;
  grid.size = std::max({radius / kCubesAcrossRadius, std::sqrt(area / static_cast<double>(count)),
                        std::sqrt((extent[across] + radius) * (extent[upward] + radius) / kMaxRows),
                        extent[along] / static_cast<double>(1 << 30)});
  grid.rows_y = static_cast<std::int32_t>(extent[across] / grid.size) + 1;
  grid.rows_z = static_cast<std::int32_t>(extent[upward] / grid.size) + 1;

  struct Place {
    std::int32_t row, column, vertex;
  };
  std::vector<Place> places;
  places.reserve(count);
  for (std::size_t v = 0; v < positions.size(); ++v) {
    if (!positions[v].allFinite()) continue;
    const Eigen::Vector3d cell = (positions[v] - low) / grid.size;
    places.push_back({static_cast<std::int32_t>(cell[upward]) * grid.rows_y + static_cast<std::int32_t>(cell[across]),
                      static_cast<std::int32_t>(cell[along]), static_cast<std::int32_t>(v)});
  }
  std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
    return a.row != b.row ? a.row < b.row : a.column != b.column ? a.column < b.column : a.vertex < b.vertex;
  });
  grid.first_of_row.assign(static_cast<std::size_t>(grid.rows_y) * static_cast<std::size_t>(grid.rows_z) + 1, 0);
  for (std::size_t i = 0; i < places.size();) {
    Cube cube{Eigen::Vector3d::Zero(), 0, 0, places[i].row, places[i].column};
    grid.first_of_cube.push_back(static_cast<std::int32_t>(grid.vertices.size()));
    for (; i < places.size() && places[i].row == cube.row && places[i].column == cube.column; ++i) {
      const auto v = static_cast<std::size_t>(places[i].vertex);
      grid.vertices.push_back(places[i].vertex);
      if (!std::isfinite(values[v])) continue;
      cube.centre += weights[v] * positions[v];
      cube.weight += weights[v];
      cube.sum += weights[v] * values[v];
    }
    if (cube.weight > 0) cube.centre /= cube.weight;
    grid.cubes.push_back(cube);
    ++grid.first_of_row[static_cast<std::size_t>(cube.row) + 1];
  }
  grid.first_of_cube.push_back(static_cast<std::int32_t>(grid.vertices.size()));
  std::partial_sum(grid.first_of_row.begin(), grid.first_of_row.end(), grid.first_of_row.begin());
  return grid;
}

/// Cubes as columns of numbers, in fours; the last four are filled up with cubes without weight.
struct Columns {
  std::vector<double> x, y, z, weight, sum;

  void clear() {
    for (std::vector<double>* column : {&x, &y, &z, &weight, &sum}) column->clear();
  }
  void add(const Eigen::Vector3d& centre, double w, double s) {
    x.push_back(centre[0]);
    y.push_back(centre[1]);
    z.push_back(centre[2]);
    weight.push_back(w);
    sum.push_back(s);
  }
  void fill_up() {
    while (x.size() % kLanes != 0) add(Eigen::Vector3d::Zero(), 0, 0);
  }
};

struct Total {
  double weight, sum;
};

/// Weight and weighted sum of the ball about a point. A cube's share falls from 1 to 0 with the square of its distance,
/// which near the ball's surface is as good as linear and needs no root.
MESHMSER_SIMD Total ball_total(const Columns& cubes, const Eigen::Vector3d& centre, double radius, double size) {
  const double slope = 1 / (2 * radius * size), at_zero = radius * radius * slope + 0.5;
  const Lanes zero = {}, one = zero + 1;
  Lanes weight = zero, sum = zero;
  for (std::size_t i = 0; i < cubes.x.size(); i += kLanes) {
    Lanes x, y, z, cube_weight, cube_sum;
    __builtin_memcpy(&x, cubes.x.data() + i, sizeof x);
    __builtin_memcpy(&y, cubes.y.data() + i, sizeof y);
    __builtin_memcpy(&z, cubes.z.data() + i, sizeof z);
    __builtin_memcpy(&cube_weight, cubes.weight.data() + i, sizeof cube_weight);
    __builtin_memcpy(&cube_sum, cubes.sum.data() + i, sizeof cube_sum);
    x -= centre[0];
    y -= centre[1];
    z -= centre[2];
    Lanes share = at_zero - slope * (x * x + y * y + z * z);
    share = share > zero ? share : zero;
    share = share < one ? share : one;
    weight += share * cube_weight;
    sum += share * cube_sum;
  }
  return {(weight[0] + weight[1]) + (weight[2] + weight[3]), (sum[0] + sum[1]) + (sum[2] + sum[3])};
}

/// Cubes with weight that may touch a ball of `radius` around a point of `cube`.
void gather(const Grid& grid, const Cube& cube, double radius, Columns& near) {
  near.clear();
  const auto reach = static_cast<std::int32_t>(radius / grid.size + 1.5);
  const std::int32_t y = cube.row % grid.rows_y, z = cube.row / grid.rows_y;
  for (std::int32_t row_z = std::max(0, z - reach); row_z <= std::min(grid.rows_z - 1, z + reach); ++row_z)
    for (std::int32_t row_y = std::max(0, y - reach); row_y <= std::min(grid.rows_y - 1, y + reach); ++row_y) {
      const auto row =
          static_cast<std::size_t>(row_z) * static_cast<std::size_t>(grid.rows_y) + static_cast<std::size_t>(row_y);
      const auto begin = grid.cubes.begin() + grid.first_of_row[row],
                 end = grid.cubes.begin() + grid.first_of_row[row + 1];
      if (begin == end) continue;
      auto i = std::lower_bound(begin, end, cube.column - reach,
                                [](const Cube& c, std::int32_t column) { return c.column < column; });
      for (; i != end && i->column <= cube.column + reach; ++i)
        if (i->weight > 0) near.add(i->centre, i->weight, i->sum);
    }
  near.fill_up();
}

/// Of the finite values of vertices with weight; 0 where there is none.
double median_of(std::span<const double> values, std::span<const double> weights) {
  std::vector<double> counted;
  for (std::size_t v = 0; v < values.size(); ++v)
    if (weights[v] > 0 && std::isfinite(values[v])) counted.push_back(values[v]);
  if (counted.empty()) return 0;
  const auto middle = counted.begin() + static_cast<std::ptrdiff_t>(counted.size() / 2);
  std::nth_element(counted.begin(), middle, counted.end());
  return *middle;
}

}  // namespace

std::vector<double> vertex_areas(std::span<const std::array<std::int32_t, 3>> triangles, std::span<const double> areas,
                                 std::span<const std::uint8_t> excluded, std::size_t num_vertices) {
  std::vector<double> result(num_vertices, 0);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (!excluded.empty() && excluded[t] != 0) continue;
    for (const std::int32_t corner : triangles[t]) result[static_cast<std::size_t>(corner)] += areas[t] / 3;
  }
  return result;
}

std::vector<double> local_means(std::span<const Eigen::Vector3d> positions, std::span<const double> values,
                                std::span<const double> weights, double radius, const Execution& execution) {
  std::vector<double> means(positions.size(), std::numeric_limits<double>::quiet_NaN());
  const Grid grid = make_grid(positions, values, weights, radius);
  parallel_chunks(static_cast<std::int64_t>(grid.cubes.size()), 256, "local mean", execution,
                  [&](std::int64_t first, std::int64_t last) {
                    Columns near;
                    for (auto c = static_cast<std::size_t>(first); c < static_cast<std::size_t>(last); ++c) {
                      gather(grid, grid.cubes[c], radius, near);
                      for (std::int32_t i = grid.first_of_cube[c]; i < grid.first_of_cube[c + 1]; ++i) {
                        const auto v = static_cast<std::size_t>(grid.vertices[static_cast<std::size_t>(i)]);
                        const Total total = ball_total(near, positions[v], radius, grid.size);
                        if (total.weight > 0) means[v] = total.sum / total.weight;
                      }
                    }
                  });
  return means;
}

std::vector<double> clipped_local_means(std::span<const Eigen::Vector3d> positions, std::span<const double> values,
                                        std::span<const double> weights, double radius, double clip,
                                        const Execution& execution) {
  constexpr int kRounds = 3;
  // The first round is about the median of all values: a mean that an edge has tilted would hold its surroundings fast.
  std::vector<double> means(values.size(), median_of(values, weights));
  for (int round = 0; round < kRounds; ++round) {
    std::vector<double> deviations(values.size());
    for (std::size_t v = 0; v < values.size(); ++v) deviations[v] = std::abs(values[v] - means[v]);
    const double most = clip * median_of(deviations, weights);
    std::vector<double> clipped(values.begin(), values.end());
    for (std::size_t v = 0; v < clipped.size(); ++v)
      if (std::isfinite(means[v])) clipped[v] = means[v] + std::clamp(clipped[v] - means[v], -most, most);
    means = local_means(positions, clipped, weights, radius, execution);
  }
  return means;
}

}  // namespace meshmser
