#include "Core/Fit/Plan.h"
#include "Core/Job/JobInput.h"
#include "Core/Job/Resume.h"
#include "JobInputs.h"
#include "RandomFields.h"
#include "ThrownError.h"

using namespace innergs;
using namespace innergs::testing;

namespace {

/// The paper's method, small and short.
Settings paperSettings(int iterations = 24) {
  Settings settings = quickSettings(iterations);
  settings.preset = Preset::Paper;
  settings.densifyEvery = 4;
  settings.maxGaussians = 400;
  settings.densify.gradient = 0.02;
  return settings;
}

DataTraits traitsOf(const ReconstructionInput& input) {
  DataTraits traits = geometryTraits(input.stacks);
  traits.volume = 24 * 22 * 20;
  return traits;
}

/// Three orthogonal scans of thick slices.
ReconstructionInput threeScans() {
  ReconstructionInput input = orthogonalInput();
  input.stacks.push_back(simulateThickStack(phantom(smallGrid()), 1, 4));
  return input;
}

} // namespace

TEST(PaperPreset, IsItsAlgorithm) {
  Settings settings;
  settings.preset = Preset::Paper;
  const FitPlan plan = makePlan(settings, traitsOf(isotropicInput()));
  EXPECT_EQ(settings.blending, Blending::Alpha);
  EXPECT_EQ(settings.linearIntensity, false);
  EXPECT_EQ(settings.initialisation, Initialisation::Grid);
  EXPECT_EQ(settings.gaussians, 74088);
  EXPECT_EQ(settings.maxGaussians, 74088);
  EXPECT_EQ(settings.ensembleSize, 1);
  EXPECT_EQ(settings.allAxes, true);
  EXPECT_EQ(plan.loss.kind, LossKind::L1);
  EXPECT_EQ(plan.loss.pointWeight, 0.8);
  EXPECT_EQ(plan.loss.ssimWeight, 0.4);
  EXPECT_EQ(plan.schedule, Schedule::Plateau);
  EXPECT_GT(plan.densify.every, 0);
  EXPECT_EQ(plan.densify.limit, 74088);
  EXPECT_EQ(plan.densify.coverage, 3);
  EXPECT_TRUE(plan.paperStopRule);
  EXPECT_EQ(plan.iterations, 1000);
  EXPECT_EQ(plan.coarseIterations, 0);
  EXPECT_EQ(plan.relocateEvery, 0);
}

TEST(Training, CutoffAndAdamAreChoicesOfTheFit) {
  Settings usual;
  FitPlan plan = makePlan(usual, traitsOf(isotropicInput()));
  EXPECT_EQ(plan.cutoff, 2.2);
  EXPECT_EQ(plan.beta1, 0.8);
  EXPECT_EQ(plan.beta2, 0.95);
  const auto changed = [&](auto change) {
    Settings settings;
    change(settings);
    plan = makePlan(settings, traitsOf(isotropicInput()));
    EXPECT_NE(settingsKey(settings, ""), settingsKey(usual, "")); // a different fit that cannot be resumed
  };
  changed([](Settings& s) { s.cutoff = 3; });
  EXPECT_EQ(plan.cutoff, 3);
  changed([](Settings& s) { s.beta1 = 0.9; });
  EXPECT_EQ(plan.beta1, 0.9);
  changed([](Settings& s) { s.beta2 = 0.999; });
  EXPECT_EQ(plan.beta2, 0.999);

  Settings settings = quickSettings();
  const ReconstructionResult base = reconstruct(isotropicInput(), settings);
  EXPECT_EQ(base.model->field.cutoff, 2.2);
  settings.beta2 = 0.999;
  EXPECT_FALSE(sameField(reconstruct(isotropicInput(), settings).model->field, base.model->field));
  settings.cutoff = 3;
  EXPECT_EQ(reconstruct(isotropicInput(), settings).model->field.cutoff, 3);
}

TEST(Training, CountsWhatDensificationDid) {
  const ReconstructionResult result = reconstruct(isotropicInput(), paperSettings());
  const DensifyCounts& counts = result.densified;
  EXPECT_GT(counts.split + counts.cloned, 0);
  EXPECT_GE(counts.pruned, 0);
  Settings settings = paperSettings(1); // as initialised: no densification yet
  const ReconstructionResult start = reconstruct(isotropicInput(), settings);
  EXPECT_EQ(start.densified.pruned + start.densified.split + start.densified.cloned, 0);
  EXPECT_EQ(result.model->field.size(),
            start.model->field.size() + counts.split + counts.cloned - counts.pruned);
}

