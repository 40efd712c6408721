#pragma once
/// Meshes and scalars for benchmarks: of any size, smooth or rough, with ids in order or shuffled.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace meshmser::bench {

enum class Shape { kHeightField, kSphere };
enum class Scalar {
  kSmooth,  ///< a few long waves: few maxima
  kRough    ///< six octaves of noise down to the spacing: about one maximum in a dozen vertices
};
enum class Ids {
  kOrdered,  ///< row by row
  kShuffled  ///< vertices and triangles in random order
};

struct BenchMesh {
  std::vector<Eigen::Vector3d> positions;
  std::vector<std::array<std::int32_t, 3>> triangles;
  std::vector<double> values;  ///< per vertex
};

/// About `num_triangles` triangles; the same for the same arguments.
BenchMesh make_bench_mesh(std::int64_t num_triangles, Shape shape, Scalar scalar, Ids ids);

/// A square field of about `num_triangles` triangles in 16 cells, many holes in each; 16 / depth of the cells have a
/// tower of `depth` terraces one square wide. The terraces' borders have the same length in all for every depth that
/// divides 16, since the middle terrace of a tower is always at the same place; the holes lie within the highest.
BenchMesh make_nested_mesh(std::int64_t num_triangles, std::int32_t depth);

}  // namespace meshmser::bench
