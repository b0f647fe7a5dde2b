// Work that fails for lack of memory and is repeated with less.
#include "FitScene.h"
#include "ThrownError.h"

#include <functional>

using namespace innergs;
using namespace innergs::testing;

namespace {

struct State {
  GaussianField field;
  Adam adam{0};
  GradientAccumulator accumulator;
  explicit State(cuda::Fit& fit) { fit.download(&field, &adam, &accumulator); }

  void expectAs(const State& expected) const {
    EXPECT_TRUE(same(field, expected.field));
    EXPECT_EQ(adam.moment1, expected.adam.moment1);
    EXPECT_EQ(adam.moment2, expected.adam.moment2);
    EXPECT_EQ(accumulator.sum, expected.accumulator.sum);
    EXPECT_EQ(accumulator.iterations, expected.accumulator.iterations);
  }
};

/// A fit after three iterations, the second of which relocates if the scene does.
struct StartedFit {
  cuda::Executor* memory;
  std::unique_ptr<cuda::Fit> fit;

  explicit StartedFit(const Scene& scene) {
    auto executor = cuda::makeHostExecutor();
    memory = executor.get();
    fit = std::make_unique<cuda::Fit>(std::move(executor), scene.request());
    fit->upload(scene.field, Adam(scene.field.size()), {});
    for (int step = 1; step <= 3; ++step) {
      IterationOptions options = optionsOf(scene, step);
      if (step == 2) options.relocate = RelocationPlan{0.05, scene.plan.bounds.minLogScale};
      fit->iterate(options);
    }
  }
};

/// Fails each allocation of `work` in turn, once: it must complete anyway. Calls check(fit, free bytes) each
/// time.
int failingOnce(const Scene& scene, const std::function<void(cuda::Fit&)>& work,
                const std::function<void(cuda::Fit&, std::size_t)>& check) {
  for (int allocation = 1; allocation < 200; ++allocation) {
    SCOPED_TRACE(allocation);
    StartedFit started(scene);
    cuda::failAllocations(*started.memory, allocation, 1);
    EXPECT_NO_THROW(work(*started.fit));
    const bool failed = cuda::allocationsToFailure(*started.memory) == 0;
    cuda::failAllocations(*started.memory, 0, 0);
    if (!failed) return allocation - 1;
    check(*started.fit, started.memory->freeBytes());
  }
  ADD_FAILURE() << "never ends";
  return 0;
}

Scene densifying(Blending blending) {
  Scene scene({"", blending, false, SliceProfile::Point, 0, false, true}, 11);
  scene.plan.densify.thresholds.split = 0.5;
  return scene;
}

class Retry : public ::testing::TestWithParam<Blending> {};

TEST_P(Retry, DensifiesWithTheMemoryThatIterationsKept) {
  const Scene scene = densifying(GetParam());
  StartedFit plain(scene);
  const std::int64_t before = State(*plain.fit).field.size();
  const DensifyCounts expected = plain.fit->densify();
  ASSERT_GT(expected.split + expected.cloned, 0);
  const State grown(*plain.fit);
  EXPECT_EQ(grown.field.size(), before + expected.split + expected.cloned - expected.pruned);
  const std::size_t kept = plain.memory->freeBytes();
  const LossSum next = plain.fit->iterate(optionsOf(scene, 4));
  const State after(*plain.fit);

  const int allocations = failingOnce(
      scene,
      [&](cuda::Fit& fit) {
        const DensifyCounts counts = fit.densify();
        EXPECT_EQ(counts.split, expected.split);
        EXPECT_EQ(counts.cloned, expected.cloned);
        EXPECT_EQ(counts.pruned, expected.pruned);
      },
      [&](cuda::Fit& fit, std::size_t free) {
        EXPECT_GT(free, kept) << "the buffers of the iterations were not given back";
        State(fit).expectAs(grown);
        EXPECT_EQ(fit.iterate(optionsOf(scene, 4)).loss, next.loss);
        State(fit).expectAs(after);
      });
  EXPECT_GT(allocations, 10);
}

TEST_P(Retry, LeavesTheFitAsItWasWhereTheSecondTryFailsToo) {
  const Scene scene = densifying(GetParam());
  StartedFit plain(scene);
  const State start(*plain.fit);
  plain.fit->densify();
  const State grown(*plain.fit);
  for (const int allocation : {1, 2, 5, 9, 12}) {
    SCOPED_TRACE(allocation);
    StartedFit started(scene);
    cuda::failAllocations(*started.memory, allocation, 1 << 30);
    EXPECT_EQ(test::codeOf([&] { started.fit->densify(); }), ErrorCode::Memory);
    cuda::failAllocations(*started.memory, 0, 0);
    State(*started.fit).expectAs(start);
    started.fit->densify();
    State(*started.fit).expectAs(grown);
  }
}

TEST_P(Retry, EvaluatesInSmallerSlabs) {
  const Scene scene = densifying(GetParam());
  GaussianField other = scene.field;
  for (Gaussian& g : other.gaussians)
    g.intensity *= 0.9f;
  other.gaussians.push_back(other.gaussians.front()); // more than the fit has, so buffers must grow
  StartedFit plain(scene);
  const State start(*plain.fit);
  const LossSum expected = plain.fit->evaluate(other);
  LossSum found;
  const int allocations = failingOnce(
      scene, [&](cuda::Fit& fit) { found = fit.evaluate(other); },
      [&](cuda::Fit& fit, std::size_t) {
        EXPECT_EQ(found.samples, expected.samples);
        EXPECT_NEAR(found.loss, expected.loss, 1e-9 * expected.loss);
        EXPECT_GT(fit.slabs(), 1);
        State(fit).expectAs(start);
      });
  EXPECT_GT(allocations, 0);
}

TEST_P(Retry, GathersTheGradientInSmallerSlabs) {
  const Scene scene = densifying(GetParam());
  StartedFit plain(scene);
  const State start(*plain.fit);
  GaussianField other = scene.field;
  other.gaussians.push_back(other.gaussians.front());
  std::vector<float> expected(16 * other.gaussians.size()), found(expected.size());
  const LossSum sum = plain.fit->gradient(other, 0, expected);
  LossSum again;
  const int allocations = failingOnce(
      scene, [&](cuda::Fit& fit) { again = fit.gradient(other, 0, found); },
      [&](cuda::Fit& fit, std::size_t) {
        EXPECT_EQ(again.samples, sum.samples);
        EXPECT_LE(relativeError(found, expected), 1e-5);
        EXPECT_GT(fit.slabs(), 1);
        State(fit).expectAs(start);
      });
  EXPECT_GT(allocations, 0);
}

INSTANTIATE_TEST_SUITE_P(Everywhere, Retry,
                         ::testing::Values(Blending::Normalised, Blending::Additive, Blending::Alpha),
                         [](const auto& info) { return blendingName(info.param); });

// Possible only with a device's allocator: freed pieces make room for one as large as all of them.
TEST(RetryOnADevice, PiecesGivenBackMakeRoomForOne) {
  INNERGS_EXECUTOR_OR_SKIP(executor, Where::Device);
  const std::size_t free = executor->freeBytes(), piece = free / 100;
  std::vector<void*> pieces;
  for (int i = 0; i < 90; ++i)
    pieces.push_back(executor->allocate(piece));
  EXPECT_EQ(test::codeOf([&] { executor->allocate(free); }), ErrorCode::Memory);
  for (void* memory : pieces)
    executor->release(memory);
  EXPECT_GT(executor->freeBytes(), free / 100 * 95);
  void* whole = nullptr;
  EXPECT_NO_THROW(whole = executor->allocate(90 * piece));
  const float written = 7;
  float read = 0;
  char* last = static_cast<char*>(whole) + 90 * piece - sizeof read;
  last -= reinterpret_cast<std::uintptr_t>(last) % sizeof read;
  executor->upload(last, &written, sizeof written);
  executor->download(&read, last, sizeof read);
  EXPECT_EQ(read, written);
  executor->release(whole);
}

} // namespace
