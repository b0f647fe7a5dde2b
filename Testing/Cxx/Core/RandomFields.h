#pragma once
#include "Core/Model/GaussianField.h"

#include <cmath>
#include <cstring>
#include <random>

namespace innergs::testing {

/// The same numbers on every platform.
class Numbers {
public:
  explicit Numbers(std::uint64_t seed) : engine_(seed) {}
  double operator()(double low, double high) {
    return low + (high - low) * (static_cast<double>(engine_() >> 11) * 0x1p-53);
  }
  std::uint64_t bits() { return engine_(); }

private:
  std::mt19937_64 engine_;
};

/// Range of random Gaussians: a box in model coordinates (mm), σ (mm) and the ratio of their axes.
struct Cloud {
  Vec3 low{-6, -6, -6}, high{6, 6, 6};
  double minSigma = 0.8, maxSigma = 2.5, anisotropy = 3;
  double maxLogWeight = 0.7, maxSlope = 0.08;
};

inline Gaussian randomGaussian(Numbers& random, const Cloud& cloud) {
  Gaussian g{};
  const double sigma = std::exp(random(std::log(cloud.minSigma), std::log(cloud.maxSigma)));
  const double stretch = 0.5 * std::log(cloud.anisotropy);
  for (int a = 0; a < 3; ++a) {
    g.mean[a] = static_cast<float>(random(cloud.low[a], cloud.high[a]));
    g.logScale[a] = static_cast<float>(std::log(sigma) + random(-stretch, stretch));
    g.slope[a] = static_cast<float>(random(-cloud.maxSlope, cloud.maxSlope));
  }
  for (float& q : g.quaternion)
    q = static_cast<float>(random(-1, 1));
  g.logWeight = static_cast<float>(random(-cloud.maxLogWeight, cloud.maxLogWeight));
  g.intensity = static_cast<float>(random(0, 1));
  return g;
}

inline GaussianField randomField(int gaussians, const Cloud& cloud, std::uint64_t seed,
                                 Blending blending = Blending::Normalised, bool linear = true) {
  Numbers random(seed);
  GaussianField field;
  field.blending = blending;
  field.linearIntensity = linear;
  for (int i = 0; i < gaussians; ++i) {
    field.gaussians.push_back(randomGaussian(random, cloud));
    if (!linear) std::fill_n(field.gaussians.back().slope, 3, 0.f);
  }
  return field;
}

/// Bit for bit.
inline bool sameGaussians(const GaussianField& a, const GaussianField& b) {
  return a.size() == b.size() &&
         std::memcmp(a.gaussians.data(), b.gaussians.data(), a.size() * sizeof(Gaussian)) == 0;
}

} // namespace innergs::testing
