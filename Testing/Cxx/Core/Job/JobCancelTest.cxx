#include "JobInputs.h"
#include "ThrownError.h"

#include <atomic>
#include <thread>

using namespace innergs;
using namespace innergs::testing;

namespace {

/// A run that requests a stop in its n-th progress report (counted from 0; −1: never).
Attempt runUntil(const ReconstructionInput& input, const Settings& settings, int stopAt,
                 std::shared_ptr<const Model> resume = {}) {
  ReconstructionInput from = input;
  from.resume = std::move(resume);
  int reports = 0;
  return innergs::testing::runUntil([&](const Progress&) { return reports++ == stopAt; }, from, settings);
}

} // namespace

class Cancel : public ::testing::TestWithParam<InputKind> {
protected:
  ReconstructionInput input = GetParam().input();
  Settings settings = [] {
    Settings s = quickSettings(4);
    s.gaussians = 120;
    s.ensembleSize = GetParam().members;
    return s;
  }();
};

TEST_P(Cancel, AtAnyPointEndsPromptlyAndGoesOnWhereItStopped) {
  const Attempt whole = runUntil(input, settings, -1);
  ASSERT_FALSE(whole.result.cancelled);
  const int count = static_cast<int>(whole.states.size());
  ASSERT_GE(count, 4 * GetParam().members + 3);
  int resumed = 0;
  for (int at = 0; at < count - 1; ++at) { // the last one is Done: too late
    const Progress& state = whole.states[at];
    SCOPED_TRACE(::testing::Message()
                 << "stop " << at << " in " << phaseName(state.phase) << ", iteration " << state.iteration);
    const Attempt stopped = runUntil(input, settings, at);
    EXPECT_TRUE(stopped.result.cancelled);
    EXPECT_LE(static_cast<int>(stopped.states.size()), at + 2);
    EXPECT_NE(stopped.states.back().phase, Phase::Done);
    EXPECT_TRUE(stopped.result.volume.voxels.empty()) << "nobody asked for it";
    ASSERT_TRUE(stopped.result.model);
    EXPECT_EQ(stopped.result.iterations, stopped.result.model->iteration);
    if (stopped.result.model->field.gaussians.empty()) {
      EXPECT_LE(static_cast<int>(state.phase), static_cast<int>(Phase::Initialising));
      continue;
    }
    EXPECT_NO_THROW(checkField(stopped.result.model->field));
    const Attempt rest = runUntil(input, settings, -1, stopped.result.model);
    ++resumed;
    EXPECT_FALSE(rest.result.cancelled);
    EXPECT_TRUE(rest.result.warnings.empty()) << rest.result.warnings[0];
    EXPECT_LT(rest.states.size(), whole.states.size());
    EXPECT_TRUE(sameField(rest.result.model->field, whole.result.model->field));
    EXPECT_EQ(rest.result.volume.voxels, whole.result.volume.voxels);
    EXPECT_EQ(rest.result.iterations, whole.result.iterations);
  }
  EXPECT_GE(resumed, 4 * GetParam().members);
}

TEST_P(Cancel, AgainAndAgainStillEndsAtTheSameResult) {
  const Attempt whole = runUntil(input, settings, -1);
  for (const int first : {1, 2, 3}) {
    SCOPED_TRACE(::testing::Message() << "stops in callbacks " << first << ", " << first + 1 << ", ...");
    std::shared_ptr<const Model> model;
    ReconstructionResult last;
    int runs = 0;
    for (; runs < 60; ++runs) {
      const Attempt run = runUntil(input, settings, first + (model ? 0 : 1) + runs, model);
      last = run.result;
      if (!last.cancelled) break;
      if (last.model->field.gaussians.empty()) { // stopped during the prediction
        EXPECT_FALSE(model);
        continue;
      }
      // A run that is stopped before any work keeps its input model.
      const Attempt nothing = runUntil(input, settings, 0, last.model);
      ASSERT_TRUE(nothing.result.cancelled);
      EXPECT_EQ(nothing.result.model->iteration, last.model->iteration);
      model = nothing.result.model;
      ASSERT_FALSE(model->field.gaussians.empty());
    }
    EXPECT_LT(runs, 60);
    EXPECT_TRUE(sameField(last.model->field, whole.result.model->field));
    EXPECT_EQ(last.volume.voxels, whole.result.volume.voxels);
  }
}

TEST_P(Cancel, RendersTheStoppedStateWhenAsked) {
  std::stop_source stop;
  ReconstructionJob job(input, settings);
  job.onProgress([&](const Progress& p) {
    if (p.phase == Phase::Fitting && p.iteration == 2) stop.request_stop();
  });
  const auto result = job.run(stop.get_token(), true);
  EXPECT_TRUE(result.cancelled);
  EXPECT_EQ(result.iterations, 2);
  ASSERT_EQ(static_cast<std::int64_t>(result.volume.voxels.size()), result.volume.geometry.voxelCount());
  const auto [low, high] = std::minmax_element(result.volume.voxels.begin(), result.volume.voxels.end());
  EXPECT_GT(*high - *low, 50);
}

