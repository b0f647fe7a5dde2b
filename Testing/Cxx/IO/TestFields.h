#pragma once
#include "Core/Model/GaussianField.h"

#include <cstring>
#include <random>

namespace innergs::test {

/// A rotation by `angle` about an axis that is not parallel to the frame's, plus a shift.
inline Affine3 tiltedFrame(double angle) {
  const double c = std::cos(angle), s = std::sin(angle), t = (1 - c) / 3, u = s / std::sqrt(3.0);
  return {{{{{t + c, t - u, t + u}, {t + u, t + c, t - u}, {t - u, t + u, t + c}}}},
          {12.5, -80.0 / 3, 1000.1}};
}

/// Plausible Gaussians with values that use every bit.
inline GaussianField randomField(int count, bool linearIntensity, unsigned seed = 11) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> u(-1, 1);
  GaussianField field;
  field.linearIntensity = linearIntensity;
  field.epsilon = 1e-3 / 3;
  field.cutoff = 2.75;
  field.modelToWorld = tiltedFrame(0.7);
  field.intensityScale = 1234.5678901234567;
  field.intensityOffset = -1024.1;
  field.domain = {{30, 40, 50}, {1.0 / 3, -2.0 / 7, 1e-9}, {0.7, 0.7, 1.0 / 3}, tiltedFrame(0.2).linear};
  for (int n = 0; n < count; ++n) {
    Gaussian g{};
    for (int i = 0; i < 3; ++i) {
      g.mean[i] = 20 * u(random);
      g.logScale[i] = u(random);
      if (linearIntensity) g.slope[i] = 0.05f * u(random);
    }
    for (float& q : g.quaternion)
      q = u(random);
    g.quaternion[0] += 1.5f;
    g.logWeight = 2 * u(random);
    g.intensity = 0.5f + 0.5f * u(random);
    field.gaussians.push_back(g);
  }
  return field;
}

inline bool sameBits(const std::vector<Gaussian>& a, const std::vector<Gaussian>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Gaussian)) == 0);
}

inline void expectSameFrame(const GaussianField& a, const GaussianField& b) {
  EXPECT_EQ(a.blending, b.blending);
  EXPECT_EQ(a.linearIntensity, b.linearIntensity);
  EXPECT_EQ(a.epsilon, b.epsilon);
  EXPECT_EQ(a.cutoff, b.cutoff);
  EXPECT_EQ(a.modelToWorld, b.modelToWorld);
  EXPECT_EQ(a.intensityScale, b.intensityScale);
  EXPECT_EQ(a.intensityOffset, b.intensityOffset);
  EXPECT_EQ(a.domain, b.domain);
}

} // namespace innergs::test
