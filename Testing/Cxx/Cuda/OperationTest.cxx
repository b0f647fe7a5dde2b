#include "Executors.h"
#include "RandomFields.h"
#include "TestVolumes.h"

#include "Core/Fit/Densify.h"
#include "Core/Render/FieldGradient.h"
#include "Core/Render/GridRenderer.h"
#include "Core/Render/Kernels.h"
#include "Core/Render/KernelsScalar.h"
#include "Cuda/Passes.h"

#include <limits>

using namespace innergs;
using namespace innergs::testing;
using innergs::cuda::Buffer;

namespace {

constexpr double kTolerance = 1e-4;

/// How slices see a field, and the sizes involved.
struct Case {
  const char* name;
  Blending blending;
  bool linear;
  SliceProfile profile;
  bool closedForm;
  std::int64_t size[3];
  int gaussians;
  double minSigma, maxSigma; // mm
  double reach;              // half edge of the box that contains the Gaussians
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.name;
}
const Case kCases[] = {
    {"NormalisedThin",
     Blending::Normalised,
     false,
     SliceProfile::Point,
     false,
     {33, 21, 9},
     90,
     0.8,
     2.5,
     14},
    {"NormalisedLinear",
     Blending::Normalised,
     true,
     SliceProfile::Point,
     false,
     {40, 17, 11},
     90,
     0.8,
     2.5,
     14},
    {"NormalisedBox", Blending::Normalised, true, SliceProfile::Box, false, {19, 23, 5}, 60, 1, 2.5, 12},
    {"NormalisedSubPlanes",
     Blending::Normalised,
     true,
     SliceProfile::Gaussian,
     false,
     {19, 23, 5},
     60,
     1,
     2.5,
     12},
    {"Additive", Blending::Additive, false, SliceProfile::Point, false, {31, 30, 7}, 80, 0.8, 2.5, 14},
    {"AdditiveLinear", Blending::Additive, true, SliceProfile::Point, false, {31, 30, 7}, 80, 0.8, 2.5, 14},
    {"AdditiveBox", Blending::Additive, false, SliceProfile::Box, false, {18, 20, 4}, 50, 1, 2.5, 12},
    {"AdditiveClosedForm",
     Blending::Additive,
     false,
     SliceProfile::Gaussian,
     true,
     {25, 18, 6},
     60,
     0.8,
     2.5,
     12},
    {"Alpha", Blending::Alpha, false, SliceProfile::Point, false, {37, 35, 6}, 120, 0.8, 2.5, 16},
    {"AlphaBox", Blending::Alpha, false, SliceProfile::Box, false, {20, 18, 4}, 60, 1, 2.5, 12},
    {"OneVoxelWide", Blending::Normalised, false, SliceProfile::Point, false, {1, 40, 3}, 40, 0.8, 2.5, 10},
    {"OneRow", Blending::Alpha, false, SliceProfile::Point, false, {50, 1, 2}, 60, 0.8, 2.5, 14},
    {"HugeNormalised", Blending::Normalised, true, SliceProfile::Point, false, {34, 33, 9}, 20, 15, 60, 30},
    {"HugeAlpha", Blending::Alpha, false, SliceProfile::Point, false, {34, 33, 5}, 20, 15, 60, 30},
    {"TinyNormalised",
     Blending::Normalised,
     false,
     SliceProfile::Point,
     false,
     {34, 33, 9},
     400,
     0.05,
     0.4,
     16},
    {"TinyAlpha", Blending::Alpha, false, SliceProfile::Point, false, {34, 33, 5}, 400, 0.1, 0.4, 16},
    {"EmptyTiles", Blending::Normalised, false, SliceProfile::Point, false, {100, 70, 13}, 6, 1, 2, 5},
    {"EmptyAlphaTiles", Blending::Alpha, false, SliceProfile::Point, false, {100, 70, 5}, 6, 1, 2, 5},
    {"AllOutside", Blending::Normalised, false, SliceProfile::Point, false, {20, 20, 5}, 8, 0.3, 0.5, 0},
    {"NoGaussians", Blending::Normalised, false, SliceProfile::Point, false, {20, 20, 5}, 0, 1, 2, 5}};

struct NamedLoss {
  const char* name;
  LossKinds kinds;
};
const NamedLoss kLosses[] = {{"L2", {LossKind::L2, 0.02, 0, 1}},
                             {"Huber", {LossKind::Huber, 0.05, 0, 1}},
                             {"L1", {LossKind::L1, 0.02, 0, 0.8}},
                             {"L2Ssim", {LossKind::L2, 0.02, 0.4, 0.8}},
                             {"SsimAlone", {LossKind::L2, 0.02, 1, 0}}};

/// An oblique, left-handed stack of noise with unobserved and non-finite voxels.
Stack stackOf(const Case& c) {
  Stack stack;
  stack.image = randomVolume(
      grid(c.size[0], c.size[1], c.size[2], {0.9, 1.1, 1.7}, {-3, 4, 2}, obliqueDirection(0.7, true)), 100,
      300, 5);
  stack.thickness = c.profile == SliceProfile::Point ? 0 : 2.8;
  stack.profile = c.profile;
  stack.observed.assign(stack.image.voxels.size(), 1);
  for (std::size_t v = 3; v < stack.observed.size(); v += 11)
    stack.observed[v] = 0;
  stack.image.voxels[stack.image.voxels.size() / 2] = std::numeric_limits<float>::quiet_NaN();
  return stack;
}

GaussianField fieldOf(const Case& c, const Stack& stack) {
  Cloud cloud;
  cloud.low.fill(-c.reach);
  cloud.high.fill(c.reach);
  if (c.reach == 0) {
    cloud.low.fill(300);
    cloud.high.fill(310);
  }
  cloud.minSigma = c.minSigma;
  cloud.maxSigma = c.maxSigma;
  GaussianField field = randomField(c.gaussians, cloud, 17, c.blending, c.linear);
  field.modelToWorld = {obliqueDirection(-0.4), stack.image.geometry.centre()};
  field.cutoff = 2.4;
  field.intensityScale = 200;
  field.intensityOffset = 100;
  return field;
}

/// Removes Gaussians whose gradient depends on a single bit (edgeClearance()).
void keepClear(GaussianField& field, const Observation& o) {
  const ProjectionFrame frame = projectionFrame(o.grid);
  const ProjectionRules rules{static_cast<float>(field.cutoff * field.cutoff), field.blending,
                              field.linearIntensity, Selection::Exact, o.psf};
  const std::size_t all = field.gaussians.size();
  std::erase_if(field.gaussians, [&](const Gaussian& g) {
    Projected p;
    projectGaussian(g, nullptr, frame, rules, p);
    return edgeClearance(p, o.grid) < 2e-5f;
  });
  ASSERT_GE(field.gaussians.size(), all - all / 8);
}

/// The results of an iteration on one observation, before Adam.
struct Computed {
  std::vector<float> a, b;   // W and N, [plane][ny][nx]
  std::vector<float> f0, f1; // the same shape
  std::vector<float> gradient;
  LossSum loss;
};

/// Removes the row padding.
std::vector<float> packed(const SampleGrid& grid, const auto& at) {
  std::vector<float> out;
  for (int row = 0; row < grid.planes() * grid.ny; ++row)
    for (int x = 0; x < grid.nx; ++x)
      out.push_back(at(static_cast<std::size_t>(row) * grid.stride() + x));
  return out;
}

Computed onTheCpu(const Observation& o, const GaussianField& field, const LossKinds& kinds) {
  ThreadPool pool(1);
  const KernelSet kernels = scalarKernels(Selection::Exact);
  GridRenderer renderer(o.grid, kernels, pool, o.psf);
  std::vector<float> w(o.grid.bufferSize()), n(w.size());
  Computed c;
  const auto pack = [&](const std::vector<float>& from) {
    return packed(o.grid, [&](std::size_t i) { return from[i]; });
  };
  renderer.forward(field, {}, w.data(), n.data());
  c.a = pack(w);
  c.b = pack(n);
  c.loss = lossPass(o, field, kinds, w.data(), n.data(), pool);
  c.f0 = pack(w);
  c.f1 = pack(n);
  c.gradient.assign(16 * field.gaussians.size(), 0.f);
  renderer.backward(field, w.data(), n.data(), c.gradient);
  return c;
}

Computed onExecutor(cuda::Executor& executor, const Observation& o, const GaussianField& field,
                    const LossKinds& kinds) {
  cuda::Passes passes(executor);
  Buffer<Gaussian> gaussians(executor);
  gaussians.upload(field.gaussians.data(), field.size());
  Buffer<float> target(executor), gradient(executor);
  target.upload(o.target.data(), static_cast<std::int64_t>(o.target.size()));
  Buffer<std::uint8_t> weight(executor);
  weight.upload(o.weight.data(), static_cast<std::int64_t>(o.weight.size()));
  Buffer<cuda::SubPlaneView> subPlanes(executor);
  std::vector<cuda::SubPlaneView> views;
  for (const Observation::SubPlane& p : o.subPlanes)
    views.push_back({p.plane, p.weight});
  subPlanes.upload(views.data(), static_cast<std::int64_t>(views.size()));
  const cuda::DevicePlanes planes(executor, o.grid, 0, o.grid.planes());
  const std::int64_t points = static_cast<std::int64_t>(o.grid.bufferSize());
  Computed c;
  std::vector<cuda::Pair> pairs(points);
  const auto fetch = [&](std::vector<float>& a, std::vector<float>& b) {
    executor.download(pairs.data(), passes.planes(), points * sizeof(cuda::Pair));
    a = packed(o.grid, [&](std::size_t i) { return pairs[i].a; });
    b = packed(o.grid, [&](std::size_t i) { return pairs[i].b; });
  };
  passes.project(gaussians.data(), nullptr, field.size(), projectionFrame(o.grid),
                 {static_cast<float>(field.cutoff * field.cutoff), field.blending, field.linearIntensity,
                  Selection::Exact, o.psf});
  passes.forward(planes, field.blending);
  fetch(c.a, c.b);
  passes.loss({o.slices, planes.planeSize(), planes.nx, planes.ny, planes.stride, o.perSlice,
               subPlanes.data(), target.data(), weight.data(), field.blending,
               static_cast<float>(field.epsilon)},
              kinds);
  fetch(c.f0, c.f1);
  passes.backward(planes, field.blending, false);
  gradient.reserve(16 * field.size());
  executor.runOver(cuda::Chain{gaussians.data(), passes.moments(), field.size(),
                               chainRules(field.blending, field.linearIntensity, o.grid, o.psf),
                               gradient.data(), true},
                   field.size());
  c.gradient.resize(16 * field.gaussians.size());
  gradient.download(c.gradient.data(), static_cast<std::int64_t>(c.gradient.size()));
  const cuda::IterationSums sums = passes.status().sums[0];
  c.loss = {sums.loss, sums.squared, sums.samples};
  return c;
}

class Operations : public ::testing::TestWithParam<std::tuple<Where, Case>> {};

TEST_P(Operations, AgreeWithTheScalarReference) {
  const auto& [where, c] = GetParam();
  INNERGS_EXECUTOR_OR_SKIP(executor, where);
  const Stack stack = stackOf(c);
  GaussianField field = fieldOf(c, stack);
  const auto observations = observe(stack, field.modelToWorld, {200, 100}, c.closedForm);
  ASSERT_EQ(observations.size(), 1u);
  keepClear(field, observations[0]);
  if (where != Where::Host) field.epsilon = 1e-2; // for a single Gaussian, 1/ε amplifies rounding
  for (const NamedLoss& loss : kLosses) {
    SCOPED_TRACE(loss.name);
    const Computed expected = onTheCpu(observations[0], field, loss.kinds);
    const Computed found = onExecutor(*executor, observations[0], field, loss.kinds);
    EXPECT_LE(errorOn(where, found.a, expected.a), kTolerance) << "weights";
    EXPECT_LE(errorOn(where, found.b, expected.b), kTolerance) << "numerators";
    EXPECT_EQ(found.loss.samples, expected.loss.samples);
    EXPECT_NEAR(found.loss.loss, expected.loss.loss, kTolerance * expected.loss.loss);
    EXPECT_NEAR(found.loss.squared, expected.loss.squared, kTolerance * expected.loss.squared);
    // The sign of L1's derivative may flip where the error is near 0.
    if (loss.kinds.kind == LossKind::L1) continue;
    EXPECT_LE(errorOn(where, found.f0, expected.f0), kTolerance) << "F0";
    EXPECT_LE(errorOn(where, found.f1, expected.f1), kTolerance) << "F1";
    for (int p = 0; p < 16; ++p)
      EXPECT_LE(errorOn(where, found.gradient, expected.gradient, p, 16), kTolerance) << "parameter " << p;
  }
}

INSTANTIATE_TEST_SUITE_P(Everywhere, Operations,
                         ::testing::Combine(::testing::ValuesIn(kEverywhere), ::testing::ValuesIn(kCases)),
                         [](const auto& info) {
                           return whereName(std::get<0>(info.param)) + std::get<1>(info.param).name;
                         });

/// With an operating system thread for every thread of a block, the results are bit-identical, and `make
/// tsan` detects a missing sync().
TEST(KernelsWithRealThreads, ComputeTheSameBits) {
  // More Gaussians than a block stages at once.
  const Case cases[] = {
      {"Normalised", Blending::Normalised, true, SliceProfile::Box, false, {18, 9, 2}, 200, 0.8, 2.5, 6},
      {"Alpha", Blending::Alpha, false, SliceProfile::Point, false, {16, 9, 2}, 260, 0.8, 2.5, 6},
      {"Huge", Blending::Normalised, false, SliceProfile::Point, false, {18, 9, 3}, 5, 15, 60, 8}};
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    const Stack stack = stackOf(c);
    const GaussianField field = fieldOf(c, stack);
    const auto observations = observe(stack, field.modelToWorld, {200, 100}, c.closedForm);
    const auto host = cuda::makeHostExecutor();
    const auto threads = makeThreadExecutor();
    const LossKinds kinds{LossKind::L2, 0.02, 0.4, 0.8};
    const Computed a = onExecutor(*host, observations[0], field, kinds);
    const Computed b = onExecutor(*threads, observations[0], field, kinds);
    EXPECT_EQ(a.a, b.a);
    EXPECT_EQ(a.b, b.b);
    EXPECT_EQ(a.f0, b.f0);
    EXPECT_EQ(a.f1, b.f1);
    EXPECT_EQ(a.gradient, b.gradient);
    EXPECT_EQ(a.loss.loss, b.loss.loss);
  }
}

