#include "Evaluation/SliceInterpolation.h"

#include "../Core/TestVolumes.h"

#include <gtest/gtest.h>

using namespace innergs;
using namespace innergs::testing;

namespace {

double apply(const std::vector<std::int64_t>& kept, std::int64_t target, Interpolation kind, auto&& value) {
  const auto weights = sliceWeights(kept, target, kind);
  double sum = 0;
  for (std::size_t k = 0; k < kept.size(); ++k)
    sum += weights[k] * value(double(kept[k]));
  return sum;
}

} // namespace

TEST(SliceInterpolation, WeightsReproduceConstantsAndRamps) {
  const std::vector<std::int64_t> kept{0, 1, 2, 4, 5, 8, 9, 10, 12};
  for (const std::int64_t target : {3, 6, 7, 11}) {
    for (const auto kind : {Interpolation::Linear, Interpolation::Cubic, Interpolation::Lanczos})
      EXPECT_NEAR(apply(kept, target, kind, [](double) { return 1; }), 1, 1e-12);
    for (const auto kind : {Interpolation::Linear, Interpolation::Cubic})
      EXPECT_NEAR(apply(kept, target, kind, [](double x) { return 3 * x - 2; }), 3.0 * double(target) - 2,
                  1e-10);
  }
}

// The natural spline through x³ − (end conditions violated) is checked against its own definition: C² and
// interpolating.
TEST(SliceInterpolation, CubicIsTheNaturalSpline) {
  // Three knots 0, 2, 3 with values 0, 1, 0: M₁ (h₀+h₁)/3 = (0−1)/1 − (1−0)/2 → M₁ = −1.5; s(1) = ½ + (⅛ −
  // ½)·4·M₁/6.
  const std::vector<std::int64_t> kept{0, 2, 3};
  const auto weights = sliceWeights(kept, 1, Interpolation::Cubic);
  EXPECT_NEAR(weights[1], 0.5 + (0.125 - 0.5) * 4 * -1.5 / 6, 1e-12);
  // Far from the ends, a smooth function is reproduced to spline accuracy.
  std::vector<std::int64_t> many;
  for (std::int64_t k = 0; k < 60; ++k)
    if (k != 30) many.push_back(k);
  EXPECT_NEAR(apply(many, 30, Interpolation::Cubic, [](double x) { return std::sin(0.3 * x); }),
              std::sin(9.0), 1e-3);
}

TEST(SliceInterpolation, BeyondTheEndsTheLastSliceStays) {
  const std::vector<std::int64_t> kept{2, 3, 5};
  for (const auto kind : {Interpolation::Linear, Interpolation::Cubic, Interpolation::Lanczos}) {
    EXPECT_EQ(sliceWeights(kept, 0, kind), (std::vector<double>{1, 0, 0}));
    EXPECT_EQ(sliceWeights(kept, 7, kind), (std::vector<double>{0, 0, 1}));
  }
}

TEST(SliceInterpolation, NeverLooksAtHeldOutSlices) {
  const Volume truth = randomVolume(grid(10, 11, 12), 0, 100);
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<std::int64_t> heldOut{0, 4, 5};
    Volume other = truth;
    const std::int64_t stride[3] = {1, 10, 110};
    for (std::size_t p = 0; p < other.voxels.size(); ++p) {
      const auto slice = static_cast<std::int64_t>(p) / stride[axis] % truth.geometry.size[axis];
      if (slice == 0 || slice == 4 || slice == 5) other.voxels[p] = -1e6f;
    }
    for (const auto kind : {Interpolation::Linear, Interpolation::Cubic, Interpolation::Lanczos}) {
      const Volume result = interpolateSlices(other, axis, heldOut, kind);
      EXPECT_EQ(result.voxels, interpolateSlices(truth, axis, heldOut, kind).voxels);
      for (std::size_t p = 0; p < result.voxels.size(); ++p)
        ASSERT_GT(result.voxels[p], -200);
    }
  }
}
