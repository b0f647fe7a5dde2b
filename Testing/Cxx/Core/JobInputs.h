#pragma once
#include "Core/Base/Error.h"
#include "Core/Image/Simulate.h"
#include "Core/Job/ReconstructionJob.h"
#include "Core/Render/Render.h"
#include "TestVolumes.h"

#include <algorithm>
#include <cstring>
#include <gtest/gtest.h>

/// A small input for every case that a reconstruction distinguishes, and helpers to compare results.
namespace innergs::testing {

inline GridGeometry smallGrid() {
  return grid(24, 22, 20, {1, 1, 1}, {-30, 12, 5}, obliqueDirection(0.3));
}

inline ReconstructionInput inputOf(std::vector<Stack> stacks) {
  ReconstructionInput input;
  input.stacks = std::move(stacks);
  return input;
}

/// One isotropic scan of thin slices.
inline ReconstructionInput isotropicInput() {
  return inputOf({pointStack(phantom(smallGrid()))});
}

/// One scan of thick slices.
inline ReconstructionInput anisotropicInput() {
  return inputOf({simulateThickStack(phantom(smallGrid()), 2, 4)});
}

/// Two orthogonal scans of thick slices.
inline ReconstructionInput orthogonalInput() {
  const Volume truth = phantom(smallGrid());
  return inputOf({simulateThickStack(truth, 2, 4), simulateThickStack(truth, 0, 4)});
}

inline Settings fastSettings() {
  Settings settings;
  settings.preset = Preset::Fast;
  settings.threads = 2;
  settings.device = "cpu"; // bit-identical on any machine
  return settings;
}

inline Settings quickSettings(int iterations = 10) {
  Settings settings = fastSettings();
  settings.iterations = iterations;
  settings.gaussians = 300;
  return settings;
}

inline ReconstructionResult reconstruct(const ReconstructionInput& input, const Settings& settings) {
  return ReconstructionJob(input, settings).run();
}

/// How many of a result's warnings contain a text.
inline std::ptrdiff_t warningsWith(const ReconstructionResult& result, const std::string& text) {
  return std::count_if(result.warnings.begin(), result.warnings.end(),
                       [&](const std::string& sentence) { return sentence.find(text) != std::string::npos; });
}

/// dB of a fit with these slices of the first stack held out by hand, on them and inside the mask.
inline double psnrOfAFitWithout(ReconstructionInput input, const std::vector<std::int64_t>& slices,
                                const Settings& settings) {
  input.heldOutFraction = 0;
  Stack& stack = input.stacks.front();
  const std::vector<std::uint8_t> inside = !input.masks.empty()
                                               ? resampleMask(input.masks.front(), stack.image.geometry)
                                               : std::vector<std::uint8_t>(stack.image.voxels.size(), 1);
  holdOut(stack, slices);
  const auto result = reconstruct(input, settings);
  const GaussianField& field = result.model->field;
  RenderOptions options;
  options.threads = settings.threads;
  options.instructionSet = settings.instructionSet;
  const Volume rendered = renderStack(field, stack, options);
  double squared = 0, count = 0;
  for (std::size_t v = 0; v < rendered.voxels.size(); ++v) {
    if (stack.observed[v] || !inside[v]) continue;
    const double e = (rendered.voxels[v] - stack.image.voxels[v]) / field.intensityScale;
    squared += e * e;
    ++count;
  }
  return -10 * std::log10(squared / count);
}

inline ::testing::AssertionResult sameField(const GaussianField& a, const GaussianField& b) {
  if (a.size() != b.size())
    return ::testing::AssertionFailure() << a.size() << " Gaussians against " << b.size();
  for (std::int64_t i = 0; i < a.size(); ++i)
    if (std::memcmp(&a.gaussians[i], &b.gaussians[i], sizeof(Gaussian)) != 0)
      return ::testing::AssertionFailure() << "Gaussian " << i << " of " << a.size() << " differs";
  if (a.cutoff != b.cutoff || a.intensityScale != b.intensityScale || a.intensityOffset != b.intensityOffset)
    return ::testing::AssertionFailure() << "cut-off or intensity map differ";
  if (a.residual.voxels != b.residual.voxels) return ::testing::AssertionFailure() << "the detail differs";
  return ::testing::AssertionSuccess();
}

inline double psnr(const Volume& image, const Volume& truth, double range = 200) {
  double sum = 0;
  for (std::size_t v = 0; v < truth.voxels.size(); ++v)
    sum += std::pow(static_cast<double>(image.voxels[v]) - truth.voxels[v], 2);
  return 10 * std::log10(range * range * static_cast<double>(truth.voxels.size()) / sum);
}

/// A kind of input, for tests that must pass for all kinds.
struct InputKind {
  const char* name;
  ReconstructionInput (*input)();
  int members = 1; // of the ensemble
};

/// A run and its reports.
struct Attempt {
  ReconstructionResult result;
  std::vector<Progress> states;
};

/// Requests a stop in the first report for which `when` holds; none: never.
inline Attempt runUntil(const std::function<bool(const Progress&)>& when, const ReconstructionInput& input,
                        const Settings& settings) {
  Attempt run;
  std::stop_source stop;
  ReconstructionJob job(input, settings);
  job.onProgress([&](const Progress& p) {
    if (when && when(p)) stop.request_stop();
    run.states.push_back(p);
  });
  run.result = job.run(stop.get_token());
  return run;
}

/// The result of a fit that is stopped after the given number of iterations.
inline ReconstructionResult stoppedAt(int iteration, const ReconstructionInput& input,
                                      const Settings& settings) {
  return runUntil(
             [iteration](const Progress& p) { return p.phase == Phase::Fitting && p.iteration == iteration; },
             input, settings)
      .result;
}

} // namespace innergs::testing
