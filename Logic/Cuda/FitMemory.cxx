#include "Cuda/FitMemory.h"

#include "Core/Render/Projected.h"

#include <algorithm>

namespace innergs::cuda {
FitMemory fitMemory(const FitRequest& request) {
  const bool alpha = request.blending == Blending::Alpha, ssim = request.rules.loss.ssimWeight > 0;
  double samples = 0, largest = 1, slice = 1, planes = 1;
  for (const Observation& o : *request.observations) {
    samples += static_cast<double>(o.target.size());
    largest = std::max(largest, static_cast<double>(o.bufferSize()));
    slice = std::max(slice, static_cast<double>(o.sliceSize()) * o.perSlice);
    planes = std::max(planes, static_cast<double>(o.grid.planes()));
  }
  const double n = static_cast<double>(request.gaussians);
  // Field twice (evaluate), gradient, Adam, gradients, projected, moments, counts and their sums, relocation.
  const double perGaussian = 2 * 64 + 64 + 128 + 4 + sizeof(Projected) + 56 + 16 + 70;
  // While Gaussians are added: another copy of the field with its moments and gradients, unsorted records,
  // two rankings, marks, numbers. If memory is short, gradient, other field and pairs are freed for that.
  const double reshaping = request.rules.densify.every > 0 ? 64 + 128 + 4 + 64 + 2 * 24 + 40 : 0;
  // The pairs of a Gaussian, plus 20 %: sorted keys and numbers, twice; alpha: owners and slots as well.
  const double pairs = alpha ? std::min(64.0, 4 * planes) : 24, perPair = 24 + (alpha ? 36 : 0);
  const double perPoint = 8 + 0.2 + (ssim ? 20 : 0);
  const double data = samples * 5 * (request.coarse ? 1.3 : 1.0);
  const double fixed = data + n * (perGaussian + 1.2 * pairs * perPair) + (16 << 20);
  const double reshaped = data + n * (perGaussian - 2 * 64 + reshaping) + (16 << 20);
  return {static_cast<std::int64_t>(fixed + n * reshaping +
                                    perPoint * std::min(largest, static_cast<double>(kSlabPoints))),
          static_cast<std::int64_t>(std::max(fixed + perPoint * slice, reshaped))};
}

} // namespace innergs::cuda