class Kernels : public ::testing::TestWithParam<Where> {};

TEST_P(Kernels, LeavesBrokenGaussiansOut) {
  INNERGS_EXECUTOR_OR_SKIP(executor, GetParam());
  for (const Case& c : {kCases[0], kCases[4], kCases[8]}) {
    SCOPED_TRACE(c.name);
    const Stack stack = stackOf(c);
    GaussianField field = fieldOf(c, stack);
    const auto breakOne = [&](auto&& how) {
      field.gaussians.push_back(field.gaussians.front());
      how(field.gaussians.back());
    };
    breakOne([](Gaussian& g) { g.mean[1] = NAN; });
    breakOne([](Gaussian& g) { g.mean[0] = 3e38f; });
    breakOne([](Gaussian& g) { g.logScale[2] = 60; });
    breakOne([](Gaussian& g) { g.logScale[0] = -60; });
    breakOne([](Gaussian& g) { g.logWeight = -INFINITY; });
    breakOne([](Gaussian& g) { std::fill_n(g.quaternion, 4, 0.f); });
    const auto observations = observe(stack, field.modelToWorld, {200, 100}, c.closedForm);
    const Computed expected = onTheCpu(observations[0], field, kLosses[0].kinds);
    const Computed found = onExecutor(*executor, observations[0], field, kLosses[0].kinds);
    EXPECT_LE(relativeError(found.a, expected.a), kTolerance);
    EXPECT_LE(relativeError(found.b, expected.b), kTolerance);
    EXPECT_NEAR(found.loss.loss, expected.loss.loss, kTolerance * expected.loss.loss);
  }
}

