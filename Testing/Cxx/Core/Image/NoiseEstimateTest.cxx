#include "Core/Image/NoiseEstimate.h"
#include "Core/Image/Metrics.h"
#include "Core/Image/Simulate.h"
#include "TestVolumes.h"

#include <gtest/gtest.h>

using namespace innergs;
using namespace innergs::testing;

TEST(NoiseEstimate, FindsWhiteNoiseInAConstantImage) {
  const Volume flat = volumeOf(grid(64, 64, 8), [](auto, auto, auto) { return 100; });
  for (const double sigma : {0.5, 3.0, 20.0})
    EXPECT_NEAR(estimateNoise(simulateThickStack(flat, 2, 1, sigma, 5).image), sigma, 0.04 * sigma);
}

TEST(NoiseEstimate, StructureAndZeroedBackgroundDoNotCount) {
  const Volume truth = phantom(grid(96, 96, 24));
  for (const double sigma : {2.0, 6.0, 15.0}) {
    Volume noisy = simulateThickStack(truth, 2, 1, sigma, 5).image;
    for (std::size_t p = 0; p < noisy.voxels.size(); ++p)
      if (truth.voxels[p] == 0) noisy.voxels[p] = 0;
    EXPECT_NEAR(estimateNoise(noisy), sigma, 0.1 * sigma);
    for (float& v : noisy.voxels)
      v = std::round(v);
    EXPECT_NEAR(estimateNoise(noisy), std::sqrt(sigma * sigma + 1.0 / 12), 0.1 * sigma);
  }
}

TEST(NoiseEstimate, CoarseQuantisationDoesNotCollapseToZero) {
  const Volume flat =
      volumeOf(grid(64, 64, 16), [](auto i, auto j, auto) { return 100 + 0.05 * double(i + j); });
  Volume noisy = simulateThickStack(flat, 2, 1, 0.5, 5).image;
  for (float& v : noisy.voxels)
    v = std::round(v);
  EXPECT_NEAR(estimateNoise(noisy), std::sqrt(0.25 + 1.0 / 12),
              0.12); // a fifth: steps are as large as the noise
}

TEST(NoiseEstimate, UsesInPlaneDifferencesOnly) {
  // Slices that differ strongly from each other, like thick slices, each of them smooth.
  const Volume truth = volumeOf(grid(64, 64, 12), [](auto i, auto j, auto k) {
    return 100 + 80 * ((k * 7) % 3) + 0.2 * double(i) + 0.1 * double(j);
  });
  EXPECT_NEAR(estimateNoise(simulateThickStack(truth, 2, 1, 4, 5).image), 4, 0.3);
}

TEST(NoiseEstimate, MaskChoosesTheSamples) {
  const Volume flat = volumeOf(grid(64, 64, 8), [](auto, auto, auto) { return 100; });
  Volume two = simulateThickStack(flat, 2, 1, 2, 5).image;
  const Volume loud = simulateThickStack(flat, 2, 1, 10, 6).image;
  std::vector<std::uint8_t> mask(two.voxels.size(), 0);
  for (std::size_t p = 0; p < two.voxels.size(); ++p) {
    if (p % 64 < 32) two.voxels[p] = loud.voxels[p];
    mask[p] = p % 64 > 33;
  }
  EXPECT_NEAR(estimateNoise(two, mask), 2, 0.2);
}

TEST(NoiseEstimate, IsZeroWithoutNoise) {
  EXPECT_EQ(estimateNoise(volumeOf(grid(16, 16, 4), [](auto, auto, auto) { return 7; })), 0);
  EXPECT_EQ(estimateNoise(volumeOf(grid(2, 16, 4), [](auto i, auto, auto) { return i; })), 0);
}

