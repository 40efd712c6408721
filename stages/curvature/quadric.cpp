#include "stages/curvature/quadric.hpp"

#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>

#include "stages/common/cell_grid.hpp"
#include "stages/curvature/block_normals.hpp"

namespace meshmser {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr int kReach = 2;
constexpr int kTerms = 6;

// Sums of u^i v^j for i + j <= 4 (by degree, then by falling power of u), then of w times the six terms.
constexpr int kNumSums = 21;
using Sums = std::array<double, kNumSums>;

struct Frame {
  Eigen::Vector3d u, v, w;  // u and v divided by the radius, so that sums are near 1
};

struct BlockView {
  const double *x, *y, *z;
  const double *nx, *ny, *nz;
  std::int64_t padded;
};

MESHMSER_SIMD void add_up(const BlockView& block, std::int64_t own, const Frame& frame, double radius, double* out) {
  const double square = radius * radius;
  const double qx = block.x[own], qy = block.y[own], qz = block.z[own];
  Lanes sums[kNumSums]{};
  for (std::int64_t i = 0; i < block.padded; i += kLanes) {
    Lanes x, y, z;
    std::memcpy(&x, block.x + i, sizeof x);
    std::memcpy(&y, block.y + i, sizeof y);
    std::memcpy(&z, block.z + i, sizeof z);
    x -= qx, y -= qy, z -= qz;
    LaneMask near = (x * x + y * y + z * z) <= square;
    if (block.nx != nullptr) {
      Lanes nx, ny, nz;
      std::memcpy(&nx, block.nx + i, sizeof nx);
      std::memcpy(&ny, block.ny + i, sizeof ny);
      std::memcpy(&nz, block.nz + i, sizeof nz);
      near &= (nx * block.nx[own] + ny * block.ny[own] + nz * block.nz[own]) >= kOpposedCosine;
    }
    const Lanes one = (Lanes)((LaneMask)(Lanes{} + 1.0) & near);
    const Lanes u = (Lanes)((LaneMask)(x * frame.u[0] + y * frame.u[1] + z * frame.u[2]) & near);
    const Lanes v = (Lanes)((LaneMask)(x * frame.v[0] + y * frame.v[1] + z * frame.v[2]) & near);
    const Lanes w = (Lanes)((LaneMask)(x * frame.w[0] + y * frame.w[1] + z * frame.w[2]) & near);
    const Lanes uu = u * u, uv = u * v, vv = v * v;
    sums[0] += one;
    sums[1] += u;
    sums[2] += v;
    sums[3] += uu;
    sums[4] += uv;
    sums[5] += vv;
    sums[6] += uu * u;
    sums[7] += uu * v;
    sums[8] += u * vv;
    sums[9] += vv * v;
    sums[10] += uu * uu;
    sums[11] += uu * uv;
    sums[12] += uu * vv;
    sums[13] += uv * vv;
    sums[14] += vv * vv;
    sums[15] += w;
    sums[16] += w * u;
    sums[17] += w * v;
    sums[18] += w * uu;
    sums[19] += w * uv;
    sums[20] += w * vv;
  }
  for (int s = 0; s < kNumSums; ++s) out[s] = (sums[s][0] + sums[s][1]) + (sums[s][2] + sums[s][3]);
}

// Least-squares coefficients from the sums by Cholesky's decomposition; false where the points do not determine them.
bool solve(const Sums& sums, std::array<double, kTerms>& coefficients) {
  // Sum belonging to the product of terms i and j of 1, u, v, uu, uv, vv.
  static constexpr int kProduct[kTerms][kTerms] = {{0, 1, 2, 3, 4, 5},    {1, 3, 4, 6, 7, 8},    {2, 4, 5, 7, 8, 9},
                                                   {3, 6, 7, 10, 11, 12}, {4, 7, 8, 11, 12, 13}, {5, 8, 9, 12, 13, 14}};
  double lower[kTerms][kTerms];
  for (int i = 0; i < kTerms; ++i) {
    for (int j = 0; j <= i; ++j) {
      double value = sums[static_cast<std::size_t>(kProduct[i][j])];
      for (int k = 0; k < j; ++k) value -= lower[i][k] * lower[j][k];
      if (i != j) {
        lower[i][j] = value / lower[j][j];
      } else {
        // A pivot far below its diagonal: the points lie on a conic.
        if (!(value > 1e-6 * sums[static_cast<std::size_t>(kProduct[i][i])])) return false;
        lower[i][i] = std::sqrt(value);
      }
    }
  }
  for (int i = 0; i < kTerms; ++i) {
    double value = sums[static_cast<std::size_t>(15 + i)];
    for (int k = 0; k < i; ++k) value -= lower[i][k] * coefficients[static_cast<std::size_t>(k)];
    coefficients[static_cast<std::size_t>(i)] = value / lower[i][i];
  }
  for (int i = kTerms - 1; i >= 0; --i) {
    double value = coefficients[static_cast<std::size_t>(i)];
    for (int k = i + 1; k < kTerms; ++k) value -= lower[k][i] * coefficients[static_cast<std::size_t>(k)];
    coefficients[static_cast<std::size_t>(i)] = value / lower[i][i];
  }
  return true;
}

Frame frame_of(const Eigen::Vector3d& normal, double radius) {
  // Duff et al. 2017, "Building an orthonormal basis, revisited".
  const double sign = std::copysign(1.0, normal.z());
  const double a = -1 / (sign + normal.z()), b = normal.x() * normal.y() * a;
  Frame frame;
  frame.u = Eigen::Vector3d(1 + sign * normal.x() * normal.x() * a, sign * b, -sign * normal.x()) / radius;
  frame.v = Eigen::Vector3d(b, sign + normal.y() * normal.y() * a, -normal.y()) / radius;
  frame.w = normal;
  return frame;
}

}  // namespace

