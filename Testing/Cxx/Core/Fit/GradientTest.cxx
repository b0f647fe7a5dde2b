#include "RandomFields.h"

#include "Core/Render/GridRenderer.h"
#include "Core/Render/Kernels.h"
#include "ReferenceModel.h"
#include "TestVolumes.h"

#include <gtest/gtest.h>
#include <limits>
#include <random>

using namespace innergs;
using namespace innergs::testing;

namespace {

/// How slices see the field.
struct Mode {
  const char* name;
  Blending blending;
  bool linear;
  SliceProfile profile;
  bool closedForm;
  double pixelWidth = 0; // mm
};

const Mode kModes[] = {
    {"NormalisedThin", Blending::Normalised, true, SliceProfile::Point, false},
    {"NormalisedConstantThin", Blending::Normalised, false, SliceProfile::Point, false},
    {"NormalisedBox", Blending::Normalised, true, SliceProfile::Box, false},
    {"NormalisedGaussianSubPlanes", Blending::Normalised, true, SliceProfile::Gaussian, false},
    {"AdditiveThin", Blending::Additive, false, SliceProfile::Point, false},
    {"AdditiveLinearThin", Blending::Additive, true, SliceProfile::Point, false},
    {"AdditiveBox", Blending::Additive, false, SliceProfile::Box, false},
    {"AdditiveGaussianClosedForm", Blending::Additive, false, SliceProfile::Gaussian, true},
    {"AlphaThin", Blending::Alpha, false, SliceProfile::Point, false},
    {"AlphaBox", Blending::Alpha, false, SliceProfile::Box, false},
    {"NormalisedBoxWidePixels", Blending::Normalised, true, SliceProfile::Box, false, 1.7},
    {"AdditiveClosedFormWidePixels", Blending::Additive, false, SliceProfile::Gaussian, true, 1.6},
    {"AlphaBoxWidePixels", Blending::Alpha, false, SliceProfile::Box, false, 1.6}};

struct Loss {
  const char* name;
  LossKinds kinds;
};
const Loss kLosses[] = {{"L2", {LossKind::L2, 0.02, 0}},
                        {"Huber", {LossKind::Huber, 0.05, 0}},
                        {"L1", {LossKind::L1, 0.02, 0}},
                        {"L2 with SSIM", {LossKind::L2, 0.02, 0.1}},
                        {"the paper's", {LossKind::L1, 0.02, 0.4, 0.8}},
                        {"SSIM alone", {LossKind::L2, 0.02, 1, 0}}};

const char* const kParameterNames[16] = {"mean x",       "mean y",       "mean z",       "logScale 0",
                                         "logScale 1",   "logScale 2",   "quaternion w", "quaternion x",
                                         "quaternion y", "quaternion z", "logWeight",    "intensity",
                                         "slope x",      "slope y",      "slope z",      "reserved"};

/// An oblique, left-handed stack of noise with unobserved and non-finite voxels, 12×10×4.
Stack obliqueStack(SliceProfile profile) {
  Stack stack;
  stack.image =
      randomVolume(grid(12, 10, 4, {0.9, 1.1, 2.6}, {-3, 4, 2}, obliqueDirection(0.7, true)), 100, 300, 5);
  stack.thickness = 2.8;
  stack.profile = profile;
  stack.observed.assign(stack.image.voxels.size(), 1);
  for (std::size_t v = 3; v < stack.observed.size(); v += 11)
    stack.observed[v] = 0;
  stack.image.voxels[40] = std::numeric_limits<float>::quiet_NaN();
  stack.image.voxels[150] = std::numeric_limits<float>::infinity();
  return stack;
}

/// Anisotropic Gaussians in and around the stack, so that its border cuts some; the frame is rotated relative
/// to the stack.
GaussianField fieldAround(const Stack& stack, const Mode& mode) {
  Cloud cloud;
  cloud.low = {-5, -5, -5};
  cloud.high = {5, 5, 5};
  cloud.minSigma = 1.2;
  cloud.maxSigma = 2.6;
  GaussianField field = randomField(12, cloud, 17, mode.blending, mode.linear);
  field.modelToWorld = {obliqueDirection(-0.4), stack.image.geometry.centre()};
  field.cutoff = 2.8;
  field.intensityScale = 200;
  field.intensityOffset = 100;
  return field;
}

struct Pipeline {
  Observation observation;
  GaussianField field;
  ThreadPool pool{2};

