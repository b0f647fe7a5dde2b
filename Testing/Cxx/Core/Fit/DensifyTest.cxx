#include "Core/Fit/Densify.h"
#include "Core/Render/Render.h"
#include "RandomFields.h"
#include "TestVolumes.h"

#include <algorithm>
#include <cstring>
#include <gtest/gtest.h>

using namespace innergs;
using namespace innergs::testing;

namespace {

constexpr int kCount = 100;

/// Gaussians on a line, σ = 1 mm, with full opacity; the intensity identifies them.
GaussianField lineOf(Blending blending, int count = kCount) {
  GaussianField field;
  field.blending = blending;
  for (int i = 0; i < count; ++i) {
    Gaussian g{};
    g.mean[0] = static_cast<float>(i);
    g.quaternion[0] = 1;
    g.logWeight = blending == Blending::Alpha ? 3.f : 0.f;
    g.intensity = 1 + static_cast<float>(i);
    field.gaussians.push_back(g);
  }
  return field;
}

/// Moments that identify their Gaussian.
Adam namedMoments(int count = kCount) {
  Adam adam(count);
  for (std::size_t i = 0; i < adam.moment1.size(); ++i) {
    adam.moment1[i] = static_cast<float>(1 + i / 16);
    adam.moment2[i] = static_cast<float>(1 + i / 16);
  }
  return adam;
}

DensifyPlan planOf(std::int64_t limit = kCount) {
  DensifyPlan plan;
  plan.every = 1;
  plan.thresholds = {0.01, 5, 1.0, 3.0};
  plan.limit = limit;
  return plan;
}

GradientAccumulator accumulatorOf(int count = kCount) {
  GradientAccumulator accumulator;
  accumulator.sum.assign(count, 0.f);
  accumulator.iterations = 4;
  return accumulator;
}

} // namespace

class Densification : public ::testing::TestWithParam<Blending> {};

TEST_P(Densification, PrunesTheFaintAndTheLarge) {
  GaussianField field = lineOf(GetParam());
  for (int i = 0; i < 10; ++i) {
    Gaussian& g = field.gaussians[3 * i];
    if (GetParam() == Blending::Additive)
      g.intensity = 0.009f;
    else
      g.logWeight = std::log(0.009f);
  }
  for (int i = 0; i < 5; ++i)
    field.gaussians[3 * i + 1].logScale[1] = std::log(5.1f);
  field.gaussians[50].logScale[2] = std::log(4.9f);
  Adam adam = namedMoments();
  GradientAccumulator accumulator = accumulatorOf();
  const DensifyCounts counts = densifyGaussians(field, adam, accumulator, planOf());
  EXPECT_EQ(counts.pruned, 15);
  EXPECT_EQ(counts.split + counts.cloned, 0);
  ASSERT_EQ(field.size(), 85);
  ASSERT_EQ(adam.moment1.size(), 16u * 85);
  ASSERT_EQ(adam.moment2.size(), 16u * 85);
  for (int i = 0; i < 85; ++i) { // Adam's state moved along
    EXPECT_EQ(adam.moment1[16 * i + 4], field.gaussians[i].intensity);
    EXPECT_EQ(adam.moment2[16 * i + 15], field.gaussians[i].intensity);
    EXPECT_GT(field.gaussians[i].intensity, 1.f);
    EXPECT_LE(field.gaussians[i].logScale[1], std::log(5.f));
  }
  EXPECT_TRUE(accumulator.sum.empty());
  EXPECT_EQ(accumulator.iterations, 0);
}

TEST_P(Densification, SplitsLargeAndClonesSmallOnesThatArePulled) {
  GaussianField field = lineOf(GetParam());
  GradientAccumulator accumulator = accumulatorOf();
  for (int i = 0; i < 6; ++i) {
    accumulator.sum[10 + i] = 4.1f;                      // mean of four iterations just above 1
    field.gaussians[10 + i].logScale[0] = std::log(2.f); // ‖Σ‖_F = √18
    accumulator.sum[40 + 2 * i] = 4.1f;                  // ‖Σ‖_F = √3
    accumulator.sum[70 + i] = 3.9f;
  }
  Adam adam = namedMoments();
  const DensifyCounts counts = densifyGaussians(field, adam, accumulator, planOf(1000));
  EXPECT_EQ(counts.pruned, 0);
  EXPECT_EQ(counts.split, 6);
  EXPECT_EQ(counts.cloned, 6);
  ASSERT_EQ(field.size(), kCount + 12);
  int fresh = 0;
  for (int i = 0; i < field.size(); ++i) {
    const Gaussian& g = field.gaussians[i];
    const int name = static_cast<int>(g.intensity) - 1;
    const bool split = name >= 10 && name < 16, cloned = name >= 40 && name <= 50 && name % 2 == 0;
    const float moment = adam.moment1[16 * i];
    EXPECT_TRUE(moment == 0 || moment == g.intensity);
    if (!cloned) {
      EXPECT_EQ(moment == 0, split) << name;
    }
    if (split) {
      EXPECT_NEAR(g.logScale[0], std::log(1.4f), 1e-6);
      EXPECT_NEAR(std::abs(g.mean[0] - static_cast<float>(name)), 1.2f, 1e-5);
    }
    if (cloned && moment == 0) { // along −∇μ, which is (−1, −1, −1)/√3, by σ/2
      EXPECT_NEAR(g.mean[1], -0.5 / std::sqrt(3.0), 1e-5);
    }
    fresh += moment == 0;
  }
  EXPECT_EQ(fresh, 2 * 6 + 6);
}