PrincipalCurvatures fit_quadrics(std::span<const Eigen::Vector3d> points, std::span<const Eigen::Vector3d> normals,
                                 double radius, const Execution& execution) {
  if (!(radius > 0) || !std::isfinite(radius))
    throw StageError("the radius of the quadrics must be positive; it is " + std::to_string(radius));
  PrincipalCurvatures result;
  result.k1.assign(points.size(), kNaN);
  result.k2.assign(points.size(), kNaN);
  std::atomic<std::int64_t> undefined{0};
  const CellGrid grid(points, radius / kReach);
  for_each_cell(grid, kReach, "quadrics", execution, [&](const CellBlock& block) {
    thread_local BlockNormals block_normals;
    BlockView view{block.x.data(), block.y.data(), block.z.data(), nullptr, nullptr, nullptr, block.padded};
    if (block_normals.gather(block, normals)) {
      view.nx = block_normals.x.data();
      view.ny = block_normals.y.data();
      view.nz = block_normals.z.data();
    }
    for (std::int64_t own = block.own_begin; own < block.own_end; ++own) {
      const auto id = static_cast<std::size_t>(block.ids[static_cast<std::size_t>(own)]);
      const Eigen::Vector3d& normal = normals[id];
      Sums sums;
      std::array<double, kTerms> c;
      bool fitted = normal != Eigen::Vector3d::Zero();
      if (fitted) {
        add_up(view, own, frame_of(normal, radius), radius, sums.data());
        fitted = solve(sums, c);
      }
      if (!fitted) {
        undefined.fetch_add(1, std::memory_order_relaxed);
        continue;
      }
      // Derivatives of the height by length: u and v are in radii.
      const double hu = c[1] / radius, hv = c[2] / radius;
      const double huu = 2 * c[3] / (radius * radius), huv = c[4] / (radius * radius);
      const double hvv = 2 * c[5] / (radius * radius);
      const double metric = 1 + hu * hu + hv * hv, length = std::sqrt(metric);
      const double mean = -((1 + hv * hv) * huu - 2 * hu * hv * huv + (1 + hu * hu) * hvv) / (2 * metric * length);
      const double gauss = (huu * hvv - huv * huv) / (metric * metric);
      const double half_gap = std::sqrt(std::max(0.0, mean * mean - gauss));
      result.k1[id] = mean + half_gap;
      result.k2[id] = mean - half_gap;
    }
  });
  result.num_undefined = undefined.load();
  return result;
}

double quadric_noise(double noise, double spacing, double radius) {
  return std::sqrt(48 / std::numbers::pi) * noise * spacing / (radius * radius * radius);
}

}  // namespace meshmser
