#include "tests/bench/bench_mesh.hpp"

#include <cmath>
#include <numeric>
#include <random>

namespace meshmser::bench {
namespace {

/// A number in -1 .. 1 for each point of a whole-numbered grid.
double lattice(std::int64_t x, std::int64_t y, std::uint64_t octave) {
  std::uint64_t h = static_cast<std::uint64_t>(x) * 0x9E3779B97F4A7C15u ^
                    static_cast<std::uint64_t>(y) * 0xC2B2AE3D27D4EB4Fu ^ (octave + 1) * 0x165667B19E3779F9u;
  h ^= h >> 31;
  h *= 0xBF58476D1CE4E5B9u;
  h ^= h >> 29;
  h *= 0x94D049BB133111EBu;
  h ^= h >> 32;
  return static_cast<double>(h >> 11) / static_cast<double>(std::uint64_t{1} << 52) - 1;
}

double value_noise(double x, double y, std::uint64_t octave) {
  const double floor_x = std::floor(x), floor_y = std::floor(y), u = x - floor_x, v = y - floor_y;
  const auto i = static_cast<std::int64_t>(floor_x), j = static_cast<std::int64_t>(floor_y);
  const double su = u * u * (3 - 2 * u), sv = v * v * (3 - 2 * v);
  const double low = std::lerp(lattice(i, j, octave), lattice(i + 1, j, octave), su);
  const double high = std::lerp(lattice(i, j + 1, octave), lattice(i + 1, j + 1, octave), su);
  return std::lerp(low, high, sv);
}

template <class T>
void shuffle(std::vector<T>& items, std::mt19937_64& random) {
  for (std::size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[random() % i]);
}

}  // namespace

BenchMesh make_bench_mesh(std::int64_t num_triangles, Shape shape, Scalar scalar, Ids ids) {
  BenchMesh mesh;
  const auto n = static_cast<std::int32_t>(std::lround(std::sqrt(static_cast<double>(num_triangles) / 2)));
  const bool sphere = shape == Shape::kSphere;
  // A sphere is the field wound around in x and closed by two caps of triangles.
  const std::int32_t columns = sphere ? n : n + 1;
  const auto num_vertices = static_cast<std::size_t>(n + 1) * static_cast<std::size_t>(columns);
  mesh.values.reserve(num_vertices);
  mesh.positions.reserve(num_vertices);
  mesh.triangles.reserve(2 * static_cast<std::size_t>(n + 1) * static_cast<std::size_t>(n));
  for (std::int32_t y = 0; y <= n; ++y)
    for (std::int32_t x = 0; x < columns; ++x) {
      double value = std::sin(17.0 * x / n) + std::cos(13.0 * y / n + 4.0 * x / n) +
                     0.3 * value_noise(40.0 * x / n, 40.0 * y / n, 9);
      if (scalar == Scalar::kRough)
        for (std::uint64_t octave = 0; octave < 6; ++octave) {
          const double wave = std::ldexp(1.5, static_cast<int>(octave));
          value += 0.12 * std::sqrt(wave) * value_noise(x / wave, y / wave, octave);
        }
      mesh.values.push_back(value);
      if (sphere) {
        const double turn = 2 * M_PI * x / columns, height = M_PI * (y + 0.5) / (n + 1);
        mesh.positions.emplace_back(n * std::sin(height) * std::cos(turn), n * std::sin(height) * std::sin(turn),
                                    -n * std::cos(height));
      } else {
        mesh.positions.emplace_back(x, y, 0.2 * value);
      }
    }
  for (std::int32_t y = 0; y < n; ++y)
    for (std::int32_t x = 0; x < n; ++x) {
      const std::int32_t right = (x + 1) % columns;
      const std::int32_t a = y * columns + x, b = y * columns + right, c = a + columns, d = b + columns;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  if (sphere)
    for (std::int32_t x = 1; x + 1 < columns; ++x) {
      const std::int32_t top = n * columns;
      mesh.triangles.push_back({0, x + 1, x});
      mesh.triangles.push_back({top, top + x, top + x + 1});
    }
  if (ids == Ids::kShuffled) {
    std::mt19937_64 random(1);
    std::vector<std::int32_t> place(mesh.positions.size());
    std::iota(place.begin(), place.end(), 0);
    shuffle(place, random);
    std::vector<Eigen::Vector3d> positions(place.size());
    std::vector<double> values(place.size());
    for (std::size_t v = 0; v < place.size(); ++v) {
      positions[static_cast<std::size_t>(place[v])] = mesh.positions[v];
      values[static_cast<std::size_t>(place[v])] = mesh.values[v];
    }
    mesh.positions = std::move(positions);
    mesh.values = std::move(values);
    for (auto& triangle : mesh.triangles)
      for (std::int32_t& corner : triangle) corner = place[static_cast<std::size_t>(corner)];
    shuffle(mesh.triangles, random);
  }
  return mesh;
}

BenchMesh make_nested_mesh(std::int64_t num_triangles, std::int32_t depth) {
  BenchMesh mesh = make_bench_mesh(num_triangles, Shape::kHeightField, Scalar::kSmooth, Ids::kOrdered);
  const auto n = static_cast<std::int32_t>(std::lround(std::sqrt(static_cast<double>(num_triangles) / 2)));
  const std::int32_t pitch = n / 4, middle = 12;
  auto from_side = [&](std::int32_t x, std::int32_t y) {
    return std::min({x % pitch, pitch - 1 - x % pitch, y % pitch, pitch - 1 - y % pitch});
  };
  for (std::int32_t y = 0; y <= n; ++y)
    for (std::int32_t x = 0; x <= n; ++x) {
      const bool is_tower = x / pitch < 4 && y / pitch < 4 && 4 * (y / pitch) + x / pitch < 16 / depth;
      mesh.values[static_cast<std::size_t>(y) * static_cast<std::size_t>(n + 1) + static_cast<std::size_t>(x)] =
          is_tower ? std::clamp(from_side(x, y) - (middle - depth / 2), 0, depth) : 0;
    }
  std::vector<std::array<std::int32_t, 3>> kept;
  for (std::int32_t y = 0; y < n; ++y)
    for (std::int32_t x = 0; x < n; ++x) {
      const std::size_t first =
          2 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(n) + static_cast<std::size_t>(x));
      if (x % 4 != 0 || y % 4 != 0 || from_side(x, y) < middle + 10) kept.push_back(mesh.triangles[first]);
      kept.push_back(mesh.triangles[first + 1]);
    }
  mesh.triangles = std::move(kept);
  return mesh;
}

}  // namespace meshmser::bench