TEST(PaperPreset, YieldsToWhatIsSetExplicitly) {
  Settings settings;
  settings.preset = Preset::Paper;
  settings.blending = Blending::Normalised;
  settings.initialisation = Initialisation::Adaptive;
  settings.loss = LossKind::L2;
  settings.lossWeight = 1;
  settings.ssimWeight = 0;
  settings.schedule = Schedule::Exponential;
  settings.densifyEvery = 0;
  settings.paperStopRule = false;
  settings.allAxes = false;
  settings.gaussians = 500;
  settings.iterations = 12;
  const FitPlan plan = makePlan(settings, traitsOf(isotropicInput()));
  EXPECT_EQ(settings.blending, Blending::Normalised);
  EXPECT_EQ(plan.start.kind, Initialisation::Adaptive);
  EXPECT_EQ(plan.start.gaussians, 500);
  EXPECT_EQ(plan.loss.kind, LossKind::L2);
  EXPECT_EQ(plan.loss.pointWeight, 1);
  EXPECT_EQ(plan.loss.ssimWeight, 0);
  EXPECT_EQ(plan.schedule, Schedule::Exponential);
  EXPECT_EQ(plan.densify.every, 0);
  EXPECT_FALSE(plan.paperStopRule);
  EXPECT_FALSE(plan.allAxes);
  EXPECT_EQ(plan.iterations, 12);
}

TEST(AlphaBlending, GetsSensibleDefaultsFromOurPresets) {
  for (const Preset preset : {Preset::Fast, Preset::Balanced, Preset::Best})
    for (const auto& input : {isotropicInput(), anisotropicInput(), orthogonalInput()}) {
      Settings settings;
      settings.preset = preset;
      settings.blending = Blending::Alpha;
      const FitPlan plan = makePlan(settings, traitsOf(input));
      EXPECT_FALSE(plan.linearIntensity);
      EXPECT_EQ(settings.ensembleSize, 1);
      EXPECT_EQ(plan.densify.every, 0);
      EXPECT_EQ(plan.allAxes, geometryTraits(input.stacks).cubes);
      EXPECT_EQ(plan.allAxes, input.stacks.size() == 1 && input.stacks[0].image.geometry.spacing[2] < 1.5);
    }
}

TEST(AlphaBlending, FitsEveryKindOfInput) {
  const Volume truth = phantom(smallGrid());
  for (auto input : {isotropicInput(), anisotropicInput(), orthogonalInput()}) {
    input.outputGrid = truth.geometry;
    Settings settings = quickSettings(40);
    settings.blending = Blending::Alpha;
    const auto result = reconstruct(input, settings);
    EXPECT_EQ(result.model->field.blending, Blending::Alpha);
    EXPECT_GT(psnr(result.volume, truth), input.stacks.size() == 1 ? 17 : 14);
  }
}

TEST(Iterations, OfSeveralScansAreMoreTheLessNoiseThereIs) {
  DataTraits traits = geometryTraits(orthogonalInput().stacks);
  ASSERT_TRUE(traits.superResolution());
  const auto iterations = [&](double noise, Preset preset = Preset::Balanced) {
    traits.noise = noise;
    Settings settings;
    settings.preset = preset;
    return makePlan(settings, traits).iterations;
  };
  EXPECT_EQ(iterations(0), 120);
  EXPECT_EQ(iterations(0.014), 60);
  EXPECT_EQ(iterations(0.014, Preset::Fast), 40);
  EXPECT_GT(iterations(0.01), iterations(0.02));
  EXPECT_EQ(iterations(0.2), 24);
  traits.posed = true; // how well slices agree is unknown
  EXPECT_EQ(iterations(0), 60);
  EXPECT_EQ(iterations(0.2), 60);
  traits.disagreement = 0.01;
  EXPECT_EQ(iterations(0), 225);
  EXPECT_EQ(iterations(0.014), 113);
  EXPECT_EQ(iterations(0.014, Preset::Fast), 60);
  traits.disagreement = 0.1;
  EXPECT_EQ(iterations(0), iterations(0.025));
  EXPECT_LT(iterations(0), 113);
}

