#include "Core/Fit/Adam.h"
#include "Core/Fit/Relocate.h"
#include "RandomFields.h"

#include <cstring>
#include <gtest/gtest.h>
#include <set>

using namespace innergs;
using namespace innergs::testing;

namespace {

const LearningRates kRates{0.02, 0.03, 0.05, 0.04, 0.01, 0.006};

std::vector<float> randomGradient(std::size_t n, std::uint64_t seed) {
  Numbers random(seed);
  std::vector<float> gradient(n);
  for (float& g : gradient)
    g = static_cast<float>(random(-2, 2));
  return gradient;
}

} // namespace

TEST(Adam, FollowsItsDefinition) {
  GaussianField field = randomField(50, {}, 3);
  for (Gaussian& g : field.gaussians)
    g.reserved = 0;
  Adam adam(50);
  ThreadPool pool(2);
  std::vector<double> x(16 * 50), m(x.size(), 0.0), v(x.size(), 0.0);
  for (std::size_t i = 0; i < x.size(); ++i)
    x[i] = reinterpret_cast<const float*>(field.gaussians.data())[i];
  const double rates[16] = {.02, .02, .02, .03, .03, .03, .05, .05, .05, .05, .04, .01, .006, .006, .006, 0};
  for (int step = 1; step <= 12; ++step) {
    const auto gradient = randomGradient(x.size(), step);
    adam.apply(field, gradient, kRates, {}, step, pool);
    for (std::size_t i = 0; i < x.size(); ++i) {
      m[i] = adam.beta1 * m[i] + (1 - adam.beta1) * gradient[i];
      v[i] = adam.beta2 * v[i] + (1 - adam.beta2) * gradient[i] * gradient[i];
      const double mean = m[i] / (1 - std::pow(adam.beta1, step)),
                   square = v[i] / (1 - std::pow(adam.beta2, step));
      x[i] -= rates[i % 16] * mean / (std::sqrt(square) + 1e-12);
    }
    for (std::size_t i = 0; i < 50; ++i) { // quaternions keep unit length
      double length = 0;
      for (int k = 6; k < 10; ++k)
        length += x[16 * i + k] * x[16 * i + k];
      for (int k = 6; k < 10; ++k)
        x[16 * i + k] /= std::sqrt(length);
    }
    const float* got = reinterpret_cast<const float*>(field.gaussians.data());
    for (std::size_t i = 0; i < x.size(); ++i)
      ASSERT_NEAR(got[i], x[i], 2e-5) << "step " << step << " parameter " << i % 16;
  }
}

TEST(Adam, LeavesWhatHasNoGradientWhereItIs) {
  GaussianField field = randomField(5, {}, 3);
  for (Gaussian& g : field.gaussians) { // already of unit length
    float n = 0;
    for (float q : g.quaternion)
      n += q * q;
    for (float& q : g.quaternion)
      q /= std::sqrt(n);
  }
  const GaussianField before = field;
  Adam adam(5);
  ThreadPool pool(1);
  adam.apply(field, std::vector<float>(80, 0.f), kRates, {}, 1, pool);
  for (int i = 0; i < 80; ++i)
    EXPECT_NEAR(reinterpret_cast<float*>(field.gaussians.data())[i],
                reinterpret_cast<const float*>(before.gaussians.data())[i], 1e-6);
}

TEST(Adam, KeepsTheBounds) {
  GaussianField field = randomField(40, {}, 5);
  FieldBounds bounds;
  bounds.minLogScale = -0.1;
  bounds.maxLogScale = 0.3;
  bounds.minThirdLogScale = 0.2;
  bounds.maxAbsLogWeight = 0.25;
  Adam adam(40);
  ThreadPool pool(2);
  for (int step = 1; step <= 5; ++step)
    adam.apply(field, randomGradient(640, step), {0.1, 0.4, 0.1, 0.5, 0.1, 0.1}, bounds, step, pool);
  bool atLow = false, atHigh = false;
  for (const Gaussian& g : field.gaussians) {
    for (int k = 0; k < 3; ++k) {
      EXPECT_GE(g.logScale[k], static_cast<float>(k == 2 ? 0.2 : -0.1));
      EXPECT_LE(g.logScale[k], 0.3f);
      atLow |= g.logScale[k] == -0.1f;
      atHigh |= g.logScale[k] == 0.3f;
    }
    EXPECT_LE(std::abs(g.logWeight), 0.25f);
  }
  EXPECT_TRUE(atLow && atHigh);
}

TEST(Adam, LeavesSlopesOfAFieldWithoutThemAtZero) {
  GaussianField field = randomField(4, {}, 5, Blending::Normalised, false);
  Adam adam(4);
  ThreadPool pool(1);
  adam.apply(field, randomGradient(64, 1), kRates, {}, 1, pool);
  for (const Gaussian& g : field.gaussians)
    for (float s : g.slope)
      EXPECT_EQ(s, 0.f);
}

TEST(Relocation, KeepsTheCountAndMovesTheLeastUseful) {
  GaussianField field = randomField(200, {}, 9);
  for (int i = 0; i < 10; ++i)
    field.gaussians[7 * i].logWeight = -7.5f; // unused
  Adam adam(200);
  std::fill(adam.moment1.begin(), adam.moment1.end(), 1.f);
  std::fill(adam.moment2.begin(), adam.moment2.end(), 1.f);
  for (int i = 0; i < 10; ++i) {
    adam.moment2[16 * 7 * i + 11] = 1e-6f;            // its intensity has no gradient
    adam.moment2[16 * (7 * i + 3)] = 1e6f + 1e3f * i; // needed
  }
  const GaussianField before = field;
  relocateGaussians(field, adam, {0.05, -10});
  ASSERT_EQ(field.size(), 200);
  ASSERT_EQ(adam.moment1.size(), 3200u);
  ASSERT_EQ(adam.moment2.size(), 3200u);
  int useless = 0, fresh = 0;
  std::multiset<float> left;
  for (int i = 0; i < 200; ++i) {
    useless += field.gaussians[i].logWeight == -7.5f;
    left.insert(field.gaussians[i].mean[0]);
    const bool zero = adam.moment1[16 * i] == 0;
    for (int p = 0; p < 16; ++p) {
      EXPECT_EQ(adam.moment1[16 * i + p], zero ? 0.f : 1.f);
      EXPECT_EQ(adam.moment2[16 * i + p], zero ? 0.f : 1.f);
    }
    fresh += zero;
  }
  EXPECT_EQ(useless, 0);
  EXPECT_EQ(fresh, 20); // both halves of every split
  int untouched = 0;
  for (int i = 0; i < 200; ++i)
    untouched += left.count(before.gaussians[i].mean[0]) == 1;
  EXPECT_EQ(untouched, 180);
}

TEST(Relocation, OfNothingChangesNothing) {
  GaussianField field = randomField(20, {}, 9);
  const GaussianField before = field;
  Adam adam(20);
  relocateGaussians(field, adam, {0.02, -10}); // 2 % of 20: none
  EXPECT_EQ(std::memcmp(field.gaussians.data(), before.gaussians.data(), 20 * sizeof(Gaussian)), 0);
}
