// What networks compute beside products, and their optimiser. Included once per instruction set (Highway).
#if defined(INNERGS_SIMD_LAYERS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef INNERGS_SIMD_LAYERS_INL_H
#undef INNERGS_SIMD_LAYERS_INL_H
#else
#define INNERGS_SIMD_LAYERS_INL_H
#endif

#include "Core/Prediction/NetworkKernels.h"
#include "Core/Prediction/SimdLanes-inl.h"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace innergs::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void activate(std::int64_t samples, int channels, const float* biases, float leak, float* values) {
  withLanes(channels, [&](auto d) HWY_ATTR {
    const auto lanes = static_cast<int>(hn::Lanes(d));
    const auto slope = hn::Set(d, leak);
    float* at = values;
    for (std::int64_t s = 0; s < samples; ++s, at += channels)
      for (int c = 0; c < channels; c += lanes) {
        const auto sum = hn::Add(hn::LoadU(d, at + c), hn::LoadU(d, biases + c));
        hn::StoreU(hn::Max(sum, hn::Mul(slope, sum)), d, at + c);
      }
  });
}

void activateBack(std::int64_t samples, int channels, const float* activated, float leak, float* gradient) {
  withLanes(channels, [&](auto d) HWY_ATTR {
    const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
    const auto slope = hn::Set(d, leak), zero = hn::Zero(d);
    for (std::int64_t i = 0; i < samples * channels; i += lanes) {
      const auto g = hn::LoadU(d, gradient + i);
      hn::StoreU(hn::IfThenElse(hn::Gt(hn::LoadU(d, activated + i), zero), g, hn::Mul(slope, g)), d,
                 gradient + i);
    }
  });
}

void addSums(std::int64_t samples, int channels, const float* values, float* sums) {
  withLanes(channels, [&](auto d) HWY_ATTR {
    const auto lanes = static_cast<int>(hn::Lanes(d));
    for (int c = 0; c < channels; c += lanes) {
      auto sum = hn::LoadU(d, sums + c);
      for (std::int64_t s = 0; s < samples; ++s)
        sum = hn::Add(sum, hn::LoadU(d, values + s * channels + c));
      hn::StoreU(sum, d, sums + c);
    }
  });
}

void adam(const AdamScalars& s, std::int64_t count, const float* gradient, float* moment1, float* moment2,
          float* parameters) {
  withLanes(count, [&](auto d) HWY_ATTR {
    const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
    const auto beta1 = hn::Set(d, s.beta1), beta2 = hn::Set(d, s.beta2), new1 = hn::Set(d, 1 - s.beta1),
               new2 = hn::Set(d, 1 - s.beta2), scale2 = hn::Set(d, s.scale2), rate = hn::Set(d, s.rate),
               tiny = hn::Set(d, 1e-8f);
    for (std::int64_t i = 0; i < count; i += lanes) {
      const auto g = hn::LoadU(d, gradient + i);
      const auto m1 = hn::MulAdd(beta1, hn::LoadU(d, moment1 + i), hn::Mul(new1, g));
      const auto m2 = hn::MulAdd(beta2, hn::LoadU(d, moment2 + i), hn::Mul(new2, hn::Mul(g, g)));
      hn::StoreU(m1, d, moment1 + i);
      hn::StoreU(m2, d, moment2 + i);
      const auto change = hn::Div(hn::Mul(rate, m1), hn::Add(hn::Sqrt(hn::Mul(m2, scale2)), tiny));
      hn::StoreU(hn::Sub(hn::LoadU(d, parameters + i), change), d, parameters + i);
    }
  });
}

} // namespace innergs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