TEST(Subsets, AreTheThickScansUnlessLossesAreCompared) {
  const auto planOf = [](std::span<const Stack> stacks, Settings settings) {
    return makePlan(settings, geometryTraits(stacks));
  };
  const std::vector<Stack> three = threeScans().stacks, two = orthogonalInput().stacks;
  std::vector<Stack> six = three;
  six.insert(six.end(), three.begin(), three.end());
  const FitPlan turns = planOf(three, {});
  EXPECT_EQ(turns.subsets, 3);
  EXPECT_EQ(planOf(two, {}).subsets, 2);
  EXPECT_EQ(planOf(six, {}).subsets, 3);
  EXPECT_EQ(planOf({three.data(), 1}, {}).subsets, 1);
  const std::vector<Stack> thin(2, isotropicInput().stacks.front());
  EXPECT_EQ(planOf(thin, {}).subsets, 1);
  Settings plateau, stops, densifies;
  plateau.schedule = Schedule::Plateau;
  stops.paperStopRule = true;
  densifies.densifyEvery = 10;
  for (const Settings& s : {plateau, stops, densifies}) {
    const FitPlan plan = planOf(three, s);
    EXPECT_EQ(plan.subsets, 1);
    EXPECT_LT(plan.rates.mean, turns.rates.mean);
  }
}

TEST(Subsets, GoOnFromAnyIterationAsIfTheFitHadNotStopped) {
  const ReconstructionInput input = threeScans();
  Settings settings = quickSettings(16);
  settings.align = false;
  settings.sliceMotion = SliceMotionKind::Off;
  const ReconstructionResult whole = ReconstructionJob(input, settings).run();
  for (const int stop : {1, 5, 8, 15}) {
    SCOPED_TRACE(stop);
    std::stop_source source;
    ReconstructionJob first(input, settings);
    first.onProgress([&](const Progress& p) {
      if (p.iteration >= stop) source.request_stop();
    });
    const ReconstructionResult part = first.run(source.get_token());
    ASSERT_TRUE(part.cancelled);
    ASSERT_LT(part.iterations, 16);
    ReconstructionInput rest = input;
    rest.resume = part.model;
    const ReconstructionResult resumed = ReconstructionJob(rest, settings).run();
    EXPECT_TRUE(sameGaussians(resumed.model->field, whole.model->field));
  }
}

TEST(AllAxes, SeeEveryVoxelThreeTimesAndAreOffForOneValuePerPoint) {
  const DataTraits traits = geometryTraits(isotropicInput().stacks);
  Settings settings;
  EXPECT_FALSE(makePlan(settings, traitsOf(isotropicInput())).allAxes);
  EXPECT_TRUE(traits.cubes);
  EXPECT_FALSE(geometryTraits(anisotropicInput().stacks).cubes);
  EXPECT_FALSE(geometryTraits(orthogonalInput().stacks).cubes);
  ReconstructionInput posed = isotropicInput();
  posed.stacks[0].poses.assign(20, Affine3{});
  EXPECT_FALSE(geometryTraits(posed.stacks).cubes);
  ReconstructionInput blurred = isotropicInput();
  blurred.stacks[0].profile = SliceProfile::Box;
  EXPECT_TRUE(geometryTraits(blurred.stacks).cubes);
  blurred.stacks[0].thickness = 2;
  EXPECT_FALSE(geometryTraits(blurred.stacks).cubes);
  // A normalised field has one value per point, so three views of it require the same as one. Few iterations:
  // over many, rounding makes the two fits diverge.
  Settings one = quickSettings(4);
  one.consistency = false; // compares the Gaussians alone
  Settings three = one;
  three.allAxes = true;
  const ReconstructionInput input = isotropicInput();
  const auto a = reconstruct(input, one), b = reconstruct(input, three);
  EXPECT_NEAR(a.trainingPsnr, b.trainingPsnr, 0.02);
}

TEST(AllAxes, AreRefusedWhereVoxelsAreNotCubes) {
  for (const auto& input : {anisotropicInput(), orthogonalInput()}) {
    Settings settings = quickSettings(2);
    settings.allAxes = true;
    EXPECT_EQ(test::codeOf([&] { reconstruct(input, settings); }), ErrorCode::InvalidArgument);
  }
}

