#include "FitScene.h"
#include "ThrownError.h"

#include "Core/Fit/CpuFitDevice.h"
#include "Core/Render/Kernels.h"
#include "Cuda/FitMemory.h"

using namespace innergs;
using namespace innergs::testing;

namespace {

class Fits : public ::testing::TestWithParam<std::tuple<Where, FitCase>> {};

TEST_P(Fits, IterationAsTheCpu) {
  const auto& [where, c] = GetParam();
  INNERGS_EXECUTOR_OR_SKIP(executor, where);
  const Scene scene(c);
  ThreadPool pool(1);
  CpuFitDevice cpu(scene.request(), kernelSet("scalar"), pool);
  cuda::Fit fit(std::move(executor), scene.request());
  const Adam adam(scene.field.size());
  for (bool coarse : {true, false}) {
    SCOPED_TRACE(coarse ? "coarse" : "fine");
    cpu.upload(scene.field, adam, {});
    fit.upload(scene.field, adam, {});
    IterationOptions options = optionsOf(scene, 1);
    options.coarse = coarse;
    const LossSum expected = cpu.iterate(options), found = fit.iterate(options);
    EXPECT_EQ(found.samples, expected.samples);
    EXPECT_NEAR(found.loss, expected.loss, 1e-4 * expected.loss);
    EXPECT_NEAR(found.squared, expected.squared, 1e-4 * expected.squared);
    Adam foundAdam(0), cpuAdam(0);
    GradientAccumulator foundAccumulator, cpuAccumulator;
    GaussianField field;
    fit.download(&field, &foundAdam, &foundAccumulator);
    cpu.download(nullptr, &cpuAdam, &cpuAccumulator);
    ASSERT_EQ(field.size(), scene.field.size());
    EXPECT_EQ(field.blending, scene.field.blending);
    EXPECT_FALSE(same(field, scene.field));
    EXPECT_LE(relativeError(foundAdam.moment1, cpuAdam.moment1), 1e-4);
    EXPECT_LE(relativeError(foundAdam.moment2, cpuAdam.moment2), 2e-4);
    EXPECT_LE(relativeError(foundAccumulator.sum, cpuAccumulator.sum), 1e-4);
    EXPECT_EQ(foundAccumulator.iterations, cpuAccumulator.iterations);
  }
  const LossSum a = fit.evaluate(scene.field), b = cpu.evaluate(scene.field);
  EXPECT_NEAR(a.loss, b.loss, 1e-4 * b.loss);
}

TEST_P(Fits, TrainToTheSameQuality) {
  const auto& [where, c] = GetParam();
  FitCase still = c; // no relocation or densification
  still.relocate = still.densify = false;
  for (const FitCase& each : {still, c}) {
    INNERGS_EXECUTOR_OR_SKIP(executor, where);
    const bool moves = each.relocate || each.densify;
    SCOPED_TRACE(moves ? "moving Gaussians" : "");
    Scene scene(each);
    LearningRates& r = scene.plan.rates; // last bits matter in large steps of few Gaussians
    for (double* rate : {&r.mean, &r.logScale, &r.quaternion, &r.logWeight, &r.intensity, &r.slope})
      *rate *= 0.25;
    std::int64_t expectedCount = 0, count = 0;
    const double expected = scene.quality(nullptr, nullptr, &expectedCount);
    const double found =
        scene.quality(std::make_unique<cuda::Fit>(std::move(executor), scene.request()), nullptr, &count);
    EXPECT_GT(expected, 15);
    EXPECT_NEAR(found, expected, moves && where != Where::Host ? 0.3 : 0.05);
    EXPECT_NEAR(static_cast<double>(count), static_cast<double>(expectedCount), 0.02 * expectedCount);
  }
}

/// The first scan of a scene, and one of the same grid with other values.
std::vector<Observation> twoScans(const Scene& scene) {
  Observation other = scene.observations.front();
  for (std::size_t i = 0; i < other.target.size(); ++i)
    other.target[i] = 0.8f * other.target[i] + 0.1f;
  std::fill_n(other.weight.begin(), 40, std::uint8_t{0});
  other.samples = std::count_if(other.weight.begin(), other.weight.end(), [](auto w) { return w > 0; });
  return {scene.observations.front(), other};
}

TEST_P(Fits, IterationOfOneSubsetAsTheCpu) {
  const auto& [where, c] = GetParam();
  INNERGS_EXECUTOR_OR_SKIP(executor, where);
  Scene scene(c);
  scene.observations = twoScans(scene);
  scene.observations[1].subset = 1;
  ThreadPool pool(1);
  CpuFitDevice cpu(scene.request(), kernelSet("scalar"), pool);
  cuda::Fit fit(std::move(executor), scene.request());
  std::int64_t samples = 0;
  for (const int subset : {0, 1, -1}) {
    SCOPED_TRACE(subset);
    cpu.upload(scene.field, Adam(scene.field.size()), {});
    fit.upload(scene.field, Adam(scene.field.size()), {});
    IterationOptions options = optionsOf(scene, 1);
    options.subset = subset;
    const LossSum expected = cpu.iterate(options), found = fit.iterate(options);
    EXPECT_EQ(found.samples, expected.samples);
    EXPECT_NEAR(found.loss, expected.loss, 1e-4 * expected.loss);
    samples += subset < 0 ? -found.samples : found.samples;
    Adam foundAdam(0), cpuAdam(0);
    fit.download(nullptr, &foundAdam, nullptr);
    cpu.download(nullptr, &cpuAdam, nullptr);
    EXPECT_LE(relativeError(foundAdam.moment1, cpuAdam.moment1), 1e-4);
  }
  EXPECT_EQ(samples, 0) << "the subsets are the whole";
}

/// Two scans of one grid, as the frames of a dynamic scan are.
TEST_P(Fits, GradientOfOneScanAsTheCpu) {
  const auto& [where, c] = GetParam();
  INNERGS_EXECUTOR_OR_SKIP(executor, where);
  Scene scene(c);
  scene.observations = twoScans(scene);
  ThreadPool pool(1);
  CpuFitDevice cpu(scene.request(), kernelSet("scalar"), pool);
  cuda::Fit fit(std::move(executor), scene.request());
  fit.upload(scene.field, Adam(scene.field.size()), {});
  GaussianField moved = scene.field;
  std::vector<float> before;
  for (const std::int64_t scan : {1, 0, 1}) {
    SCOPED_TRACE(scan);
    for (Gaussian& g : moved.gaussians)
      g.mean[0] += 0.07f;
    std::vector<float> found(16 * moved.gaussians.size(), 7.f), expected(found.size(), 3.f);
    const LossSum a = fit.gradient(moved, scan, found), b = cpu.gradient(moved, scan, expected);
    EXPECT_EQ(a.samples, b.samples);
    EXPECT_EQ(a.samples, scene.observations[scan].samples);
    EXPECT_NEAR(a.loss, b.loss, 1e-4 * b.loss);
    EXPECT_NEAR(a.squared, b.squared, 1e-4 * b.squared);
    EXPECT_LE(relativeError(found, expected), 1e-4);
    const LossSum alone = fit.gradient(moved, scan, {});
    EXPECT_NEAR(alone.loss, a.loss, 1e-4 * a.loss);
    EXPECT_NE(found, before);
    before = found;
  }
  GaussianField field;
  fit.download(&field, nullptr, nullptr);
  EXPECT_TRUE(same(field, scene.field)) << "it changes nothing";
}

TEST_P(Fits, StopAndLeaveTheStateAsItWas) {
  const auto& [where, c] = GetParam();
  INNERGS_EXECUTOR_OR_SKIP(executor, where);
  const Scene scene(c);
  std::stop_source stop;
  cuda::Fit fit(std::move(executor), scene.request(stop.get_token()));
  fit.upload(scene.field, Adam(scene.field.size()), {});
  fit.iterate(optionsOf(scene, 1));
  GaussianField before, after;
  Adam adamBefore(0), adamAfter(0);
  fit.download(&before, &adamBefore, nullptr);
  stop.request_stop();
  EXPECT_EQ(test::codeOf([&] { fit.iterate(optionsOf(scene, 2)); }), ErrorCode::Cancelled);
  fit.download(&after, &adamAfter, nullptr);
  EXPECT_TRUE(same(before, after));
  EXPECT_EQ(adamBefore.moment2, adamAfter.moment2);
}

INSTANTIATE_TEST_SUITE_P(Everywhere, Fits,
                         ::testing::Combine(::testing::ValuesIn(kEverywhere), ::testing::ValuesIn(kFitCases)),
                         [](const auto& info) {
                           return whereName(std::get<0>(info.param)) + std::get<1>(info.param).name;
                         });

TEST(FitOnTheHostExecutor, ComputesTheSameInSmallerSlabs) {
  for (const FitCase& c : kFitCases) {
    SCOPED_TRACE(c.name);
    const Scene scene(c);
    const cuda::FitMemory memory = cuda::fitMemory(scene.request());
    ASSERT_LT(memory.least, memory.most);
    cuda::Fit whole(cuda::makeHostExecutor(), scene.request());
    cuda::Fit slabs(cuda::makeHostExecutor(memory.least + (memory.most - memory.least) / 5), scene.request());
    EXPECT_EQ(whole.slabs(), 1);
    EXPECT_GT(slabs.slabs(), 1);
    for (cuda::Fit* fit : {&whole, &slabs})
      fit->upload(scene.field, Adam(scene.field.size()), {});
    for (int step = 1; step <= 2; ++step) {
      const LossSum a = whole.iterate(optionsOf(scene, step)), b = slabs.iterate(optionsOf(scene, step));
      EXPECT_EQ(a.samples, b.samples);
      EXPECT_NEAR(a.loss, b.loss, 1e-4 * a.loss);
    }
  }
}

TEST(FitOnTheHostExecutor, CountsTheMemoryThatDensificationTakes) {
  for (const FitCase& c : kFitCases) {
    SCOPED_TRACE(c.name);
    const Scene scene(c);
    FitRequest request = scene.request();
    request.gaussians = 100'000;
    request.rules.densify.every = 0;
    const cuda::FitMemory fixed = cuda::fitMemory(request);
    request.rules.densify.every = 10;
    const cuda::FitMemory growing = cuda::fitMemory(request);
    EXPECT_GE(growing.most, fixed.most + 300 * request.gaussians);
    EXPECT_GE(growing.least, fixed.least);
  }
}

TEST(FitOnTheHostExecutor, SaysWhenItCannotFit) {
  const Scene scene(kFitCases[0]);
  const cuda::FitMemory memory = cuda::fitMemory(scene.request());
  EXPECT_EQ(test::codeOf([&] { cuda::Fit fit(cuda::makeHostExecutor(memory.least / 2), scene.request()); }),
            ErrorCode::Memory);
}

// An allocation that fails at any point of an iteration: the iteration succeeds with smaller slabs, or throws
// Memory and leaves the state unchanged.
TEST(FitOnTheHostExecutor, SurvivesAnyFailedAllocation) {
  for (const FitCase& c : kFitCases) {
    SCOPED_TRACE(c.name);
    const Scene scene(c, 11);
    std::int64_t samples = 0;
    for (const Observation& o : scene.observations)
      samples += o.samples;
    bool failed = false, smaller = false;
    for (int allocation = 1; allocation < 1000; ++allocation) {
      auto executor = cuda::makeHostExecutor();
      cuda::Executor& memory = *executor;
      cuda::Fit fit(std::move(executor), scene.request());
      fit.upload(scene.field, Adam(scene.field.size()), {});
      cuda::failAllocations(memory, allocation, 1);
      bool all = false;
      try {
        fit.iterate(optionsOf(scene, 1));
        all = cuda::allocationsToFailure(memory) > 0;
        smaller = smaller || fit.slabs() > 1;
      } catch (const Error& error) {
        failed = true;
        ASSERT_EQ(error.code(), ErrorCode::Memory);
        GaussianField field;
        fit.download(&field, nullptr, nullptr);
        ASSERT_TRUE(same(field, scene.field));
      }
      cuda::failAllocations(memory, 0, 0);
      GaussianField field;
      fit.download(&field, nullptr, nullptr);
      EXPECT_NO_THROW(fit.iterate(optionsOf(scene, 1)));
      if (all) break; // the iteration made fewer allocations
    }
    EXPECT_TRUE(smaller);
    EXPECT_FALSE(failed); // after one failure, smaller slabs fit
    // Memory that stays short for a while.
    for (int allocation = 1; allocation < 40; allocation += 3) {
      auto executor = cuda::makeHostExecutor();
      cuda::Executor& memory = *executor;
      cuda::Fit fit(std::move(executor), scene.request());
      fit.upload(scene.field, Adam(scene.field.size()), {});
      cuda::failAllocations(memory, allocation, 1 << 30);
      bool iterated = false;
      try {
        fit.iterate(optionsOf(scene, 1));
        iterated = true;
      } catch (const Error&) {
      }
      EXPECT_TRUE(iterated || cuda::allocationsToFailure(memory) == 0);
      cuda::failAllocations(memory, 0, 0);
      GaussianField field;
      fit.download(&field, nullptr, nullptr);
      EXPECT_EQ(same(field, scene.field), !iterated);
      EXPECT_EQ(fit.iterate(optionsOf(scene, 1)).samples, samples) << "a slab is missing";
    }
  }
}

} // namespace