  explicit Pipeline(const Mode& mode) {
    Stack stack = obliqueStack(mode.profile);
    stack.pixelWidth = mode.pixelWidth;
    field = fieldAround(stack, mode);
    auto observations = observe(stack, field.modelToWorld, {field.intensityScale, field.intensityOffset},
                                mode.closedForm, false, 0.8);
    observation = std::move(observations.at(0));
  }

  double loss(const GaussianField& at, const KernelSet& kernels, const LossKinds& kinds,
              std::vector<float>* gradient = nullptr) {
    std::vector<float> w(observation.bufferSize()), n(w.size());
    const std::size_t part = observation.grid.bufferSize();
    std::vector<std::unique_ptr<GridRenderer>> renderers;
    for (std::size_t p = 0; p < observation.points.size(); ++p) {
      renderers.push_back(
          std::make_unique<GridRenderer>(observation.gridOf(p), kernels, pool, observation.psf));
      renderers[p]->forward(at, {}, w.data() + p * part, n.data() + p * part);
    }
    const LossSum sum = lossPass(observation, at, kinds, w.data(), n.data(), pool);
    if (gradient) {
      gradient->assign(16 * at.gaussians.size(), 0.f);
      for (std::size_t p = 0; p < renderers.size(); ++p)
        renderers[p]->backward(at, w.data() + p * part, n.data() + p * part, *gradient);
    }
    return sum.loss;
  }
};

} // namespace

class Gradient : public ::testing::TestWithParam<Mode> {};

TEST_P(Gradient, TheSliceProfileIsSeenAsTheModeSays) {
  Pipeline pipeline(GetParam());
  const Observation& o = pipeline.observation;
  EXPECT_EQ(o.slices, 4);
  EXPECT_EQ(o.psf.active, GetParam().closedForm);
  if (GetParam().pixelWidth > 0)
    EXPECT_GE(o.points.size(), 4u);
  else
    EXPECT_EQ(o.points.size(), 1u);
  const auto points = static_cast<int>(o.points.size());
  if (GetParam().profile == SliceProfile::Point || GetParam().closedForm)
    EXPECT_EQ(o.perSlice, points);
  else
    EXPECT_GE(o.perSlice, 3 * points);
}

TEST_P(Gradient, OfEveryParameterIsThatOfTheLoss) {
  Pipeline pipeline(GetParam());
  const Observation& o = pipeline.observation;
  const std::size_t count = pipeline.field.gaussians.size();
  auto parameters = parametersOf(pipeline.field);
  const auto slices = referenceSlices(o, pipeline.field, parameters);

  // Central differences of the reference, for all losses at once.
  constexpr double step = 1e-5;
  std::vector<std::array<double, std::size(kLosses)>> differences(16 * count);
  for (std::size_t i = 0; i < count; ++i)
    for (int p = 0; p < 15; ++p) {
      const double saved = parameters[i][p];
      parameters[i][p] = saved + step;
      const auto above = referenceSlices(o, pipeline.field, parameters);
      parameters[i][p] = saved - step;
      const auto below = referenceSlices(o, pipeline.field, parameters);
      parameters[i][p] = saved;
      for (std::size_t l = 0; l < std::size(kLosses); ++l)
        differences[16 * i + p][l] =
            (referenceLoss(o, kLosses[l].kinds, above) - referenceLoss(o, kLosses[l].kinds, below)) /
            (2 * step);
    }

  for (const KernelSet& kernels : kernelSets())
    for (std::size_t l = 0; l < std::size(kLosses); ++l) {
      SCOPED_TRACE(kernels.name + ", " + kLosses[l].name);
      std::vector<float> gradient;
      const double loss = pipeline.loss(pipeline.field, kernels, kLosses[l].kinds, &gradient);
      const double expectedLoss = referenceLoss(o, kLosses[l].kinds, slices);
      EXPECT_NEAR(loss, expectedLoss, 2e-5 * expectedLoss);
      for (int p = 0; p < 15; ++p) {
        double largest = 0;
        for (std::size_t i = 0; i < count; ++i)
          largest = std::max(largest, std::abs(differences[16 * i + p][l]));
        const bool fitted = p < 12 || GetParam().linear;
        if (fitted) {
          EXPECT_GT(largest, 0.0) << kParameterNames[p] << " has no influence: the test sees nothing";
        }
        for (std::size_t i = 0; i < count; ++i) {
          const double expected = fitted ? differences[16 * i + p][l] : 0;
          EXPECT_NEAR(gradient[16 * i + p], expected, 2e-3 * std::abs(expected) + 5e-4 * largest)
              << kParameterNames[p] << " of Gaussian " << i;
        }
      }
    }
}

