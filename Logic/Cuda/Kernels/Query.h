#pragma once
#include "Core/Render/Contribution.h"
#include "Cuda/Block.h"
#include "Cuda/Kernels/Reach.h"

namespace innergs::cuda {

/// Computes I from W and N, without the row padding.
struct Finish {
  static constexpr int kThreads = 256;
  using Shared = Nothing;
  GridView grid;
  const Pair* planes;
  Blending blending;
  float epsilon;
  float* out; // [plane][ny][nx]

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    forEachItem<kThreads>(block, static_cast<std::int64_t>(grid.nz) * grid.ny * grid.nx, [&](std::int64_t i) {
      const std::int64_t row = quotient(i, grid.nx);
      const Pair at = planes[row * grid.stride + i - row * grid.nx];
      out[i] = blending == Blending::Normalised ? at.b / (at.a + epsilon) : at.b;
    });
  }
};

/// I at points, from the Gaussians listed for each point's cell.
struct QueryPoints {
  static constexpr int kThreads = 128;
  using Shared = Nothing;
  const Projected* gaussians;
  CellReach cells;
  const std::int64_t* start;
  const std::uint32_t* ids;
  const double* points; // index coordinates, three per point
  std::int64_t count;
  Blending blending;
  float epsilon;
  float* out;

  INNERGS_HD float summed(const double* x, std::int64_t first, std::int64_t last) const {
    float w = 0, n = 0;
    Contribution c;
    for (std::int64_t m = first; m < last; ++m)
      if (contributionAt(gaussians[ids[m]], x, c)) {
        w += c.p;
        n += c.p * c.value;
      }
    return blending == Blending::Normalised ? n / (w + epsilon) : n;
  }

  /// Alpha blending: nearest first, ties by index. Searches for the next one each time, since no list is
  /// kept.
  INNERGS_HD float composited(const double* x, std::int64_t first, std::int64_t last) const {
    float transmittance = 1, image = 0, depth = -1;
    std::int64_t at = -1;
    for (;;) {
      Contribution next{0, 0, 0}, c;
      std::int64_t found = -1;
      for (std::int64_t m = first; m < last; ++m) {
        if (!contributionAt(gaussians[ids[m]], x, c)) continue;
        const bool after = c.depth > depth || (c.depth == depth && m > at);
        if (!after || (found >= 0 && !(c.depth < next.depth))) continue;
        next = c;
        found = m;
      }
      if (found < 0) return image;
      const float visible = transmittance * next.p;
      image += visible * next.value;
      transmittance -= visible;
      depth = next.depth;
      at = found;
    }
  }

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    forEachItem<kThreads>(block, count, [&](std::int64_t i) {
      const double* x = points + 3 * i;
      const int size[3] = {cells.nx, cells.ny, cells.nz};
      int cell[3];
      for (int a = 0; a < 3; ++a)
        cell[a] = math::clamped(static_cast<int>(x[a]), 0, size[a] - 1);
      const std::int64_t b = cell[0] + static_cast<std::int64_t>(cells.nx) *
                                           (cell[1] + static_cast<std::int64_t>(cells.ny) * cell[2]);
      out[i] = blending == Blending::Alpha ? composited(x, start[b], start[b + 1])
                                           : summed(x, start[b], start[b + 1]);
    });
  }
};

} // namespace innergs::cuda
