#include "Core/KernelsScalar.h"

namespace innergs {
namespace {

struct Box {
  int x0, x1, k0, k1;
};

/// The part of the ellipsoid's bounding columns and planes that lies on the lattice.
Box boundingBox(const Projected& g, const LatticeView& lattice) {
  Box b;
  columnRange(g, b.x0, b.x1);
  const std::int64_t cell = g.cell[0];
  b.x0 = static_cast<int>(std::clamp<std::int64_t>(cell + b.x0, 0, lattice.nx));
  b.x1 = static_cast<int>(std::clamp<std::int64_t>(cell + b.x1, 0, lattice.nx));
  planeRange(g, lattice, b.k0, b.k1);
  return b;
}

template <class Visit>
void forEachVoxel(const Projected& g, const LatticeView& lattice, const TileRange& tile, Visit&& visit) {
  const Box box = boundingBox(g, lattice);
  for (int k = std::max(box.k0, tile.k0); k < std::min(box.k1, tile.k1); ++k) {
    const float dz = planeOffset(g, lattice.z[k]);
    int r0, r1;
    if (!rowRange(g, dz, r0, r1)) continue;
    const std::int64_t cell = g.cell[1];
    const int y0 = static_cast<int>(std::clamp<std::int64_t>(cell + r0, tile.y0, tile.y1));
    const int y1 = static_cast<int>(std::clamp<std::int64_t>(cell + r1, tile.y0, tile.y1));
    for (int y = y0; y < y1; ++y) {
      const float dy = static_cast<float>(y - g.cell[1]) - g.fraction[1];
      const std::size_t row = (static_cast<std::size_t>(k) * lattice.ny + y) * lattice.stride;
      for (int x = box.x0; x < box.x1; ++x) {
        const float dx = static_cast<float>(x - g.cell[0]) - g.fraction[0];
        const float* q = g.quadratic;
        const float e = q[0] * dx * dx + q[1] * dx * dy + q[2] * dx * dz + q[3] * dy * dy + q[4] * dy * dz +
                        q[5] * dz * dz + g.log2Weight;
        if (!(e >= g.log2Cut)) continue; // NaN as well
        visit(row + x, std::exp2(e), dx, dy, dz);
      }
    }
  }
}

} // namespace

void accumulateScalar(const Projected* gaussians, const std::uint32_t* ids, std::size_t count,
                      const LatticeView& lattice, const TileRange& tile, float* weights, float* numerators) {
  for (std::size_t n = 0; n < count; ++n) {
    const Projected& g = gaussians[ids[n]];
    forEachVoxel(g, lattice, tile, [&](std::size_t voxel, float q, float dx, float dy, float dz) {
      const float p = q - g.cut;
      weights[voxel] += p;
      numerators[voxel] += p * (g.value + g.slope[0] * dx + g.slope[1] * dy + g.slope[2] * dz);
    });
  }
}

void gatherScalar(const Projected& g, const LatticeView& lattice, const float* f0, const float* f1,
                  math::Moments<float>& out) {
  math::Moments<double> m;
  const TileRange everything{0, lattice.ny, 0, lattice.nz};
  forEachVoxel(g, lattice, everything, [&](std::size_t voxel, float q, float dx, float dy, float dz) {
    const double value = g.value + g.slope[0] * dx + g.slope[1] * dy + g.slope[2] * dz;
    const double f = f0[voxel] * value + f1[voxel], fq = f * q, cut = q - g.cut, n = f0[voxel] * cut;
    const double d[3] = {dx, dy, dz};
    m.m0 += f * cut;
    m.n0 += n;
    int t = 0;
    for (int i = 0; i < 3; ++i) {
      m.m1[i] += fq * d[i];
      m.n1[i] += n * d[i];
      for (int j = i; j < 3; ++j)
        m.m2[t++] += fq * d[i] * d[j];
    }
  });
  out.m0 = static_cast<float>(m.m0);
  out.n0 = static_cast<float>(m.n0);
  for (int i = 0; i < 3; ++i) {
    out.m1[i] = static_cast<float>(m.m1[i]);
    out.n1[i] = static_cast<float>(m.n1[i]);
  }
  for (int i = 0; i < 6; ++i)
    out.m2[i] = static_cast<float>(m.m2[i]);
}

} // namespace innergs
