#pragma once
#include "Core/Prediction/NetworkKernels.h"
#include "Core/Prediction/PatchFeatures.h"
#include "Core/Prediction/TrainingPairs.h"

#include <algorithm>
#include <array>

namespace innergs {

/// A linear function of the patch: thin sample = patch mean + deviation · (weights · patch).
struct PatchFilter {
  int phases = 0;
  float typical = 1;          // deviation of the training patches, image units
  std::vector<float> weights; // [PatchFeatures::stride][outputStride(phases)]
  /// Separate weights for patches that reach beyond the first slice (0: at that slice, 1, 2) or beyond the
  /// last (3, 4, 5). Empty: no separate weights.
  static constexpr int reach = PatchFeatures::rows / 2;
  std::array<std::vector<float>, 2 * reach> ends;

  /// Which of `ends` applies to slice `slice` of `slices`; −1: none.
  static int endOf(int slice, int slices) {
    const int first = std::max(slice, 0), last = std::max(slices - 1 - slice, 0);
    if (std::min(first, last) >= reach) return -1;
    return first <= last ? first : reach + last;
  }
};

/// Interpolation between the slices as a filter: Keys' cubic or linear.
PatchFilter interpolationFilter(const SliceSampling& sampling, bool cubic);

/// The shape of pairs drawn from planes.
struct PairShape {
  int slices = 0, columns = 0;
};
/// As many slices as the stack has and the planes allow, at most `most`. 0 if no plane allows any.
PairShape pairShape(const TrainingPlanes& planes, const SliceSampling& sampling, std::int64_t stackSlices,
                    PairShape most);
/// Random numbers for part `index` of a computation, independent of all other parts.
Random randomOf(std::uint64_t seed, std::int64_t index);
/// A random place with enough of the body.
PairPlace randomPlace(const std::vector<TrainingPlane>& planes, const SliceSampling& sampling,
                      const PairShape& shape, Random& random);

/// Ridge regression on pairs, with interpolation as the prior. `slices`: of the stack.
PatchFilter learnFilter(const TrainingPlanes& planes, const SliceSampling& sampling, const PairShape& shape,
                        double pairNoise, std::uint64_t seed, const NetworkKernels& kernels,
                        ThreadPool& pool);

/// For the samples that are computed, out[sample][outputStride] += weights · features: the thin samples'
/// difference from the patch mean, divided by the deviation.
void applyFilter(const PatchFilter& filter, const PatchFeatures& features, const NetworkKernels& kernels,
                 float* out);

} // namespace innergs
