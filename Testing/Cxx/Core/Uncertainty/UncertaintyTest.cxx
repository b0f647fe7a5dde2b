#include "../Alignment/HeadPhantom.h"
#include "Core/Image/Simulate.h"
#include "Core/Job/ReconstructionJob.h"
#include "Core/Uncertainty/ErrorCurve.h"

#include <cmath>
#include <gtest/gtest.h>

namespace innergs {
namespace {

constexpr std::int64_t kWidth = 56;

Settings quick() {
  Settings settings;
  settings.preset = Preset::Fast;
  settings.sliceMotion = SliceMotionKind::Off;
  settings.align = false;
  settings.threads = 2;
  return settings;
}

/// Two scans of 4 mm slices at right angles.
ReconstructionInput scansOf(const Volume& truth, double noise) {
  ReconstructionInput input;
  for (int s = 0; s < 2; ++s)
    input.stacks.push_back(simulateThickStack(truth, 2 - s, 4, noise, static_cast<std::uint64_t>(s) + 1));
  input.outputGrid = truth.geometry;
  input.uncertainty = true;
  return input;
}

/// The share of the truth's voxels in their 90 % intervals, 6 voxels inside.
double coverage(const ReconstructionResult& result, const Volume& truth) {
  std::int64_t held = 0, count = 0;
  for (std::int64_t k = 6; k < kWidth - 6; ++k)
    for (std::int64_t j = 6; j < kWidth - 6; ++j)
      for (std::int64_t i = 6; i < kWidth - 6; ++i) {
        const std::size_t v = i + kWidth * (j + kWidth * k);
        held += std::abs(result.volume.voxels[v] - truth.voxels[v]) <=
                kNinety * result.uncertainty->deviation.voxels[v];
        ++count;
      }
  return static_cast<double>(held) / static_cast<double>(count);
}

/// Waves without an edge anywhere.
Volume smooth() {
  Volume volume = testing::headPhantom(kWidth);
  for (std::int64_t v = 0; v < volume.geometry.voxelCount(); ++v) {
    const double x = static_cast<double>(v % kWidth), y = static_cast<double>(v / kWidth % kWidth),
                 z = static_cast<double>(v / (kWidth * kWidth));
    volume.voxels[static_cast<std::size_t>(v)] = static_cast<float>(
        500 + 100 * std::sin(x / 4 + y / 9) + 100 * std::cos(y / 5 - z / 7) + 80 * std::sin(z / 4 + x / 11));
  }
  return volume;
}

TEST(Uncertainty, HoldsTheTruthOfEdgesWavesAndNoise) {
  struct Case {
    const char* name;
    Volume truth;
    double noise;
  };
  const Case cases[] = {{"edges", testing::headPhantom(kWidth), 5},
                        {"noisy edges", testing::headPhantom(kWidth), 40},
                        {"waves", smooth(), 10}};
  for (const Case& c : cases) {
    const ReconstructionResult result = ReconstructionJob(scansOf(c.truth, c.noise), quick()).run();
    ASSERT_TRUE(result.uncertainty) << c.name;
    const Uncertainty& u = *result.uncertainty;
    EXPECT_EQ(u.deviation.geometry, result.volume.geometry);
    EXPECT_EQ(u.measured.size(), result.volume.voxels.size());
    EXPECT_GT(u.coverage, 0.85) << c.name;
    EXPECT_LT(u.coverage, 0.95) << c.name;
    EXPECT_EQ(result.judging, Judging::Done);
    const double held = coverage(result, c.truth);
    EXPECT_GT(held, 0.85) << c.name << ", noise " << u.noise << " of " << c.noise;
    EXPECT_LT(held, 0.95) << c.name << ", noise " << u.noise << " of " << c.noise;
    EXPECT_FALSE(uncertaintySentence(u).empty());
  }
}

TEST(Uncertainty, IsTheSameForAnyNumberOfThreads) {
  const Volume truth = testing::headPhantom(kWidth);
  Settings settings = quick();
  settings.iterations = 4;
  settings.threads = 1;
  const ReconstructionResult one = ReconstructionJob(scansOf(truth, 5), settings).run();
  settings.threads = 3;
  const ReconstructionResult three = ReconstructionJob(scansOf(truth, 5), settings).run();
  ASSERT_TRUE(one.uncertainty && three.uncertainty);
  EXPECT_EQ(one.uncertainty->deviation.voxels, three.uncertainty->deviation.voxels);
  EXPECT_EQ(one.uncertainty->coverage, three.uncertainty->coverage);
}

TEST(Uncertainty, SaysWhyItIsUnknown) {
  ReconstructionInput input = scansOf(testing::headPhantom(16), 1);
  const ReconstructionResult result = ReconstructionJob(input, quick()).run();
  EXPECT_FALSE(result.uncertainty);
  ASSERT_FALSE(result.warnings.empty());
  EXPECT_NE(result.warnings.back().find("The uncertainty is unknown"), std::string::npos);
  EXPECT_FALSE(result.volume.voxels.empty());
}

} // namespace
} // namespace innergs
