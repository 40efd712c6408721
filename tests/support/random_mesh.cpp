#include "tests/support/random_mesh.hpp"

#include <algorithm>
#include <numeric>
#include <random>
#include <set>
#include <utility>

namespace meshmser::testing {
namespace {

class Builder {
 public:
  explicit Builder(std::uint32_t seed) : random_(seed) {}

  /// 0 .. n - 1; by remainder, since distributions differ between libraries.
  std::int32_t below(std::int32_t n) { return static_cast<std::int32_t>(random_() % static_cast<std::uint32_t>(n)); }

  std::int32_t vertex(double x, double y, double z) {
    mesh.positions.emplace_back(x, y, z);
    return static_cast<std::int32_t>(mesh.positions.size()) - 1;
  }

  /// A sheet of squares, each cut along a random diagonal; joined to a tube where `round`.
  void sheet(std::int32_t columns, std::int32_t rows, bool round, double height) {
    std::vector<std::vector<std::int32_t>> id(static_cast<std::size_t>(rows) + 1);
    const bool flat_row = below(4) == 0;  // two rows of vertices in one place: triangles without area
    for (std::int32_t y = 0; y <= rows; ++y)
      for (std::int32_t x = 0; x <= columns; ++x)
        id[static_cast<std::size_t>(y)].push_back(
            round && x == columns ? id[static_cast<std::size_t>(y)][0] : vertex(x, flat_row && y == 1 ? 0 : y, height));
    for (std::int32_t y = 0; y < rows; ++y)
      for (std::int32_t x = 0; x < columns; ++x) {
        const auto& low = id[static_cast<std::size_t>(y)];
        const auto& high = id[static_cast<std::size_t>(y) + 1];
        const std::int32_t a = low[static_cast<std::size_t>(x)], b = low[static_cast<std::size_t>(x) + 1];
        const std::int32_t c = high[static_cast<std::size_t>(x) + 1], d = high[static_cast<std::size_t>(x)];
        if (below(2) == 0) {
          mesh.triangles.push_back({a, b, c});
          mesh.triangles.push_back({a, c, d});
        } else {
          mesh.triangles.push_back({a, b, d});
          mesh.triangles.push_back({b, c, d});
        }
      }
  }

  /// A double cone: closed, of genus 0.
  void closed(std::int32_t around, double height) {
    const std::int32_t top = vertex(0, 0, height + 1), bottom = vertex(0, 0, height - 1);
    std::vector<std::int32_t> ring;
    for (std::int32_t i = 0; i < around; ++i) ring.push_back(vertex(i % 3, i / 3, height));
    for (std::int32_t i = 0; i < around; ++i) {
      const std::int32_t a = ring[static_cast<std::size_t>(i)], b = ring[static_cast<std::size_t>((i + 1) % around)];
      mesh.triangles.push_back({a, b, top});
      mesh.triangles.push_back({b, a, bottom});
    }
  }

  /// Two triangles on the same three vertices: they share all three edges.
  void pillow(double height) {
    const std::int32_t a = vertex(0, 0, height), b = vertex(1, 0, height), c = vertex(0, 1, height);
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({c, b, a});
  }

  void remove_triangles(std::int32_t one_in) {
    std::erase_if(mesh.triangles, [&](const auto&) { return below(one_in) == 0; });
  }

  /// Glues one vertex onto another where no edge and no corner would be doubled.
  void glue_vertices(std::int32_t attempts) {
    for (std::int32_t i = 0; i < attempts; ++i) {
      const std::int32_t n = static_cast<std::int32_t>(mesh.positions.size());
      const std::int32_t keep = below(n), drop = below(n);
      if (keep == drop) continue;
      auto glued = mesh.triangles;
      for (auto& triangle : glued) std::replace(triangle.begin(), triangle.end(), drop, keep);
      if (is_sound(glued)) mesh.triangles = std::move(glued);
    }
  }

  void finish() {
    std::vector<std::int32_t> order(mesh.positions.size());
    std::iota(order.begin(), order.end(), 0);
    shuffle(order);
    std::vector<Eigen::Vector3d> positions(order.size());
    for (std::size_t v = 0; v < order.size(); ++v) positions[static_cast<std::size_t>(order[v])] = mesh.positions[v];
    mesh.positions = std::move(positions);
    for (auto& triangle : mesh.triangles) {
      for (std::int32_t& corner : triangle) corner = order[static_cast<std::size_t>(corner)];
      std::rotate(triangle.begin(), triangle.begin() + below(3), triangle.end());
    }
    shuffle(mesh.triangles);
    const std::int32_t distinct = 1 + below(8);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) mesh.values.push_back(below(distinct) - distinct / 2);
  }

  RandomMesh mesh;

 private:
  static bool is_sound(const std::vector<std::array<std::int32_t, 3>>& triangles) {
    std::set<std::pair<std::int32_t, std::int32_t>> directed;
    for (const auto& t : triangles)
      for (std::size_t k = 0; k < 3; ++k)
        if (t[k] == t[(k + 1) % 3] || !directed.emplace(t[k], t[(k + 1) % 3]).second) return false;
    return true;
  }

  template <class T>
  void shuffle(std::vector<T>& items) {
    for (std::size_t i = items.size(); i > 1; --i)
      std::swap(items[i - 1], items[static_cast<std::size_t>(below(static_cast<std::int32_t>(i)))]);
  }

  std::mt19937 random_;
};

}  // namespace

RandomMesh random_mesh(std::uint32_t seed) {
  Builder builder(seed);
  const std::int32_t components = 1 + builder.below(3);
  for (std::int32_t i = 0; i < components; ++i) {
    switch (builder.below(6)) {
      case 0:
        builder.closed(3 + builder.below(6), 3 * i);
        break;
      case 1:
        builder.pillow(3 * i);
        break;
      case 2:
        builder.sheet(3 + builder.below(4), 1 + builder.below(4), true, 3 * i);
        break;
      default:
        builder.sheet(1 + builder.below(6), 1 + builder.below(5), false, 3 * i);
    }
  }
  if (builder.below(2) == 0) builder.remove_triangles(4 + builder.below(12));
  if (builder.below(2) == 0) builder.glue_vertices(builder.below(12));
  builder.finish();
  return std::move(builder.mesh);
}

}  // namespace meshmser::testing
