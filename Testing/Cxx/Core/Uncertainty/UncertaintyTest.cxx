#include "../Alignment/HeadPhantom.h"
#include "Core/Image/Simulate.h"
#include "Core/Job/ReconstructionJob.h"
#include "Core/Uncertainty/ErrorCurve.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

namespace innergs {
namespace {

constexpr std::int64_t kWidth = 48;

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
    double least; // between two scans of strong noise, the simulation is smoother than the truth
    double most;  // where noise is small beside the edges, intervals are too wide
  };
  const Case cases[] = {{"edges", testing::headPhantom(kWidth), 5, 0.85, 0.98},
                        {"noisy edges", testing::headPhantom(kWidth), 40, 0.82, 0.95},
                        {"waves", smooth(), 10, 0.85, 0.96}};
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
    EXPECT_GT(held, c.least) << c.name << ", noise " << u.noise << " of " << c.noise;
    EXPECT_LT(held, c.most) << c.name << ", noise " << u.noise << " of " << c.noise;
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

/// A head whose slices lie up to 2 voxels beside each other, at random, in a little noise.
Stack restlessScan(double noise) {
  Stack scan = simulateThickStack(testing::headPhantom(kWidth), 2, 1, noise);
  std::uint64_t state = 7;
  const auto step = [&] {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return static_cast<std::int64_t>(state >> 33) % 5 - 2;
  };
  const std::vector<float> still = scan.image.voxels;
  for (std::int64_t k = 0; k < kWidth; ++k) {
    const std::int64_t x = step(), y = step();
    for (std::int64_t j = 0; j < kWidth; ++j)
      for (std::int64_t i = 0; i < kWidth; ++i)
        scan.image.voxels[i + kWidth * (j + kWidth * k)] =
            still[std::clamp<std::int64_t>(i + x, 0, kWidth - 1) +
                  kWidth * (std::clamp<std::int64_t>(j + y, 0, kWidth - 1) + kWidth * k)];
  }
  return scan;
}

TEST(Uncertainty, HoldsSlicesThatDisagree) {
  constexpr double kNoise = 5;
  const Stack whole = restlessScan(kNoise);
  ReconstructionInput input;
  Stack& kept = input.stacks.emplace_back();
  kept.image.geometry = whole.image.geometry;
  kept.image.geometry.size[2] /= 2;
  kept.image.geometry.spacing[2] *= 2;
  kept.thickness = 1;
  const std::int64_t plane = kWidth * kWidth;
  for (std::int64_t k = 0; k < kWidth; k += 2)
    kept.image.voxels.insert(kept.image.voxels.end(), whole.image.voxels.begin() + k * plane,
                             whole.image.voxels.begin() + (k + 1) * plane);
  input.outputGrid = whole.image.geometry;
  input.uncertainty = true;
  const ReconstructionResult result = ReconstructionJob(input, quick()).run();
  ASSERT_TRUE(result.uncertainty);
  std::int64_t held = 0, count = 0;
  for (std::int64_t k = 7; k < kWidth - 7; k += 2)
    for (std::int64_t j = 6; j < kWidth - 6; ++j)
      for (std::int64_t i = 6; i < kWidth - 6; ++i) {
        const std::size_t v = i + kWidth * (j + kWidth * k);
        const double width = std::hypot(result.uncertainty->deviation.voxels[v], result.noise);
        held += std::abs(result.volume.voxels[v] - whole.image.voxels[v]) <= kNinety * width;
        ++count;
      }
  const double share = static_cast<double>(held) / static_cast<double>(count);
  EXPECT_GT(share, 0.85);
  EXPECT_LT(share, 0.95);
}

TEST(Uncertainty, HasAPhaseOfItsOwnWhoseStopKeepsTheResult) {
  const Volume truth = testing::headPhantom(40);
  Settings settings = quick();
  settings.iterations = 4;
  ReconstructionJob whole(scansOf(truth, 5), settings);
  std::vector<Progress> told;
  whole.onProgress([&](const Progress& p) { told.push_back(p); });
  const ReconstructionResult full = whole.run();
  double fraction = 0;
  int estimating = 0;
  Phase before = Phase::Preparing;
  for (const Progress& p : told) {
    EXPECT_GE(p.fraction, fraction);
    if (p.phase >= Phase::Judging) {
      EXPECT_GE(p.phase, before);
    }
    fraction = p.fraction;
    before = p.phase;
    estimating += p.phase == Phase::Estimating && p.iterations > 0;
  }
  EXPECT_EQ(told.back().phase, Phase::Done);
  EXPECT_EQ(told.back().fraction, 1);
  EXPECT_GE(estimating, 4) << "both fits of the simulation tell of their iterations";
  for (const bool inSecondFit : {false, true}) {
    std::stop_source stop;
    ReconstructionJob job(scansOf(truth, 5), settings);
    int before = 0;
    job.onProgress([&](const Progress& p) {
      if (p.phase != Phase::Estimating) return;
      if (inSecondFit ? p.iteration < before : p.iteration > 0) stop.request_stop();
      before = p.iteration;
    });
    const ReconstructionResult result = job.run(stop.get_token());
    EXPECT_FALSE(result.cancelled);
    EXPECT_FALSE(result.uncertainty);
    EXPECT_EQ(result.judging, Judging::Done);
    EXPECT_EQ(result.heldOutPsnr, full.heldOutPsnr);
    EXPECT_EQ(result.volume.voxels, full.volume.voxels);
    ASSERT_FALSE(result.warnings.empty());
    EXPECT_NE(result.warnings.back().find("Stopped before the uncertainty was known"), std::string::npos);
  }
}

/// Two scans of a head, the second of them shaded by a third along its first axis.
ReconstructionInput shadedScans() {
  ReconstructionInput input = scansOf(testing::headPhantom(kWidth), 2);
  Volume& image = input.stacks[1].image;
  for (std::size_t v = 0; v < image.voxels.size(); ++v)
    image.voxels[v] *= 0.67f + 0.66f * static_cast<float>(v % image.geometry.size[0]) /
                                   static_cast<float>(image.geometry.size[0]);
  return input;
}

TEST(Uncertainty, AllowsForShadingThatScansMayShare) {
  Settings settings = quick();
  settings.biasField = BiasFieldKind::On;
  const ReconstructionResult result = ReconstructionJob(shadedScans(), settings).run();
  ASSERT_TRUE(result.uncertainty);
  const double shading = result.uncertainty->shading;
  EXPECT_GT(shading, 0.005);
  EXPECT_EQ(shading, result.bias.sharedDeviation);
  for (std::size_t v = 0; v < result.volume.voxels.size(); ++v)
    ASSERT_GE(result.uncertainty->deviation.voxels[v], 0.999 * shading * result.volume.voxels[v]);
  EXPECT_NE(uncertaintySentence(*result.uncertainty).find("smooth shading of"), std::string::npos);
  settings.keepBias = true; // then all have the shading of the first
  const ReconstructionResult kept = ReconstructionJob(shadedScans(), settings).run();
  ASSERT_TRUE(kept.uncertainty);
  EXPECT_EQ(kept.uncertainty->shading, 0);
  EXPECT_EQ(uncertaintySentence(*kept.uncertainty).find("shading"), std::string::npos);
}

} // namespace
} // namespace innergs
