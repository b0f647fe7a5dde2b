#include "Core/Render/LatticeRenderer.h"

#include "Core/Render/FieldGradient.h"

namespace innergs {

LatticeRenderer::LatticeRenderer(Lattice lattice, const KernelSet& kernels, ThreadPool& pool,
                                 ClosedFormPsf psf, Scratch scratch)
    : lattice_(std::move(lattice)), kernels_(kernels), pool_(pool), psf_(psf), tiles_(view()),
      compositor_(view(), kernels),
      projected_(scratch ? std::move(scratch) : std::make_shared<std::vector<Projected>>()) {}

LatticeView LatticeRenderer::view() const {
  return {lattice_.nx, lattice_.ny, lattice_.planes(), lattice_.stride(), lattice_.z.data()};
}

void LatticeRenderer::forward(const GaussianField& field, std::span<const float> values, float* weights,
                              float* numerators) {
  const LatticeView lattice = view();
  if (field.blending == Blending::Alpha || kernels_.selection != Selection::Exact)
    project(field, values, lattice_, psf_, pool_, *projected_, kernels_.selection);
  else
    projectNear(field, values, lattice_, psf_, pool_, *projected_);
  if (field.blending == Blending::Alpha)
    return compositor_.forward(*projected_, lattice, pool_, weights, numerators);
  tiles_.bin(*projected_, lattice, pool_);
  pool_.run(tiles_.count(), [&](std::int64_t t) {
    const TileRange range = tiles_.range(t, lattice);
    for (int k = range.k0; k < range.k1; ++k) {
      const std::size_t first = (static_cast<std::size_t>(k) * lattice.ny + range.y0) * lattice.stride;
      const std::size_t size = static_cast<std::size_t>(range.y1 - range.y0) * lattice.stride;
      std::fill_n(weights + first, size, 0.f);
      std::fill_n(numerators + first, size, 0.f);
    }
    const auto members = tiles_.members(t);
    kernels_.accumulate(projected_->data(), members.data(), members.size(), lattice, range, weights,
                        numerators);
  });
}

void LatticeRenderer::backward(const GaussianField& field, const float* f0, const float* f1,
                               std::span<float> gradient) {
  const LatticeView lattice = view();
  const FieldGradient chain(field, lattice_, psf_);
  const bool alpha = field.blending == Blending::Alpha;
  if (alpha) compositor_.backward(*projected_, lattice, pool_, f0, f1);
  pool_.blocks(field.size(), 256, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t i = first; i < last; ++i) {
      if (!alpha && tiles_.reach(i).count() == 0) continue;
      math::Moments<float> moments;
      if (alpha)
        moments = compositor_.moments(*projected_, lattice, i);
      else
        kernels_.gather((*projected_)[i], lattice, f0, f1, moments);
      chain.add(field.gaussians[i], moments, gradient.data() + 16 * i);
    }
  });
}

} // namespace innergs
