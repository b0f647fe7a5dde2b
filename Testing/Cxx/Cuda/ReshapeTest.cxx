#include "Executors.h"
#include "RandomFields.h"

#include "Core/Fit/FitDevice.h"
#include "Cuda/Reshape.h"

using namespace innergs;
using namespace innergs::testing;

namespace {

/// The state of a fit in mid-training: moments and gradients of any size, some of them equal.
FitState stateOf(int gaussians, Blending blending, int seed) {
  FitState state;
  state.field = randomField(gaussians, {}, seed, blending, blending == Blending::Normalised);
  Numbers random(seed + 1);
  state.adam = Adam(gaussians);
  for (float& m : state.adam.moment1)
    m = static_cast<float>(random(-1, 1));
  for (float& m : state.adam.moment2)
    m = static_cast<float>(std::floor(random(0, 40)) / 40);
  for (int i = 0; i < gaussians; i += 7)
    std::fill_n(state.adam.moment2.begin() + 16 * i, 16, 0.f);
  for (int i = 0; i < gaussians; ++i) {
    state.accumulator.sum.push_back(static_cast<float>(std::floor(random(0, 30)) / 10));
    state.field.gaussians[i].logWeight = static_cast<float>(random(-6, 3));
  }
  state.accumulator.iterations = 3;
  return state;
}

/// Copies a state to an executor and back.
class OnExecutor {
public:
  OnExecutor(cuda::Executor& executor, const FitState& state) : executor_(executor), fit(executor) {
    const std::int64_t n = state.field.size();
    fit.reserve(executor, n);
    fit.count = n;
    executor.upload(fit.field(), state.field.gaussians.data(), n * sizeof(Gaussian));
    fit.moment1.upload(state.adam.moment1.data(), 16 * n);
    fit.moment2.upload(state.adam.moment2.data(), 16 * n);
    fit.gradientSums.upload(state.accumulator.sum.data(), n);
  }

  void expectAs(const FitState& expected) const {
    const std::int64_t n = fit.count;
    ASSERT_EQ(n, expected.field.size());
    std::vector<float> g(16 * n), m1(16 * n), m2(16 * n);
    fit.gaussians.download(g.data(), 16 * n);
    fit.moment1.download(m1.data(), 16 * n);
    fit.moment2.download(m2.data(), 16 * n);
    // The order matters too: neighbours in it are dissimilar.
    const auto* gaussians = reinterpret_cast<const float*>(expected.field.gaussians.data());
    for (int p = 0; p < 16; ++p)
      EXPECT_LE(relativeError(g, {gaussians, g.size()}, p, 16), 1e-5) << "parameter " << p;
    EXPECT_EQ(m1, expected.adam.moment1);
    EXPECT_EQ(m2, expected.adam.moment2);
  }

