#pragma once
#include "Cuda/Kernels/Loss.h"

namespace innergs::cuda {

/// A 16×16 tile of one slice with a border for the 11×11 window, filtered separably; zero outside the slice.
struct SsimTile {
  static constexpr int kThreads = 256, kEdge = 16, kRadius = kSsimRadius, kWide = kEdge + 2 * kRadius;
  SliceView view;
  int tilesX, tilesY;
  float window[kSsimWidth];

  INNERGS_HD std::int64_t slice(int block) const { return block / tilesX / tilesY; }
  INNERGS_HD int left(int block) const { return block % tilesX * kEdge; }
  INNERGS_HD int top(int block) const { return block / tilesX % tilesY * kEdge; }
  INNERGS_HD bool inside(int x, int y) const { return x >= 0 && y >= 0 && x < view.nx && y < view.ny; }
  INNERGS_HD std::int64_t at(std::int64_t slice, int x, int y) const {
    return slice * view.planeSize + static_cast<std::int64_t>(y) * view.stride + x;
  }
  /// Filters value(k) with the window.
  template <class Value>
  INNERGS_HD float filter(Value&& value) const {
    float sum = 0;
    for (int k = 0; k < kSsimWidth; ++k)
      sum += window[k] * value(k);
    return sum;
  }
  /// each(j, i, v) for every point of the block's tile and border; v: its index, -1 outside the slice.
  template <class Block, class Each>
  INNERGS_KERNEL void eachPoint(Block& block, Each&& each) const {
    const int b = static_cast<int>(block.index());
    block.forEachThread([&](int t) {
      for (int n = t; n < kWide * kWide; n += kThreads) {
        const int i = n % kWide, j = n / kWide, x = left(b) + i - kRadius, y = top(b) + j - kRadius;
        each(j, i, inside(x, y) ? at(slice(b), x, y) : -1);
      }
    });
    block.sync();
  }
  /// each(j, i) for every point that remains after filtering along rows.
  template <class Block, class Each>
  INNERGS_KERNEL void eachOfRows(Block& block, Each&& each) const {
    block.forEachThread([&](int t) {
      for (int n = t; n < kWide * kEdge; n += kThreads)
        each(n / kEdge, n % kEdge);
    });
    block.sync();
  }
};

/// Sum of 1 − SSIM, and its derivatives by the filtered maps.
struct SsimTerms {
  static constexpr int kThreads = SsimTile::kThreads, kEdge = SsimTile::kEdge, kWide = SsimTile::kWide;
  struct Shared {
    float x[kWide][kWide], y[kWide][kWide];
    float rows[5][kWide][kEdge]; // x, y, xx, yy, xy
    Lanes<double, 3> warps[kThreads / kWarp];
  };
  SsimTile tile;
  double ssimWeight;
  const float* image;
  float *dMean, *dSquare, *dProduct;
  PartialLoss* partial;

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    Shared& s = block.shared();
    const int b = static_cast<int>(block.index());
    const std::int64_t slice = tile.slice(b);
    const int left = tile.left(b), top = tile.top(b);
    tile.eachPoint(block, [&](int j, int i, std::int64_t v) {
      s.y[j][i] = v < 0 ? 0.f : tile.view.target[v];
      s.x[j][i] = v >= 0 && tile.view.weight[v] ? image[v] : s.y[j][i];
    });
    tile.eachOfRows(block, [&](int j, int i) {
      const float *x = s.x[j] + i, *y = s.y[j] + i;
      s.rows[0][j][i] = tile.filter([&](int k) { return x[k]; });
      s.rows[1][j][i] = tile.filter([&](int k) { return y[k]; });
      s.rows[2][j][i] = tile.filter([&](int k) { return x[k] * x[k]; });
      s.rows[3][j][i] = tile.filter([&](int k) { return y[k] * y[k]; });
      s.rows[4][j][i] = tile.filter([&](int k) { return x[k] * y[k]; });
    });
    typename Block::template PerThread<Lanes<double, 3>> sums;
    block.forEachThread([&](int t) {
      sums[t] = {};
      const int i = t % kEdge, j = t / kEdge, x = left + i, y = top + j;
      if (!tile.inside(x, y)) return;
      float m[5];
      for (int c = 0; c < 5; ++c)
        m[c] = tile.filter([&](int k) { return s.rows[c][j + k][i]; });
      const SsimTerm term = ssimTerm(m[0], m[1], m[2], m[3], m[4]);
      const std::int64_t v = tile.at(slice, x, y);
      dMean[v] = term.dMean;
      dSquare[v] = term.dSquare;
      dProduct[v] = term.dProduct;
      sums[t].v[0] = ssimWeight * (1 - term.ssim);
    });
    writePartial<kThreads>(block, sums, s.warps, partial + b);
  }
};

/// Adds SSIM's part to r and distributes the sum to the planes.
struct SsimGradient {
  static constexpr int kThreads = SsimTile::kThreads, kEdge = SsimTile::kEdge, kWide = SsimTile::kWide;
  struct Shared {
    float maps[3][kWide][kWide], rows[3][kWide][kEdge];
  };
  SsimTile tile;
  float ssimWeight;
  const float *image, *r, *dMean, *dSquare, *dProduct;
  Pair* planes;

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    Shared& s = block.shared();
    const int b = static_cast<int>(block.index());
    const std::int64_t slice = tile.slice(b);
    const int left = tile.left(b), top = tile.top(b);
    tile.eachPoint(block, [&](int j, int i, std::int64_t v) {
      s.maps[0][j][i] = v < 0 ? 0.f : dMean[v];
      s.maps[1][j][i] = v < 0 ? 0.f : dSquare[v];
      s.maps[2][j][i] = v < 0 ? 0.f : dProduct[v];
    });
    tile.eachOfRows(block, [&](int j, int i) {
      for (int c = 0; c < 3; ++c)
        s.rows[c][j][i] = tile.filter([&](int k) { return s.maps[c][j][i + k]; });
    });
    block.forEachThread([&](int t) {
      const int i = t % kEdge, j = t / kEdge, x = left + i, y = top + j;
      if (y >= tile.view.ny) return; // includes the row padding: its F0 becomes 0
      const std::int64_t v = tile.at(slice, x, y);
      float gradient = r[v];
      if (tile.inside(x, y) && tile.view.weight[v]) {
        float m[3];
        for (int c = 0; c < 3; ++c)
          m[c] = tile.filter([&](int k) { return s.rows[c][j + k][i]; });
        gradient -= ssimWeight * (m[0] + 2 * image[v] * m[1] + tile.view.target[v] * m[2]);
      }
      tile.view.spread(slice, v - slice * tile.view.planeSize, gradient, planes);
    });
  }
};

} // namespace innergs::cuda
