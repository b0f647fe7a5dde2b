#include "Core/Fit/Trainer.h"
#include "Core/Render/Kernels.h"
#include "RandomFields.h"
#include "TestVolumes.h"

#include <gtest/gtest.h>

using namespace innergs;
using namespace innergs::testing;

namespace {

/// A fit of a phantom of n³ voxels of a given size, whose Gaussians start on a grid of every third voxel.
struct TrainedScene {
  Stack stack;
  GaussianField field;
  FitPlan plan;

  explicit TrainedScene(Blending blending = Blending::Normalised, int n = 18, double voxel = 1,
                        int phantomSize = 0) {
    const GridGeometry whole = grid(n, n, n, {voxel, voxel, voxel});
    stack.image = phantomSize == 0 ? phantom(whole) : cornerPhantom(whole, phantomSize);
    stack.profile = SliceProfile::Point;
    field.blending = blending;
    for (int k = 1; k < n; k += 3)
      for (int j = 1; j < n; j += 3)
        for (int i = 1; i < n; i += 3) {
          Gaussian g{};
          const double at[3] = {i * voxel, j * voxel, k * voxel};
          for (int a = 0; a < 3; ++a) {
            g.mean[a] = static_cast<float>(at[a]);
            g.logScale[a] = static_cast<float>(std::log(1.3 * voxel));
          }
          g.quaternion[0] = 1;
          g.intensity = stack.image.voxels[i + n * (j + n * k)] / 200;
          field.gaussians.push_back(g);
        }
    field.cutoff = 2.2;
    plan.iterations = 60;
    plan.rates = {0.2 * voxel, 0.09, 0.09, 0.15, 0.03, 0.01 / voxel};
    plan.bounds = {std::log(0.3 * voxel), std::log(30 * voxel)};
    plan.cutoff = 2.2;
    plan.densify.voxel = voxel;
    plan.densify.minLogScale = plan.bounds.minLogScale;
  }

  /// The phantom of a small grid in the corner of a large empty one.
  static Volume cornerPhantom(const GridGeometry& whole, std::int64_t n) {
    GridGeometry small = whole;
    small.size = {n, n, n};
    const Volume inner = phantom(small);
    return volumeOf(whole, [&](auto i, auto j, auto k) {
      return i < n && j < n && k < n ? inner.voxels[i + n * (j + n * k)] : 0.f;
    });
  }

  Trainer trainer(ThreadPool& pool) const {
    return Trainer(field, observe(stack, {}, {200, 0}, false), plan, kernelSet("scalar"), pool);
  }
};

void useAll(FitPlan& plan) { // everything that depends on the history
  plan.schedule = Schedule::Plateau;
  plan.plateau = {2, 0.7, 0.01, 1e-2};
  plan.densify.every = 7;
  plan.densify.thresholds = {0.3, 4, 0.01, 2};
  plan.densify.limit = 280;
}

/// The mean absolute displacement of all Gaussians in one more iteration.
double move(Trainer& trainer) {
  const auto before = trainer.field().gaussians;
  trainer.step();
  double sum = 0;
  for (std::size_t i = 0; i < before.size(); ++i)
    sum += std::abs(trainer.field().gaussians[i].mean[0] - before[i].mean[0]);
  return sum / static_cast<double>(before.size());
}

} // namespace

TEST(Plateau, ReducesTheRateWhenTheLossHasNotImproved) {
  const PlateauRule rule{3, 0.5, 0.2, 1e-2};
  PlateauSchedule schedule;
  std::vector<double> shares;
  // Falls twice, stays (0.795 is no improvement of 1 %), improves once, then stays for good.
  for (double loss : {1.0, 0.8, 0.795, 0.8, 0.81, 0.7, 0.7, 0.7, 0.7, 0.7, 0.7, 0.7, 0.7, 0.7, 0.7}) {
    schedule.add(loss, rule);
    shares.push_back(schedule.share());
  }
  const std::vector<double> expected{1, 1, 1, 1, 0.5, 0.5, 0.5, 0.5, .25, 0.25, 0.25, 0.2, 0.2, 0.2, 0.2};
  EXPECT_EQ(shares, expected);
}

TEST(Plateau, SlowsTheFitDownWhereTheExponentialScheduleDoesNot) {
  TrainedScene scene;
  ThreadPool pool(2);
  scene.plan.iterations = 1000;
  scene.plan.finalRate = 1;
  Trainer steady = scene.trainer(pool);
  scene.plan.schedule = Schedule::Plateau;
  scene.plan.plateau = {1, 0.1, 1e-3, 0.9}; // only the first iteration counts as an improvement
  Trainer slowed = scene.trainer(pool);
  for (int i = 0; i < 6; ++i) {
    steady.step();
    slowed.step();
  }
  EXPECT_LT(move(slowed), 0.02 * move(steady));
}

TEST(Training, WithDensificationIsTheSameForAnyNumberOfThreads) {
  for (const Blending blending : {Blending::Normalised, Blending::Additive, Blending::Alpha}) {
    SCOPED_TRACE(blendingName(blending));
    TrainedScene scene(blending);
    useAll(scene.plan);
    if (blending == Blending::Additive) scene.plan.densify.thresholds.opacity = 0.02;
    GaussianField first;
    for (int threads : {1, 2, 5}) {
      ThreadPool pool(threads);
      Trainer trainer = scene.trainer(pool);
      while (trainer.step())
        EXPECT_LE(trainer.field().size(), 280);
      if (threads == 1) {
        first = trainer.field();
        EXPECT_GT(trainer.densified().split + trainer.densified().cloned, 20);
        EXPECT_LT(trainer.loss(), 0.5 * trainer.losses().front());
        EXPECT_EQ(trainer.losses().size(), 60u);
      }
      EXPECT_TRUE(sameGaussians(trainer.field(), first)) << threads << " threads";
    }
  }
}