TEST_P(Densification, StaysWithinTheLimitAndTakesTheHardestPulled) {
  GaussianField field = lineOf(GetParam());
  GradientAccumulator accumulator = accumulatorOf();
  for (int i = 0; i < kCount; ++i)
    accumulator.sum[i] = 5.f + static_cast<float>((i * 37) % kCount);
  field.gaussians[0].logScale[0] = std::log(6.f); // pruned: room for one more
  Adam adam = namedMoments();
  const DensifyCounts counts = densifyGaussians(field, adam, accumulator, planOf(kCount + 9));
  EXPECT_EQ(counts.pruned, 1);
  EXPECT_EQ(counts.cloned, 10);
  ASSERT_EQ(field.size(), kCount + 9);
  std::vector<int> copies(kCount, 0);
  for (const Gaussian& g : field.gaussians)
    ++copies[static_cast<int>(g.intensity) - 1];
  for (int i = 1; i < kCount; ++i)
    EXPECT_EQ(copies[i], (i * 37) % kCount >= kCount - 10 ? 2 : 1) << i;
}

TEST_P(Densification, OfACloneBlendsAsTheOneDid) {
  for (const float weight : {-3.f, 0.f, 2.f}) {
    GaussianField field = lineOf(GetParam(), 1);
    field.gaussians[0].logWeight = weight;
    field.gaussians[0].intensity = 0.7f;
    field.epsilon = 0.1; // makes the normalised weight visible
    const GridGeometry point = grid(1, 1, 1);
    const float before = render(field, point).voxels[0];
    Adam adam(1); // no gradient yet: the copy stays in place
    GradientAccumulator accumulator = accumulatorOf(1);
    accumulator.sum[0] = 100;
    EXPECT_EQ(densifyGaussians(field, adam, accumulator, planOf()).cloned, 1);
    // The field's p is the exponential minus its value at the cut-off, which α squares.
    EXPECT_NEAR(render(field, point).voxels[0], before, 0.01 * before) << weight;
  }
}

TEST_P(Densification, OfNothingChangesNothingAndNeverEmptiesAField) {
  GaussianField field = lineOf(GetParam());
  const GaussianField before = field;
  Adam adam = namedMoments();
  GradientAccumulator accumulator = accumulatorOf();
  const DensifyCounts none = densifyGaussians(field, adam, accumulator, planOf());
  EXPECT_EQ(none.pruned + none.split + none.cloned, 0);
  EXPECT_EQ(std::memcmp(field.gaussians.data(), before.gaussians.data(), kCount * sizeof(Gaussian)), 0);
  DensifyPlan strict = planOf();
  strict.thresholds.size = 0.5;
  EXPECT_EQ(densifyGaussians(field, adam, accumulator, strict).pruned, 0);
  EXPECT_EQ(field.size(), kCount);
}

INSTANTIATE_TEST_SUITE_P(Blendings, Densification,
                         ::testing::Values(Blending::Normalised, Blending::Additive, Blending::Alpha),
                         [](const auto& info) {
                           std::string name = blendingName(info.param);
                           name[0] = static_cast<char>(std::toupper(name[0]));
                           return name;
                         });

TEST(GradientAccumulator, IsTheLossOfOneVoxelsMoveForAnyNumberOfThreads) {
  Numbers random(5);
  constexpr int n = 40000;
  std::vector<float> gradient(16 * n);
  for (float& g : gradient)
    g = static_cast<float>(random(-1, 1));
  DensifyPlan plan;
  plan.voxel = 0.5;
  plan.coverage = 3;
  std::vector<float> first;
  for (int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    GradientAccumulator accumulator;
    accumulator.add(gradient, plan, pool);
    accumulator.add(gradient, plan, pool);
    EXPECT_EQ(accumulator.iterations, 2);
    ASSERT_EQ(accumulator.sum.size(), static_cast<std::size_t>(n));
    if (first.empty()) first = accumulator.sum;
    EXPECT_EQ(accumulator.sum, first);
  }
  for (int i = 0; i < n; i += 999) {
    const float* g = gradient.data() + 16 * i;
    EXPECT_NEAR(first[i], 2 * 0.5 / 3 * std::sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]), 1e-5);
  }
}
