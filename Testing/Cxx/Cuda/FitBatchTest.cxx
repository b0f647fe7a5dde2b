#include "FitScene.h"
#include "RoundingExecutor.h"

#include "Core/Render/Kernels.h"

#include <stop_token>

using namespace innergs;
using namespace innergs::testing;

namespace {

/// Iterations of which some use half the resolution, some relocate, and Gaussians grow fast.
std::vector<IterationOptions> iterationsOf(const Scene& scene, int count, double growth = 0.09) {
  std::vector<IterationOptions> iterations;
  for (int step = 1; step <= count; ++step) {
    IterationOptions options = optionsOf(scene, step);
    options.coarse = step <= 3;
    options.accumulateGradients = step > 6;
    options.rates.logScale = growth;
    if (step % 5 == 0) options.relocate = RelocationPlan{0.05, scene.plan.bounds.minLogScale};
    iterations.push_back(options);
  }
  return iterations;
}

struct Reached {
  std::vector<double> losses;
  GaussianField field;
  Adam adam{0};
  GradientAccumulator accumulator;

  void add(const LossSum& sum) { losses.push_back(sum.loss); }
  void fetch(FitDevice& fit) { fit.download(&field, &adam, &accumulator); }
};

void expectSame(const Reached& a, const Reached& b) {
  EXPECT_EQ(a.losses, b.losses);
  EXPECT_TRUE(same(a.field, b.field));
  EXPECT_EQ(a.adam.moment1, b.adam.moment1);
  EXPECT_EQ(a.adam.moment2, b.adam.moment2);
  EXPECT_EQ(a.accumulator.sum, b.accumulator.sum);
  EXPECT_EQ(a.accumulator.iterations, b.accumulator.iterations);
}

Reached oneByOne(const Scene& scene, std::span<const IterationOptions> iterations) {
  cuda::Fit fit(cuda::makeHostExecutor(), scene.request());
  fit.upload(scene.field, Adam(scene.field.size()), {});
  Reached reached;
  for (const IterationOptions& options : iterations)
    reached.add(fit.iterate(options));
  reached.fetch(fit);
  return reached;
}

/// Requests a stop in the n-th update of the Gaussians.
struct StopsInAnUpdate {
  inline static std::stop_source stop;
  inline static int updatesLeft = 0;

  template <class Kernel>
  static void run(const Kernel& kernel, std::int64_t blocks) {
    cuda::runOnHost(kernel, blocks);
    if constexpr (std::is_same_v<Kernel, cuda::Update>)
      if (--updatesLeft == 0) stop.request_stop();
  }
};

} // namespace

TEST(IterationsOfOneWait, GiveTheSameBitsAsOneByOne) {
  for (const FitCase& c : kFitCases)
    for (const double growth : {0.09, 0.9}) { // the latter needs ever more room for pairs
      SCOPED_TRACE(std::string(c.name) + (growth > 0.5 ? ", growing" : ""));
      const Scene scene(c, 13);
      const auto iterations = iterationsOf(scene, 12, growth);
      const Reached expected = oneByOne(scene, iterations);
      auto executor = cuda::makeHostExecutor();
      cuda::Executor& host = *executor;
      FitRequest request = scene.request();
      if (growth > 0.5) request.gaussians = 1; // room for hardly any pairs at first
      cuda::Fit fit(std::move(executor), request);
      fit.upload(scene.field, Adam(scene.field.size()), {});
      Reached found;
      const int before = cuda::downloads(host);
      for (const LossSum& sum : fit.iterateMany(iterations))
        found.add(sum);
      const int waits = cuda::downloads(host) - before;
      if (growth < 0.5)
        EXPECT_EQ(waits, 1);
      else
        EXPECT_GT(waits, 1) << "the test needs a fit that runs out of room";
      found.fetch(fit);
      expectSame(found, expected);
    }
}

