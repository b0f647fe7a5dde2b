#include "Core/Alignment/SliceMotion.h"
#include "Core/Image/Metrics.h"
#include "Core/Image/NoiseEstimate.h"
#include "Core/Image/Region.h"
#include "Core/Image/Simulate.h"
#include "Core/Job/ReconstructionJob.h"
#include "Evaluation/HeldOutProtocol.h"
#include "Evaluation/SimulatedStacks.h"
#include "IO/VolumeIO.h"

#include <algorithm>
#include <filesystem>
#include <gtest/gtest.h>

using namespace innergs;

namespace {

std::optional<Volume> testVolume(const std::string& name) {
  const auto path = std::filesystem::path(INNERGS_TEST_DATA) / name;
  if (!std::filesystem::exists(path)) return std::nullopt;
  return readVolume(path);
}

double psnrOf(const EvaluationReport& report, const std::string& name) {
  for (const MethodScore& method : report.methods)
    if (method.name == name) return method.psnr;
  ADD_FAILURE() << "no method " << name;
  return 0;
}

/// 119 × 136 × 112 voxels of the studyforrest scan.
Volume middleOf(const Volume& volume) {
  return cropped(volume, IndexBlock{{24, 30, 124}, {119, 136, 112}});
}

} // namespace

// Known noise added to real scans whose background is air, zeroed, or another tissue.
TEST(RealData, NoiseEstimateFindsAddedNoise) {
  int found = 0;
  for (const char* name :
       {"A_icbm152_2009a_sym_t1_1mm.nii.gz", "A_studyforrest_T1w_1mm_crop.nii.gz",
        "B_abdomen_spgr_FA15.nii.gz", "C_ct_abdomen_pelvis_3mm.nii.gz", "F_fetal_run-1_T2w.nii.gz"}) {
    const auto volume = testVolume(name);
    if (!volume) continue;
    ++found;
    const auto [low, high] = std::minmax_element(volume->voxels.begin(), volume->voxels.end());
    const double noise = estimateNoise(*volume), detail = estimateFineDetail(*volume);
    for (const double share : {0.01, 0.05}) {
      const double sigma = share * (double(*high) - *low);
      const Volume noisy = simulateThickStack(*volume, 2, 1, sigma, 3).image;
      const double expected = std::hypot(noise, sigma), withDetail = std::hypot(detail, sigma);
      EXPECT_NEAR(estimateFineDetail(noisy), withDetail, 0.1 * withDetail) << name;
      EXPECT_LT(estimateNoise(noisy), 1.05 * expected) << name;
      // Strong texture, as in the fetal scan, hides weak noise.
      if (share > 0.02) {
        EXPECT_NEAR(estimateNoise(noisy), expected, 0.15 * expected) << name;
      }
    }
  }
  if (!found) GTEST_SKIP() << "no test volumes in " << INNERGS_TEST_DATA;
}

// Known scores of the baselines on this crop (PSNR peak 137): every 4th slice linear 25.5, 4 mm box
// linear 27.2, cubic 28.1, Lanczos 28.2, back-projection 28.5 dB over the whole crop; the body mask adds
// about 1 dB.
TEST(RealData, BaselinesReachTheirKnownScores) {
  const auto volume = testVolume("A_studyforrest_T1w_1mm_crop.nii.gz");
  if (!volume) GTEST_SKIP() << "no test volumes in " << INNERGS_TEST_DATA;
  const Volume crop = middleOf(*volume);
  EvaluationOptions options;
  options.gaussians = false;
  const auto thick = evaluateHeldOut(crop, {HeldOutCase::Kind::Thick, 4, 2, 0}, options);
  EXPECT_NEAR(psnrOf(thick, "linear"), 27.94, 0.1);
  EXPECT_NEAR(psnrOf(thick, "cubic"), 29.09, 0.1);
  EXPECT_NEAR(psnrOf(thick, "lanczos"), 29.18, 0.1);
  EXPECT_NEAR(psnrOf(thick, "backprojection"), 29.46, 0.1);
  const auto orthogonal = evaluateHeldOut(crop, {HeldOutCase::Kind::Orthogonal, 4, 2, 0}, options);
  EXPECT_NEAR(psnrOf(orthogonal, "backprojection"), 35.6, 0.2);
}

// Wrong poses make two still scans of 80 mm predict each other better by 2 dB, and the result worse by 10 dB.
TEST(RealData, SlicesMoveOnlyWhereTheyMoved) {
  const auto volume = testVolume("A_icbm152_2009a_sym_t1_1mm.nii.gz");
  if (!volume) GTEST_SKIP() << "no test volumes in " << INNERGS_TEST_DATA;
  ThreadPool pool(2);
  StacksCase simulated;
  simulated.central = 56;
  simulated.noise = 2.55;
  for (const auto& [stacks, moved] : {std::pair{2, 0.0}, {2, 2.0}, {3, 0.0}, {3, 1.0}}) {
    simulated.stacks = stacks;
    simulated.motion = simulated.turn = moved;
    const SliceMotion found = findSliceMotion(simulateStacks(*volume, simulated, pool).stacks, {}, pool);
    EXPECT_EQ(found.moved, moved > 0)
        << stacks << " scans, by " << moved << ": " << found.psnrBefore << " to " << found.psnrAfter << " dB";
  }
}

// Slices of 4 mm; of the two slabs, the second is also acquired half a slice further on.
TEST(RealData, AdjoiningSlabsGiveWhatOneScanGives) {
  const auto volume = testVolume("A_studyforrest_T1w_1mm_crop.nii.gz");
  if (!volume) GTEST_SKIP() << "no test volumes in " << INNERGS_TEST_DATA;
  const Volume truth = middleOf(*volume);
  const auto slab = [&](std::int64_t first, std::int64_t planes) {
    return simulateThickStack(cropped(truth, IndexBlock{{0, 0, first}, {119, 136, planes}}), 2, 4);
  };
  const auto psnr = [&](std::vector<Stack> stacks, PredictionKind kind) {
    ReconstructionInput input;
    input.stacks = std::move(stacks);
    input.outputGrid = truth.geometry;
    Settings settings;
    settings.preset = Preset::Fast;
    settings.threads = 2;
    settings.device = "cpu";
    settings.prediction = kind;
    const Volume result = ReconstructionJob(input, settings).run().volume;
    double squares = 0;
    constexpr std::size_t kScored = std::size_t{119} * 136 * 108; // planes that all slabs reach
    for (std::size_t v = 0; v < kScored; ++v)
      squares += std::pow(static_cast<double>(result.voxels[v]) - truth.voxels[v], 2);
    return 10 * std::log10(137.0 * 137 * kScored / squares);
  };
  const double one = psnr({slab(0, 112)}, PredictionKind::Auto);
  const Stack upper = slab(0, 60);
  for (const std::int64_t from : {52, 54}) {
    const double two = psnr({upper, slab(from, (112 - from) / 4 * 4)}, PredictionKind::Auto);
    EXPECT_GT(two, one - 0.1) << "from plane " << from;
    EXPECT_GT(two, psnr({upper, slab(from, (112 - from) / 4 * 4)}, PredictionKind::None) + 0.25)
        << "from plane " << from;
  }
}
