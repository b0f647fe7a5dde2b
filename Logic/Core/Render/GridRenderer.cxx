#include "Core/Render/GridRenderer.h"

#include "Core/Render/FieldGradient.h"

namespace innergs {

GridRenderer::GridRenderer(SampleGrid grid, const KernelSet& kernels, ThreadPool& pool, ClosedFormPsf psf,
                           Scratch scratch)
    : grid_(std::move(grid)), kernels_(kernels), pool_(pool), psf_(psf), tiles_(view()),
      compositor_(view(), kernels),
      projected_(scratch ? std::move(scratch) : std::make_shared<std::vector<Projected>>()) {}

GridView GridRenderer::view() const {
  return {grid_.nx, grid_.ny, grid_.planes(), grid_.stride(), grid_.z.data()};
}

void GridRenderer::forward(const GaussianField& field, std::span<const float> values, float* weights,
                           float* numerators) {
  const GridView grid = view();
  if (field.blending == Blending::Alpha || kernels_.selection != Selection::Exact)
    project(field, values, grid_, psf_, pool_, *projected_, kernels_.selection);
  else
    projectNear(field, values, grid_, psf_, pool_, *projected_);
  if (field.blending == Blending::Alpha)
    return compositor_.forward(*projected_, grid, pool_, weights, numerators);
  tiles_.bin(*projected_, grid, pool_);
  pool_.run(tiles_.count(), [&](std::int64_t t) {
    const TileRange range = tiles_.range(t, grid);
    for (int k = range.k0; k < range.k1; ++k) {
      const std::size_t first = (static_cast<std::size_t>(k) * grid.ny + range.y0) * grid.stride;
      const std::size_t size = static_cast<std::size_t>(range.y1 - range.y0) * grid.stride;
      std::fill_n(weights + first, size, 0.f);
      std::fill_n(numerators + first, size, 0.f);
    }
    const auto members = tiles_.members(t);
    kernels_.accumulate(projected_->data(), members.data(), members.size(), grid, range, weights, numerators);
  });
}

void GridRenderer::backward(const GaussianField& field, const float* f0, const float* f1,
                            std::span<float> gradient) {
  const GridView grid = view();
  const FieldGradient chain(field, grid_, psf_);
  const bool alpha = field.blending == Blending::Alpha;
  if (alpha) compositor_.backward(*projected_, grid, pool_, f0, f1);
  pool_.blocks(field.size(), 256, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t i = first; i < last; ++i) {
      if (!alpha && tiles_.reach(i).count() == 0) continue;
      math::Moments<float> moments;
      if (alpha)
        moments = compositor_.moments(*projected_, grid, i);
      else
        kernels_.gather((*projected_)[i], grid, f0, f1, moments);
      chain.add(field.gaussians[i], moments, gradient.data() + 16 * i);
    }
  });
}

} // namespace innergs