TEST(NoiseEstimate, LabelsHaveNone) {
  const auto ball = [](double x, double y, double z, double r) { return x * x + y * y + z * z < r * r; };
  const Volume binary = volumeOf(grid(40, 40, 20), [&](auto i, auto j, auto k) {
    return ball(double(i) - 20, double(j) - 20, double(k) - 10, 3);
  });
  EXPECT_EQ(estimateNoise(binary), 0);
  const Volume labels = volumeOf(grid(40, 40, 20), [&](auto i, auto j, auto k) {
    return ball(double(i) - 12, double(j) - 20, double(k) - 10, 8)   ? 7
           : ball(double(i) - 28, double(j) - 20, double(k) - 10, 8) ? 12
                                                                     : 0;
  });
  EXPECT_EQ(estimateNoise(labels), 0);
  std::vector<std::uint8_t> mask;
  for (const float v : labels.voxels)
    mask.push_back(v > 0);
  EXPECT_EQ(estimateNoise(labels, mask), 0);
}

TEST(NoiseEstimate, OfAFewVoxelsIsThatOfTheScan) {
  const Volume flat = volumeOf(grid(64, 64, 8), [](auto, auto, auto) { return 100; });
  const Volume noisy = simulateThickStack(flat, 2, 1, 5, 5).image;
  std::vector<std::uint8_t> mask(noisy.voxels.size(), 0);
  mask[20 + 64 * (20 + 64 * 4)] = 1;
  EXPECT_NEAR(estimateNoise(noisy, mask), 5, 0.2);
}

TEST(NoiseEstimate, TextureIsNone) {
  const Volume plain = texture(grid(96, 96, 12));
  const double detail = estimateFineDetail(plain);
  EXPECT_LT(estimateNoise(plain), 0.5 * detail);
  const double sigma = 6;
  const Volume noisy = simulateThickStack(plain, 2, 1, sigma, 5).image;
  EXPECT_NEAR(estimateNoise(noisy), sigma, 0.1 * sigma);
  EXPECT_GE(estimateFineDetail(noisy), estimateNoise(noisy));
}

TEST(NoiseEstimate, OfSmoothImagesIsZeroButTheirDetailIsNot) {
  const Volume smooth = volumeOf(grid(64, 64, 4), [](auto i, auto j, auto) {
    return 100 + 50 * std::sin(0.2 * double(i)) * std::cos(0.25 * double(j));
  });
  EXPECT_EQ(estimateNoise(smooth), 0);
  EXPECT_GT(estimateFineDetail(smooth), 0);
}

TEST(NoiseEstimate, MetalDoesNotHideTheNoise) {
  Volume flat = volumeOf(grid(64, 64, 8), [](auto i, auto j, auto) {
    return i < 3 && j < 6 ? 8000 : i < 32 ? 0 : 100;
  });
  EXPECT_NEAR(estimateNoise(simulateThickStack(flat, 2, 1, 5, 5).image), 5, 0.3);
}

TEST(NoiseEstimate, SlicesShareDetailWhereTheyAreSmoothAcross) {
  const Volume flat = volumeOf(grid(64, 64, 24), [](auto, auto, auto) { return 100; });
  const Volume noisy = simulateThickStack(flat, 2, 1, 5, 5).image;
  EXPECT_NEAR(ownShareOfDetail(noisy), 1, 0.05);
  Volume smooth = noisy; // [1 4 6 4 1]/16 across
  const std::size_t plane = 64 * 64;
  for (std::size_t v = 2 * plane; v + 2 * plane < noisy.voxels.size(); ++v) {
    const float* x = noisy.voxels.data() + v;
    smooth.voxels[v] = (x[-2 * std::ptrdiff_t(plane)] + x[2 * plane] +
                        4 * (x[-std::ptrdiff_t(plane)] + x[plane]) + 6 * x[0]) /
                       16;
  }
  EXPECT_LT(ownShareOfDetail(smooth), 0.35);
  // Slices that are not observed say nothing.
  std::vector<std::uint8_t> everyOther(noisy.voxels.size());
  for (std::size_t v = 0; v < everyOther.size(); ++v)
    everyOther[v] = v / plane % 2 == 0;
  EXPECT_EQ(ownShareOfDetail(smooth, everyOther), 1);
}
