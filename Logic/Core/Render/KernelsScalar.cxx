#include "Core/Render/KernelsScalar.h"

#include "Core/Render/Candidates.h"

namespace innergs {
namespace {

/// visit(plane, row, column, w·p before the cut, dx, dy, dz) for every candidate inside the cut-off.
template <Selection selection, class Visit>
void forEachVoxel(const Projected& g, const GridView& grid, const TileRange& tile, Visit&& visit) {
  forEachCandidateRow<selection>(g, grid, tile, [&](int k, int y, int x0, int x1) {
    const float dz = planeOffset(g, grid.z[k]);
    const float dy = static_cast<float>(y - g.cell[1]) - g.fraction[1];
    for (int x = x0; x < x1; ++x) {
      const float dx = static_cast<float>(x - g.cell[0]) - g.fraction[0];
      const float* q = g.quadratic;
      const float e = q[0] * dx * dx + q[1] * dx * dy + q[2] * dx * dz + q[3] * dy * dy + q[4] * dy * dz +
                      q[5] * dz * dz + g.log2Weight;
      if (!(e >= g.log2Cut)) continue; // rejects NaN too
      visit(k, y, x, std::exp2(e), dx, dy, dz);
    }
  });
}

std::size_t voxelIndex(const GridView& grid, int k, int y, int x) {
  return (static_cast<std::size_t>(k) * grid.ny + y) * grid.stride + x;
}

template <Selection selection>
void accumulate(const Projected* gaussians, const std::uint32_t* ids, std::size_t count, const GridView& grid,
                const TileRange& tile, float* weights, float* numerators) {
  for (std::size_t n = 0; n < count; ++n) {
    const Projected& g = gaussians[ids[n]];
    forEachVoxel<selection>(g, grid, tile, [&](int k, int y, int x, float q, float dx, float dy, float dz) {
      const std::size_t voxel = voxelIndex(grid, k, y, x);
      const float p = q - g.cut;
      weights[voxel] += p;
      numerators[voxel] += p * (g.value + g.slope[0] * dx + g.slope[1] * dy + g.slope[2] * dz);
    });
  }
}

template <Selection selection>
void gather(const Projected& g, const GridView& grid, const float* f0, const float* f1,
            math::Moments<float>& out) {
  math::Moments<double> m;
  const TileRange everything{0, grid.ny, 0, grid.nz};
  forEachVoxel<selection>(
      g, grid, everything, [&](int k, int y, int x, float q, float dx, float dy, float dz) {
        const std::size_t voxel = voxelIndex(grid, k, y, x);
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

template <Selection selection>
void composite(const Projected* gaussians, const std::uint32_t* ids, std::size_t count, const GridView& grid,
               const TileRange& tile, float* transmittance, float* image) {
  for (std::size_t n = 0; n < count; ++n) {
    const Projected& g = gaussians[ids[n]];
    forEachVoxel<selection>(g, grid, tile, [&](int k, int y, int x, float q, float, float, float) {
      const std::size_t voxel = voxelIndex(grid, k, y, x);
      const float visible = transmittance[voxel] * (q - g.cut);
      image[voxel] += visible * g.value;
      transmittance[voxel] -= visible;
    });
  }
}

template <Selection selection>
void compositeBackward(const Projected* gaussians, const std::uint32_t* ids, std::size_t count,
                       const GridView& grid, const TileRange& tile, const float* r, float* transmittance,
                       float* rest, math::PlaneMoments<float>* out) {
  for (std::size_t n = 0; n < count; ++n) {
    const Projected& g = gaussians[ids[n]];
    math::PlaneMoments<double> m;
    forEachVoxel<selection>(g, grid, tile, [&](int k, int y, int x, float q, float dx, float dy, float) {
      const std::size_t local = static_cast<std::size_t>(y - tile.y0) * grid.stride + x;
      const float a = q - g.cut, seen = transmittance[local], visible = seen * a;
      const float derivative = r[voxelIndex(grid, k, y, x)];
      rest[local] -= visible * g.value;
      transmittance[local] -= visible;
      // The Gaussians behind this one are seen through its 1 − a.
      const double f = derivative * (static_cast<double>(seen) * g.value - rest[local] / (1.0 - a));
      const double fq = f * q;
      m.m0 += f * a;
      m.s += fq;
      m.x += fq * dx;
      m.y += fq * dy;
      m.xx += fq * dx * dx;
      m.xy += fq * dx * dy;
      m.yy += fq * dy * dy;
      m.n0 += derivative * visible;
    });
    const auto single = [](double value) { return static_cast<float>(value); };
    out[n] = {single(m.m0), single(m.n0), single(m.s),  single(m.x),
              single(m.y),  single(m.xx), single(m.xy), single(m.yy)};
  }
}

template <Selection selection>
KernelSet kernels() {
  return {"scalar",
          selection,
          accumulate<selection>,
          gather<selection>,
          composite<selection>,
          compositeBackward<selection>};
}

} // namespace

KernelSet scalarKernels(Selection selection) {
  return selection == Selection::Exact     ? kernels<Selection::Exact>()
         : selection == Selection::Method1 ? kernels<Selection::Method1>()
                                           : kernels<Selection::Method2>();
}

} // namespace innergs