TEST_P(Kernels, TakesTheStepsOfAdam) {
  INNERGS_EXECUTOR_OR_SKIP(executor, GetParam());
  constexpr int n = 300;
  GaussianField field = randomField(n, {}, 3);
  Adam adam(n);
  Numbers random(5);
  const LearningRates rates{0.1, 0.5, 0.09, 0.4, 0.03, 0.01};
  FieldBounds bounds;
  bounds.minLogScale = -0.2;
  bounds.maxLogScale = 0.9;
  bounds.minThirdLogScale = 0.1;
  bounds.maxAbsLogWeight = 1;
  DensifyPlan densify;
  densify.voxel = 0.7;
  densify.coverage = 3;
  GradientAccumulator accumulator;
  ThreadPool pool(1);
  Buffer<Gaussian> gaussians(*executor);
  Buffer<float> m1(*executor), m2(*executor), gradient(*executor), sums(*executor);
  Buffer<cuda::IterationStatus> status(*executor);
  gaussians.upload(field.gaussians.data(), n);
  m1.upload(adam.moment1.data(), 16 * n);
  m2.upload(adam.moment2.data(), 16 * n);
  sums.reserve(n);
  sums.fill(0, n);
  status.reserve(1);
  status.fill(0, 1);
  for (int step = 1; step <= 4; ++step) {
    std::vector<float> g(16 * n);
    for (float& x : g)
      x = static_cast<float>(random(-1, 1));
    gradient.upload(g.data(), 16 * n);
    accumulator.add(g, densify, pool);
    adam.apply(field, g, rates, bounds, step, pool);
    executor->runOver(
        cuda::Update{gradient.data(),
                     n,
                     adamStep(rates, bounds, adam.beta1, adam.beta2, step, field.linearIntensity),
                     gaussians.data(),
                     m1.data(),
                     m2.data(),
                     sums.data(),
                     static_cast<float>(densify.voxel / densify.coverage),
                     status.data(),
                     {}},
        n);
  }
  std::vector<Gaussian> found(n);
  std::vector<float> a(16 * n), b(16 * n), s(n);
  gaussians.download(found.data(), n);
  m1.download(a.data(), 16 * n);
  m2.download(b.data(), 16 * n);
  sums.download(s.data(), n);
  const auto floats = [](const std::vector<Gaussian>& g) {
    return std::span(reinterpret_cast<const float*>(g.data()), 16 * g.size());
  };
  EXPECT_LE(relativeError(floats(found), floats(field.gaussians)), kTolerance);
  EXPECT_LE(relativeError(a, adam.moment1), kTolerance);
  EXPECT_LE(relativeError(b, adam.moment2), kTolerance);
  EXPECT_LE(relativeError(s, accumulator.sum), kTolerance);
}

INSTANTIATE_TEST_SUITE_P(Everywhere, Kernels, ::testing::ValuesIn(kEverywhere),
                         [](const auto& info) { return whereName(info.param); });

} // namespace