TEST_P(Gradient, PredictsTheChangeOfTheEnginesOwnLoss) {
  Pipeline pipeline(GetParam());
  const std::size_t count = pipeline.field.gaussians.size();
  for (const KernelSet& kernels : kernelSets())
    for (const auto& [name, kinds] : kLosses) {
      SCOPED_TRACE(kernels.name + ", " + name);
      std::vector<float> gradient;
      pipeline.loss(pipeline.field, kernels, kinds, &gradient);
      Numbers random(23);
      // Along the gradient, whose slope is known to be large, with every parameter scaled randomly.
      std::vector<double> direction(16 * count, 0.0);
      double slope = 0, length = 0;
      for (std::size_t n = 0; n < direction.size(); ++n) {
        if (n % 16 == 15) continue;
        direction[n] = gradient[n] * random(0.5, 1.5);
        length += direction[n] * direction[n];
      }
      length = std::sqrt(length);
      for (std::size_t n = 0; n < direction.size(); ++n)
        slope += (direction[n] /= length) * gradient[n];
      const double step = 2e-3;
      GaussianField above = pipeline.field, below = pipeline.field;
      for (std::size_t n = 0; n < direction.size(); ++n) {
        reinterpret_cast<float*>(above.gaussians.data())[n] += static_cast<float>(step * direction[n]);
        reinterpret_cast<float*>(below.gaussians.data())[n] -= static_cast<float>(step * direction[n]);
      }
      const double difference =
          (pipeline.loss(above, kernels, kinds) - pipeline.loss(below, kernels, kinds)) / (2 * step);
      EXPECT_GT(slope, 0.0);
      EXPECT_NEAR(difference, slope, 0.01 * slope);
    }
}

INSTANTIATE_TEST_SUITE_P(Modes, Gradient, ::testing::ValuesIn(kModes),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(Gradient, IsTheSumOverObservationsWithPoses) {
  // Two slices with poses of their own are two observations; their gradients add up.
  Stack stack = obliqueStack(SliceProfile::Box);
  stack.poses.assign(4, Affine3{});
  stack.poses[1] = {obliqueDirection(0.05), {0.3, -0.2, 0.1}};
  const GaussianField field = fieldAround(stack, kModes[0]);
  const auto observations = observe(stack, field.modelToWorld, {200, 100}, false);
  ASSERT_EQ(observations.size(), 4u);
  ThreadPool pool(2);
  std::vector<float> sum(16 * field.gaussians.size(), 0.f);
  std::vector<double> separate(sum.size(), 0.0);
  for (const Observation& o : observations) {
    GridRenderer renderer(o.grid, kernelSet("scalar"), pool, o.psf);
    std::vector<float> w(o.grid.bufferSize()), n(w.size()), alone(sum.size(), 0.f);
    renderer.forward(field, {}, w.data(), n.data());
    lossPass(o, field, {LossKind::L2, 0.02, 0}, w.data(), n.data(), pool);
    renderer.backward(field, w.data(), n.data(), sum);
    renderer.backward(field, w.data(), n.data(), alone);
    for (std::size_t i = 0; i < sum.size(); ++i)
      separate[i] += alone[i];
  }
  double largest = 0;
  for (double g : separate)
    largest = std::max(largest, std::abs(g));
  EXPECT_GT(largest, 0.1);
  for (std::size_t i = 0; i < sum.size(); ++i)
    EXPECT_NEAR(sum[i], separate[i], 1e-5 * largest);
}

/// Adam makes full steps of gradients that should cancel, so they must not depend on how sums are rounded.
TEST(PrecisionGradient, NeverTurnsGaussiansWithEqualAxes) {
  std::mt19937 random(7);
  std::normal_distribution<float> normal;
  for (int n = 0; n < 100; ++n) {
    float quaternion[4], g6[6], scales[3], turns[4];
    for (float& q : quaternion)
      q = normal(random);
    for (float& g : g6)
      g = normal(random);
    const float logScale = normal(random), all[3] = {logScale, logScale, logScale},
                two[3] = {logScale, logScale, logScale + 0.5f};
    math::precisionGradient(g6, all, quaternion, scales, turns);
    for (const float turn : turns)
      EXPECT_EQ(turn, 0.f);
    // Of two equal axes, turns about the third.
    const float about[4] = {1, 0, 0, 0};
    math::precisionGradient(g6, two, about, scales, turns);
    EXPECT_EQ(turns[3], 0.f);
    EXPECT_NE(turns[1], 0.f);
  }
}
