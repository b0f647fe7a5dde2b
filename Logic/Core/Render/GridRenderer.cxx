#include "Core/Render/GridRenderer.h"

#include "Core/Render/FieldGradient.h"

#include <utility>

namespace innergs {

GridRenderer::GridRenderer(SampleGrid grid, const KernelSet& kernels, ThreadPool& pool, ClosedFormPsf psf,
                           Scratch scratch)
    : grid_(std::move(grid)), kernels_(kernels), pool_(pool), psf_(psf), compositor_(view(), kernels),
      scratch_(scratch ? std::move(scratch) : std::make_shared<Buffers>()) {}

GridView GridRenderer::view() const {
  return {grid_.nx, grid_.ny, grid_.planes(), grid_.stride(), grid_.z.data()};
}

void GridRenderer::forward(const GaussianField& field, std::span<const float> values, float* weights,
                           float* numerators, const GaussianBlocks* blocks) {
  const GridView grid = view();
  NearGaussians& near = scratch_->near;
  Tiles& tiles = scratch_->tiles;
  if (field.blending == Blending::Alpha || kernels_.selection != Selection::Exact) {
    near.number.clear();
    project(field, values, grid_, psf_, pool_, near.projected, kernels_.selection);
  } else {
    projectNear(field, values, grid_, psf_, pool_, near, blocks);
  }
  if (field.blending == Blending::Alpha)
    return compositor_.forward(near.projected, grid, pool_, weights, numerators);
  tiles.divide(grid);
  tiles.bin(near.projected, grid, pool_);
  pool_.run(tiles.count(), [&](std::int64_t t) {
    const TileRange range = tiles.range(t, grid);
    for (int k = range.k0; k < range.k1; ++k) {
      const std::size_t first = (static_cast<std::size_t>(k) * grid.ny + range.y0) * grid.stride;
      const std::size_t size = static_cast<std::size_t>(range.y1 - range.y0) * grid.stride;
      std::fill_n(weights + first, size, 0.f);
      std::fill_n(numerators + first, size, 0.f);
    }
    const auto members = std::as_const(tiles).members(t);
    kernels_.accumulate(near.projected.data(), members.data(), members.size(), grid, range, weights,
                        numerators);
  });
}

void GridRenderer::backward(const GaussianField& field, const float* f0, const float* f1,
                            std::span<float> gradient) {
  const GridView grid = view();
  const NearGaussians& near = scratch_->near;
  const Tiles& tiles = scratch_->tiles;
  const FieldGradient chain(field, grid_, psf_);
  const bool alpha = field.blending == Blending::Alpha;
  if (alpha) compositor_.backward(near.projected, grid, pool_, f0, f1);
  pool_.blocks(static_cast<std::int64_t>(near.projected.size()), 256,
               [&](std::int64_t first, std::int64_t last) {
                 for (std::int64_t n = first; n < last; ++n) {
                   if (!alpha && tiles.reach(n).count() == 0) continue;
                   math::Moments<float> moments;
                   if (alpha)
                     moments = compositor_.moments(near.projected, grid, n);
                   else
                     kernels_.gather(near.projected[n], grid, f0, f1, moments);
                   const std::int64_t i = near.number.empty() ? n : near.number[n];
                   chain.add(field.gaussians[i], moments, gradient.data() + 16 * i);
                 }
               });
}

} // namespace innergs
