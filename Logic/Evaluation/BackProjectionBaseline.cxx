#include "Evaluation/BackProjectionBaseline.h"

#include "Core/Acquisition/BackProjection.h"
#include "Core/Image/NoiseEstimate.h"
#include "Evaluation/Baselines.h"

#include <cmath>

namespace innergs {
namespace {

// Measured on one to three 4 mm stacks with noise of 0 to 4 % of the range: a smaller share costs up to 1.7
// dB with noise, a larger one up to 1 dB without.
constexpr double kNoiseShare = 0.4;

} // namespace

Volume backProjectionBaseline(std::span<const Stack> stacks, const GridGeometry& grid,
                              const BackProjectionSettings& settings) {
  Volume volume = averageUpsampled(stacks, grid, Interpolation::Cubic, settings.threads, settings.stop);
  BackProjectionPlan plan;
  plan.iterations = settings.iterations;
  double variance = 0;
  if (settings.stopAtNoise)
    for (const Stack& stack : stacks)
      variance +=
          std::pow(estimateNoise(stack.image, stack.observed), 2) / static_cast<double>(stacks.size());
  plan.stopAt = kNoiseShare * std::sqrt(variance);
  ThreadPool pool(settings.threads);
  pool.setStop(settings.stop);
  backProject(volume, stacks, plan, pool);
  return volume;
}

} // namespace innergs