TEST(AllAxes, KeepHeldOutSlicesAndTheMaskFromEveryView) {
  ReconstructionInput input = isotropicInput();
  input.heldOutFraction = 0.25; // the slices 2, 6, 10, ...
  Mask mask{smallGrid(), {}};
  for (std::int64_t v = 0; v < mask.geometry.voxelCount(); ++v)
    mask.voxels.push_back(v % 24 < 20);
  input.masks = {mask};
  Settings settings = quickSettings(15);
  settings.blending = Blending::Alpha;
  const auto result = reconstruct(input, settings);
  EXPECT_EQ(result.settings.allAxes, true);
  EXPECT_GT(result.heldOutPsnr, 10);
  EXPECT_NEAR(result.heldOutPsnr, psnrOfAFitWithout(input, {2, 6, 10, 14, 18}, settings), 0.5);
  ReconstructionInput other = input; // content that no view may show
  auto& voxels = other.stacks[0].image.voxels;
  for (std::size_t v = 0; v < voxels.size(); ++v)
    if (!mask.voxels[v]) voxels[v] = 3;
  const auto changed = reconstruct(other, settings);
  EXPECT_TRUE(sameField(result.model->field, changed.model->field));
  EXPECT_DOUBLE_EQ(result.heldOutPsnr, changed.heldOutPsnr);
}

TEST(PaperFit, ImprovesGrowsAndIsTheSameForAnyNumberOfThreads) {
  const ReconstructionInput input = isotropicInput();
  Settings settings = paperSettings(40);
  std::vector<std::int64_t> counts;
  ReconstructionJob job(input, settings);
  job.onProgress([&](const Progress& p) {
    if (p.phase == Phase::Fitting) counts.push_back(p.gaussians);
  });
  const auto result = job.run();
  ASSERT_EQ(counts.size(), 40u);
  EXPECT_GT(counts.back(), counts.front());
  EXPECT_LE(*std::max_element(counts.begin(), counts.end()), 400);
  EXPECT_EQ(counts.back(), result.model->field.size());
  EXPECT_GT(result.trainingPsnr, 18);
  for (int threads : {1, 3}) {
    settings.threads = threads;
    EXPECT_TRUE(sameField(result.model->field, reconstruct(input, settings).model->field));
  }
}

TEST(PaperFit, StoppedAnywhereGoesOnToTheSameResult) {
  const ReconstructionInput input = isotropicInput();
  const Settings settings = paperSettings();
  const auto whole = reconstruct(input, settings);
  for (int at : {1, 3, 4, 5, 11, 12, 13, 23}) {
    const auto stopped = stoppedAt(at, input, settings);
    ASSERT_TRUE(stopped.cancelled);
    EXPECT_EQ(stopped.model->optimizer.losses.size(), static_cast<std::size_t>(at));
    ReconstructionInput rest = input;
    rest.resume = stopped.model;
    const auto resumed = reconstruct(rest, settings);
    EXPECT_TRUE(resumed.warnings.empty());
    EXPECT_TRUE(sameField(resumed.model->field, whole.model->field)) << "stopped at " << at;
    const auto refused = [&](auto&& change) {
      auto forged = std::make_shared<Model>(*stopped.model);
      change(*forged);
      rest.resume = forged;
      return test::codeOf([&] { reconstruct(rest, settings); }) == ErrorCode::FileFormat;
    };
    EXPECT_TRUE(refused([](Model& c) { c.optimizer.losses.resize(1000); }));
    EXPECT_TRUE(refused([](Model& c) { c.optimizer.losses[0] = std::numeric_limits<float>::quiet_NaN(); }));
    EXPECT_TRUE(refused([](Model& c) { c.optimizer.gradients.resize(7); }));
    EXPECT_TRUE(refused([](Model& c) { c.optimizer.gradients.assign(c.field.size(), -1.f); }));
  }
}

TEST(Resume, OfAnAlphaModelUnderOtherSettingsSeesAllItsAxes) {
  ReconstructionInput input = isotropicInput();
  Settings settings = quickSettings(8);
  settings.blending = Blending::Alpha;
  input.resume = reconstruct(input, settings).model;
  Settings other = quickSettings(3);
  const auto result = reconstruct(input, other);
  EXPECT_EQ(result.model->field.blending, Blending::Alpha);
  EXPECT_EQ(result.settings.allAxes, true);
  EXPECT_EQ(result.settings.linearIntensity, false);
}