TEST(Training, GoesOnFromAnyIterationAsIfItHadNotStopped) {
  TrainedScene scene;
  useAll(scene.plan);
  scene.plan.coarseIterations = 4;
  ThreadPool pool(2);
  Trainer whole = scene.trainer(pool);
  while (whole.step()) {
  }
  for (int stop : {1, 3, 4, 6, 7, 8, 13, 29, 30, 31, 59}) {
    Trainer before = scene.trainer(pool);
    while (before.iteration() < stop)
      before.step();
    TrainedScene rest = scene;
    rest.field = before.field();
    Trainer after = rest.trainer(pool);
    after.restore(before.optimizer(), stop);
    while (after.step()) {
    }
    EXPECT_TRUE(sameGaussians(after.field(), whole.field())) << "stopped after iteration " << stop;
    EXPECT_EQ(after.losses(), whole.losses());
  }
}

/// Two scans, of which iterations take one in turn.
TEST(Training, TakesSubsetsOfTheObservationsInTurn) {
  TrainedScene scene;
  ThreadPool pool(2);
  std::vector<Observation> both = observe(scene.stack, {}, {200, 0}, false);
  both.push_back(both.front());
  both[1].subset = 1;
  for (float& value : both[1].target)
    value = 0.8f * value + 0.1f;
  const auto trainerOf = [&](std::vector<Observation> observations) {
    return Trainer(scene.field, std::move(observations), scene.plan, kernelSet("scalar"), pool);
  };
  for (const int coarse : {0, 2}) {
    scene.plan.coarseIterations = coarse;
    scene.plan.subsets = 1;
    Trainer first = trainerOf({both[0]}), second = trainerOf({both[1]});
    scene.plan.subsets = 2;
    Trainer turns = trainerOf(both);
    first.step();
    turns.step();
    EXPECT_TRUE(sameGaussians(turns.field(), first.field()));
    EXPECT_EQ(turns.mse(), first.mse());
    const OptimizerState state = turns.optimizer();
    TrainedScene rest = scene;
    rest.field = turns.field();
    second.restart(rest.field);
    second.restore(state, 1);
    second.step();
    turns.step();
    EXPECT_TRUE(sameGaussians(turns.field(), second.field()));
    EXPECT_NEAR(turns.mse(), 0.5 * (first.mse() + second.mse()), 1e-6) << "the last of each subset";
  }
}

TEST(StopRule, LooksBackBeyondAResumption) {
  TrainedScene scene;
  scene.plan.iterations = 1000;
  scene.plan.paperStopRule = true;
  ThreadPool pool(2);
  Trainer whole = scene.trainer(pool);
  while (whole.step()) {
  }
  const int end = whole.iteration();
  ASSERT_GT(end, 100);
  ASSERT_LT(end, 1000);
  TrainedScene rest = scene;
  Trainer before = scene.trainer(pool);
  while (before.iteration() < end - 10)
    before.step();
  rest.field = before.field();
  Trainer after = rest.trainer(pool);
  after.restore(before.optimizer(), end - 10);
  while (after.step()) {
  }
  EXPECT_EQ(after.iteration(), end);
  EXPECT_TRUE(sameGaussians(after.field(), whole.field()));
}

TEST(GradientAccumulator, MeansTheSameAtAnyVolumeAndVoxelSize) {
  const auto strongest = [](const TrainedScene& s) {
    ThreadPool pool(2);
    TrainedScene scene = s;
    scene.plan.densify.every = 20;
    Trainer trainer = scene.trainer(pool);
    trainer.step();
    std::vector<float> gradients = trainer.gradients();
    EXPECT_EQ(gradients.size(), static_cast<std::size_t>(trainer.field().size()));
    std::sort(gradients.begin(), gradients.end(), std::greater<>());
    gradients.resize(100);
    return gradients;
  };
  const auto reference = strongest(TrainedScene(Blending::Normalised, 18, 1, 18));
  EXPECT_GT(reference.front(), 0.01);
  const auto larger =
      strongest(TrainedScene(Blending::Normalised, 30, 1, 18)); // the same phantom, empty beside it
  int close = 0;
  for (std::size_t i = 0; i < 100; ++i)
    close += std::abs(larger[i] - reference[i]) < 0.1 * reference[i] + 1e-4;
  EXPECT_GT(close, 90);
  const auto finer = strongest([] { // the same voxels at half the size
    TrainedScene scene(Blending::Normalised, 18, 1, 18);
    scene.stack.image.geometry.spacing = {0.5, 0.5, 0.5};
    for (Gaussian& g : scene.field.gaussians)
      for (int a = 0; a < 3; ++a) {
        g.mean[a] *= 0.5f;
        g.logScale[a] -= std::log(2.f);
      }
    scene.plan.densify.voxel = 0.5;
    return scene;
  }());
  for (std::size_t i = 0; i < 100; ++i)
    EXPECT_NEAR(finer[i], reference[i], 1e-3 * reference[i]);
}
