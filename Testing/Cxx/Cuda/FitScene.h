#pragma once
#include "Executors.h"
#include "TestVolumes.h"

#include "Core/Fit/Trainer.h"
#include "Core/Render/Kernels.h"
#include "Cuda/Fit.h"

#include <cstring>

namespace innergs::testing {

struct FitCase {
  const char* name;
  Blending blending;
  bool linear;
  SliceProfile profile;
  double ssimWeight;
  bool relocate, densify;
  double pixelWidth = 0; // mm
};
inline void PrintTo(const FitCase& c, std::ostream* out) {
  *out << c.name;
}
inline const FitCase kFitCases[] = {
    {"Normalised", Blending::Normalised, true, SliceProfile::Point, 0, true, false},
    {"NormalisedBox", Blending::Normalised, false, SliceProfile::Box, 0.1, false, false},
    {"AdditiveClosedForm", Blending::Additive, false, SliceProfile::Gaussian, 0, false, true},
    {"Alpha", Blending::Alpha, false, SliceProfile::Point, 0.1, false, true},
    {"NormalisedWidePixels", Blending::Normalised, true, SliceProfile::Box, 0.1, false, false, 2},
    {"AlphaWidePixels", Blending::Alpha, false, SliceProfile::Box, 0, false, false, 2}};

/// The fit of a phantom whose Gaussians start on a grid of every third voxel.
struct Scene {
  GaussianField field;
  std::vector<Observation> observations;
  FitPlan plan;

  explicit Scene(const FitCase& c, int n = 17) {
    Stack stack;
    stack.image = phantom(grid(n, n, n));
    stack.profile = c.profile;
    stack.thickness = c.profile == SliceProfile::Point ? 0 : 2;
    stack.pixelWidth = c.pixelWidth;
    field.blending = c.blending;
    field.linearIntensity = c.linear;
    for (int k = 1; k < n; k += 3)
      for (int j = 1; j < n; j += 3)
        for (int i = 1; i < n; i += 3) {
          Gaussian g{};
          const int at[3] = {i, j, k};
          // No symmetry: Adam's first step follows the sign of gradients, which is rounding where they are 0.
          for (int a = 0; a < 3; ++a) {
            const double wave = std::sin(1.7 * static_cast<double>(field.size()) + 2.1 * a);
            g.mean[a] = static_cast<float>(at[a] + 0.2 * wave);
            g.logScale[a] = static_cast<float>(std::log(1.3 + 0.05 * a + 0.1 * wave));
            g.quaternion[1 + a] = static_cast<float>(0.2 * wave);
          }
          g.quaternion[0] = 1;
          g.intensity = stack.image.voxels[i + n * (j + n * k)] / 200;
          field.gaussians.push_back(g);
        }
    field.cutoff = 2.2;
    plan.linearIntensity = c.linear;
    plan.iterations = 40;
    plan.coarseIterations = 4;
    plan.rates = {0.2, 0.09, 0.09, 0.15, 0.03, c.linear ? 0.01 : 0.0};
    plan.bounds = {std::log(0.3), std::log(30)};
    plan.cutoff = 2.2;
    plan.loss.ssimWeight = c.ssimWeight;
    if (c.relocate) plan.relocateEvery = 10;
    if (c.densify) {
      plan.densify.every = 10;
      plan.densify.limit = field.size() * 3 / 2;
      plan.densify.thresholds.gradient = 1e-4;
      plan.densify.thresholds.opacity = 0.001;
    }
    observations = observe(stack, {}, {200, 0}, c.blending == Blending::Additive && !c.linear, false, 1);
  }

  FitRequest request(std::stop_token stop = {}) const {
    return fitRequest(observations, plan, field, std::move(stop));
  }

  /// PSNR of the fit at its end.
  double quality(std::unique_ptr<FitDevice> device, std::vector<float>* losses = nullptr,
                 std::int64_t* gaussians = nullptr) const {
    ThreadPool pool(1);
    Trainer trainer(field, request(), plan, kernelSet("scalar"), pool, std::move(device));
    while (trainer.step()) {
    }
    EXPECT_EQ(trainer.failure(), "");
    const LossSum sum = trainer.evaluate(trainer.field());
    if (losses) *losses = trainer.losses();
    if (gaussians) *gaussians = trainer.gaussians();
    return -10 * std::log10(sum.squared / static_cast<double>(sum.samples));
  }
};

inline IterationOptions optionsOf(const Scene& scene, int step) {
  IterationOptions options;
  options.rates = scene.plan.rates;
  options.step = step;
  options.accumulateGradients = true;
  return options;
}

inline bool same(const GaussianField& a, const GaussianField& b) {
  return a.size() == b.size() &&
         std::memcmp(a.gaussians.data(), b.gaussians.data(), 64 * a.gaussians.size()) == 0;
}

} // namespace innergs::testing