TEST(IterationsOfOneWait, AreAsManyAsTheTrainerAllows) {
  for (const FitCase& c : kFitCases) {
    SCOPED_TRACE(c.name);
    Scene scene(c, 13);
    scene.plan.iterations = 30;
    for (const bool comparing : {false, true}) {
      scene.plan.schedule = comparing ? Schedule::Plateau : Schedule::Exponential;
      ThreadPool pool(1);
      auto executor = cuda::makeHostExecutor();
      cuda::Executor& host = *executor;
      Trainer one(scene.field, scene.request(), scene.plan, kernelSet("scalar"), pool,
                  std::make_unique<cuda::Fit>(cuda::makeHostExecutor(), scene.request()));
      Trainer many(scene.field, scene.request(), scene.plan, kernelSet("scalar"), pool,
                   std::make_unique<cuda::Fit>(std::move(executor), scene.request()));
      const int coarse = scene.plan.coarseIterations;
      ASSERT_GT(coarse, 0);
      int steps = 0;
      while (one.step()) {
      }
      for (int before = 0; many.step(16); before = many.iteration()) {
        ++steps;
        EXPECT_TRUE(before >= coarse || many.iteration() <= coarse) << "half resolution tells no time";
        EXPECT_EQ(static_cast<int>(many.losses().size()), many.iteration());
      }
      // Full resolution and every densification end a batch of iterations; so does every loss that decides
      // how the fit continues.
      const int waits = comparing ? 30 : c.densify ? 4 : 3;
      EXPECT_EQ(steps, waits);
      const int state = 3; // field and moments, at the end
      EXPECT_EQ(cuda::downloads(host), waits + (c.densify ? 2 : 0) + state);
      EXPECT_EQ(one.losses(), many.losses());
      EXPECT_EQ(one.gaussians(), many.gaussians());
      EXPECT_TRUE(same(one.field(), many.field()));
    }
  }
}

TEST(IterationsOfOneWait, KeepThoseThatWereDoneWhenStopped) {
  const Scene scene(kFitCases[0], 13);
  const auto iterations = iterationsOf(scene, 60);
  for (const int updates : {1, 2, 17, 60}) {
    std::stop_source stop;
    StopsInAnUpdate::stop = stop;
    StopsInAnUpdate::updatesLeft = updates;
    auto executor = std::make_unique<cuda::HostExecutor<StopsInAnUpdate>>(std::size_t{1} << 40);
    cuda::Fit fit(std::move(executor), scene.request(stop.get_token()));
    fit.upload(scene.field, Adam(scene.field.size()), {});
    Reached found;
    try {
      for (const LossSum& sum : fit.iterateMany(iterations))
        found.add(sum);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::Cancelled);
    }
    found.fetch(fit);
    expectSame(found, oneByOne(scene, {iterations.data(), found.losses.size()}));
    EXPECT_TRUE(stop.stop_requested());
    EXPECT_THROW(fit.iterateMany(iterations), Error);
  }
}

TEST(IterationsOfOneWait, KeepThoseThatWereDoneWhenMemoryEnds) {
  const Scene scene(kFitCases[0], 11);
  const auto iterations = iterationsOf(scene, 8);
  bool some = false, none = false;
  for (int allocation = 1; allocation < 60; ++allocation) {
    SCOPED_TRACE(allocation);
    auto executor = cuda::makeHostExecutor();
    cuda::Executor& memory = *executor;
    cuda::Fit fit(std::move(executor), scene.request());
    fit.upload(scene.field, Adam(scene.field.size()), {});
    cuda::failAllocations(memory, allocation, 1 << 30);
    Reached found;
    try {
      for (const LossSum& sum : fit.iterateMany(iterations))
        found.add(sum);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::Memory);
    }
    const bool failed = cuda::allocationsToFailure(memory) == 0;
    cuda::failAllocations(memory, 0, 0);
    found.fetch(fit);
    expectSame(found, oneByOne(scene, {iterations.data(), found.losses.size()}));
    if (!failed) break;
    some = some || (!found.losses.empty() && found.losses.size() < iterations.size());
    none = none || found.losses.empty();
  }
  EXPECT_TRUE(some);
  EXPECT_TRUE(none);
}
