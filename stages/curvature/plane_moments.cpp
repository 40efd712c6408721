#include "stages/curvature/plane_moments.hpp"

#include <cstring>

namespace meshmser {
namespace {

struct BlockView {
  const double *x, *y, *z;
  std::int64_t padded, own_begin, own_end;
};

// Written into both of the functions below, so that each of them is compiled for every processor.
template <bool kWithNormals>
[[gnu::always_inline]] inline void add_up(const BlockView& block, const BlockNormals* normals, double radius,
                                          PlaneMoments* out) {
  const double square = radius * radius;
  for (std::int64_t own = block.own_begin; own < block.own_end; ++own, ++out) {
    const double qx = block.x[own], qy = block.y[own], qz = block.z[own];
    Lanes n{}, sx{}, sy{}, sz{}, sxx{}, sxy{}, sxz{}, syy{}, syz{}, szz{};
    for (std::int64_t i = 0; i < block.padded; i += kLanes) {
      Lanes x, y, z;
      std::memcpy(&x, block.x + i, sizeof x);
      std::memcpy(&y, block.y + i, sizeof y);
      std::memcpy(&z, block.z + i, sizeof z);
      x -= qx, y -= qy, z -= qz;
      Lanes xx = x * x, yy = y * y, zz = z * z;
      LaneMask near = (xx + yy + zz) <= square;
      if constexpr (kWithNormals) {
        Lanes nx, ny, nz;
        std::memcpy(&nx, normals->x.data() + i, sizeof nx);
        std::memcpy(&ny, normals->y.data() + i, sizeof ny);
        std::memcpy(&nz, normals->z.data() + i, sizeof nz);
        const Lanes cosine = nx * normals->x[static_cast<std::size_t>(own)] +
                             ny * normals->y[static_cast<std::size_t>(own)] +
                             nz * normals->z[static_cast<std::size_t>(own)];
        near &= cosine >= kOpposedCosine;
      }
      const Lanes one = (Lanes)((LaneMask)(Lanes{} + 1.0) & near);
      x = (Lanes)((LaneMask)x & near);
      y = (Lanes)((LaneMask)y & near);
      z = (Lanes)((LaneMask)z & near);
      n += one;
      sx += x;
      sy += y;
      sz += z;
      sxx += (Lanes)((LaneMask)xx & near);
      syy += (Lanes)((LaneMask)yy & near);
      szz += (Lanes)((LaneMask)zz & near);
      sxy += x * y;
      sxz += x * z;
      syz += y * z;
    }
    out->count = (n[0] + n[1]) + (n[2] + n[3]);
    out->x = (sx[0] + sx[1]) + (sx[2] + sx[3]);
    out->y = (sy[0] + sy[1]) + (sy[2] + sy[3]);
    out->z = (sz[0] + sz[1]) + (sz[2] + sz[3]);
    out->xx = (sxx[0] + sxx[1]) + (sxx[2] + sxx[3]);
    out->xy = (sxy[0] + sxy[1]) + (sxy[2] + sxy[3]);
    out->xz = (sxz[0] + sxz[1]) + (sxz[2] + sxz[3]);
    out->yy = (syy[0] + syy[1]) + (syy[2] + syy[3]);
    out->yz = (syz[0] + syz[1]) + (syz[2] + syz[3]);
    out->zz = (szz[0] + szz[1]) + (szz[2] + szz[3]);
  }
}

MESHMSER_SIMD void add_up_all(const BlockView& block, double radius, PlaneMoments* out) {
  add_up<false>(block, nullptr, radius, out);
}

MESHMSER_SIMD void add_up_facing(const BlockView& block, const BlockNormals& normals, double radius,
                                 PlaneMoments* out) {
  add_up<true>(block, &normals, radius, out);
}

BlockView view_of(const CellBlock& block) {
  return {block.x.data(), block.y.data(), block.z.data(), block.padded, block.own_begin, block.own_end};
}

}  // namespace

void plane_moments(const CellBlock& block, const BlockNormals& normals, double radius,
                   std::vector<PlaneMoments>& moments) {
  moments.resize(static_cast<std::size_t>(block.own_end - block.own_begin));
  add_up_facing(view_of(block), normals, radius, moments.data());
}

void plane_moments(const CellBlock& block, double radius, std::vector<PlaneMoments>& moments) {
  moments.resize(static_cast<std::size_t>(block.own_end - block.own_begin));
  add_up_all(view_of(block), radius, moments.data());
}

}  // namespace meshmser
