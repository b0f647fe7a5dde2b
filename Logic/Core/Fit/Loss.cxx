#include "Core/Fit/Loss.h"

#include "Core/Fit/LossSsim.h"
#include "Core/Fit/PointLoss.h"
#include "Core/Render/SliceComposition.h"

namespace innergs {

LossSum lossPass(const Observation& o, const GaussianField& field, const LossKinds& kinds, float* weights,
                 float* numerators, ThreadPool& pool) {
  const std::size_t n = o.sliceSize();
  const float epsilon = static_cast<float>(field.epsilon), delta = static_cast<float>(kinds.huberDelta),
              pointWeight = static_cast<float>(kinds.pointWeight);
  const bool normalised = field.blending == Blending::Normalised, alpha = field.blending == Blending::Alpha;
  std::vector<LossSum> sums(o.slices);
  pool.run(o.slices, [&](std::int64_t s) {
    static thread_local std::vector<float> image, r;
    image.resize(n);
    r.resize(n);
    composeSlice(o, static_cast<int>(s), weights, numerators, field, image.data());
    const float* target = o.target.data() + s * n;
    const std::uint8_t* observed = o.weight.data() + s * n;
    LossSum sum;
    for (int y = 0; y < o.grid.ny; ++y) {
      const std::size_t row = static_cast<std::size_t>(y) * o.grid.stride();
      float loss = 0, squared = 0;
      int count = 0;
      for (std::size_t i = row; i < row + o.grid.stride(); ++i) {
        const float mask = observed[i] ? 1.f : 0.f, e = mask * (image[i] - target[i]);
        loss += pointLoss(kinds.kind, delta, e, r[i]);
        r[i] *= pointWeight;
        squared += e * e;
        count += observed[i] ? 1 : 0;
      }
      sum.loss += pointWeight * loss;
      sum.squared += squared;
      sum.samples += count;
    }
    if (kinds.ssimWeight > 0)
      sum.loss += addSsimLoss(image.data(), target, observed, o.grid.nx, o.grid.ny, o.grid.stride(),
                              kinds.ssimWeight, r.data());
    for (int q = 0; q < o.perSlice; ++q) {
      const auto [plane, share] = o.subPlanes[static_cast<std::size_t>(s) * o.perSlice + q];
      float* w = weights + plane * n;
      float* c = numerators + plane * n;
      for (std::size_t i = 0; i < n; ++i) {
        const float inverse = normalised ? 1 / (w[i] + epsilon) : 1.f;
        const float value = c[i] * inverse, f0 = share * r[i] * inverse;
        w[i] = f0;
        c[i] = normalised ? -f0 * value : alpha ? value : 0.f;
      }
    }
    sums[s] = sum;
  });
  LossSum total;
  for (const LossSum& s : sums)
    total += s;
  return total;
}

} // namespace innergs