TEST_P(Cancel, BeforeTheStartDoesNothing) {
  std::stop_source stop;
  stop.request_stop();
  const auto result = ReconstructionJob(input, settings).run(stop.get_token());
  EXPECT_TRUE(result.cancelled);
  EXPECT_EQ(result.iterations, 0);
  ASSERT_TRUE(result.model);
}

INSTANTIATE_TEST_SUITE_P(Inputs, Cancel,
                         ::testing::Values(InputKind{"Isotropic", isotropicInput, 1},
                                           InputKind{"IsotropicMembers", isotropicInput, 2},
                                           InputKind{"Anisotropic", anisotropicInput, 3},
                                           InputKind{"Orthogonal", orthogonalInput, 2}),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(CancelFromAnotherThread, EndsWithinACoupleOfIterations) {
  Settings settings = quickSettings(100000);
  ReconstructionJob job(isotropicInput(), settings);
  std::atomic<int> iterations{0}, atRequest{-1};
  job.onProgress([&](const Progress& p) {
    if (p.phase == Phase::Fitting) ++iterations;
  });
  std::stop_source stop;
  std::jthread user([&] {
    while (iterations < 5)
      std::this_thread::yield();
    stop.request_stop();
    atRequest = iterations.load();
  });
  const auto result = job.run(stop.get_token());
  user.join();
  EXPECT_TRUE(result.cancelled);
  EXPECT_GE(result.iterations, 5);
  EXPECT_LE(iterations - atRequest, 2);
  EXPECT_FALSE(result.model->field.gaussians.empty());
}

TEST(Resume, WithOtherSettingsStartsANewFitFromTheModel) {
  const ReconstructionInput input = isotropicInput();
  Settings settings = quickSettings(5);
  const auto first = reconstruct(input, settings);
  ReconstructionInput again = input;
  again.resume = first.model;
  settings.loss = LossKind::L1;
  const auto second = reconstruct(again, settings);
  ASSERT_FALSE(second.warnings.empty());
  EXPECT_EQ(second.iterations, 5);
  EXPECT_FALSE(sameField(first.model->field, second.model->field));
}

TEST(Resume, OfMergedMembersUnderOtherSettingsRefitsThemAsOneField) {
  ReconstructionInput input = anisotropicInput();
  Settings settings = quickSettings(4);
  settings.ensembleSize = 3;
  settings.gaussians = 120;
  const auto first = reconstruct(input, settings);
  input.resume = first.model;
  settings.loss = LossKind::Huber;
  settings.blending = Blending::Additive; // the model's own blending is used
  settings.ensembleSize = 1;
  const auto second = reconstruct(input, settings);
  EXPECT_EQ(second.settings.ensembleSize, 1);
  EXPECT_EQ(second.settings.blending, Blending::Normalised);
  EXPECT_EQ(second.model->field.blending, Blending::Normalised);
  EXPECT_EQ(second.model->field.size(), first.model->field.size());
  EXPECT_GT(second.trainingPsnr, first.trainingPsnr - 3);
}

TEST(Resume, OfACompleteFitOnlyRendersAgain) {
  ReconstructionInput input = isotropicInput();
  const auto first = reconstruct(input, quickSettings(5));
  input.resume = first.model;
  const auto second = reconstruct(input, quickSettings(5));
  EXPECT_TRUE(sameField(first.model->field, second.model->field));
  EXPECT_EQ(first.volume.voxels, second.volume.voxels);
  EXPECT_NEAR(first.trainingPsnr, second.trainingPsnr, 1e-6);
  EXPECT_TRUE(second.warnings.empty());
}

TEST(Resume, OfABrokenModelIsRefused) {
  ReconstructionInput input = isotropicInput();
  auto broken = std::make_shared<Model>(*reconstruct(input, quickSettings(2)).model);
  broken->field.gaussians[3].mean[0] = std::numeric_limits<float>::quiet_NaN();
  input.resume = broken;
  EXPECT_THROW(reconstruct(input, quickSettings(2)), Error);
}

TEST(Resume, OfAForgedStateIsRefused) {
  // Inconsistent lengths must not cause reads beyond the end.
  const ReconstructionInput input = isotropicInput();
  const Settings settings = quickSettings(4);
  const Attempt stopped = runUntil(input, settings, 4);
  ASSERT_TRUE(stopped.result.cancelled);
  const auto refused = [&](auto&& change) {
    auto forged = std::make_shared<Model>(*stopped.result.model);
    change(*forged);
    ReconstructionInput from = input;
    from.resume = forged;
    return test::codeOf([&] { reconstruct(from, settings); }) == ErrorCode::FileFormat;
  };
  EXPECT_TRUE(refused([](Model& c) { c.optimizer.moment1.pop_back(); }));
  EXPECT_TRUE(refused([](Model& c) { c.optimizer.moment2.clear(); }));
  EXPECT_TRUE(refused([](Model& c) { c.finished = -1; }));
  EXPECT_TRUE(refused([](Model& c) { c.finished = c.field.size() + 1; }));
  EXPECT_TRUE(refused([](Model& c) { c.iteration = -3; }));
  EXPECT_TRUE(refused([](Model& c) { c.iteration = 1 << 30; }));
  EXPECT_TRUE(refused([](Model& c) { c.optimizer.moment2[7] = std::numeric_limits<float>::quiet_NaN(); }));
}