  void relocate(const RelocationPlan& plan, const cuda::Guard& guard = {}) {
    cuda::Relocation relocation(executor_);
    cuda::Buffer<float> spare(executor_);
    relocation.reserve(fit.count);
    spare.reserve(16 * fit.count);
    relocation.run(fit, spare, plan, guard);
  }

private:
  cuda::Executor& executor_;

public:
  cuda::FitBuffers fit;
};

class Reshaping : public ::testing::TestWithParam<std::tuple<Where, Blending>> {};

TEST_P(Reshaping, RelocatesAsTheCpu) {
  const auto& [where, blending] = GetParam();
  INNERGS_EXECUTOR_OR_SKIP(executor, where);
  for (const int n : {3, 60, 9000}) // nothing moves; one block; several boxes
    for (const double share : {0.02, 0.4, 0.7, 1.0}) {
      SCOPED_TRACE(std::to_string(n) + " Gaussians, share " + std::to_string(share));
      FitState expected = stateOf(n, blending, 5);
      OnExecutor found(*executor, expected);
      const RelocationPlan plan{share, -0.5};
      found.relocate(plan);
      relocateGaussians(expected.field, expected.adam, plan);
      found.expectAs(expected);
    }
}

TEST_P(Reshaping, DensifiesAsTheCpu) {
  const auto& [where, blending] = GetParam();
  INNERGS_EXECUTOR_OR_SKIP(executor, where);
  struct Plan {
    const char* name;
    DensifyThresholds thresholds; // gradient, split, opacity, size
    std::int64_t limit;
  };
  for (const int n : {60, 9000})
    for (const Plan& p :
         {Plan{"all of it", {0.3, 4, 0.05, 4}, 100000}, Plan{"little room", {0.3, 4, 0.05, 4}, n},
          Plan{"no room", {0.3, 4, 0.05, 4}, 1}, Plan{"pruned alone", {1e9, 4, 0.3, 4}, 100000},
          Plan{"clone alone", {0.1, 1e9, 0.0, 1e9}, 2 * n}, Plan{"split alone", {0.1, 0, 0.0, 1e9}, 2 * n},
          Plan{"nothing to do", {1e9, 4, 0.0, 1e9}, 100000},
          Plan{"nothing would be left", {0.3, 4, 1e9, 4}, 100000}}) {
      SCOPED_TRACE(std::to_string(n) + " Gaussians, " + p.name);
      FitState expected = stateOf(n, blending, 9);
      OnExecutor found(*executor, expected);
      DensifyPlan plan;
      plan.every = 1;
      plan.thresholds = p.thresholds;
      plan.limit = p.limit;
      plan.voxel = 0.8;
      plan.minLogScale = -0.5;
      const DensifyCounts counts =
          cuda::densify(*executor, found.fit, blending, expected.accumulator.iterations, plan);
      const DensifyCounts cpu = densifyGaussians(expected.field, expected.adam, expected.accumulator, plan);
      EXPECT_EQ(counts.pruned, cpu.pruned);
      EXPECT_EQ(counts.split, cpu.split);
      EXPECT_EQ(counts.cloned, cpu.cloned);
      found.expectAs(expected);
    }
}

INSTANTIATE_TEST_SUITE_P(Everywhere, Reshaping,
                         ::testing::Combine(::testing::ValuesIn(kEverywhere),
                                            ::testing::Values(Blending::Normalised, Blending::Additive,
                                                              Blending::Alpha)),
                         [](const auto& info) {
                           return whereName(std::get<0>(info.param)) + blendingName(std::get<1>(info.param));
                         });

// Real threads synchronise only where a device's do: `make tsan` detects a missing sync().
TEST(ReshapingWithRealThreads, GivesTheSame) {
  const auto executor = makeThreadExecutor();
  FitState expected = stateOf(200, Blending::Normalised, 5);
  OnExecutor found(*executor, expected);
  found.relocate({0.1, -0.5});
  relocateGaussians(expected.field, expected.adam, {0.1, -0.5});
  found.expectAs(expected);
}

TEST(ReshapingOnTheHostExecutor, ChangesNothingAfterAIterationWithoutRoom) {
  const auto executor = cuda::makeHostExecutor();
  const FitState start = stateOf(300, Blending::Normalised, 5);
  OnExecutor found(*executor, start);
  cuda::IterationStatus status{};
  status.pairs = 11;
  found.relocate({0.1, -0.5}, {&status, 10});
  found.expectAs(start);
}

TEST(ReshapingOnTheHostExecutor, IsAllOrNothing) {
  const FitState start = stateOf(500, Blending::Normalised, 5);
  FitState relocated = start, densified = start;
  relocateGaussians(relocated.field, relocated.adam, {0.1, -0.5});
  DensifyPlan plan;
  plan.thresholds = {0.3, 4, 0.05, 4};
  plan.limit = 800;
  densifyGaussians(densified.field, densified.adam, densified.accumulator, plan);
  for (const bool relocating : {true, false}) {
    SCOPED_TRACE(relocating ? "relocation" : "densification");
    bool all = false;
    for (int allocation = 1; !all; ++allocation) {
      ASSERT_LT(allocation, 100);
      const auto executor = cuda::makeHostExecutor();
      OnExecutor found(*executor, start);
      cuda::failAllocations(*executor, allocation, 1);
      try {
        if (relocating)
          found.relocate({0.1, -0.5});
        else
          cuda::densify(*executor, found.fit, Blending::Normalised, 3, plan);
        all = true;
      } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::Memory);
      }
      found.expectAs(!all ? start : relocating ? relocated : densified);
    }
  }
}

} // namespace
