#pragma once
#include "Core/Prediction/MatrixKernels.h"
#include "Core/Prediction/PatchFeatures.h"
#include "Core/Prediction/TrainingPairs.h"

#include <algorithm>
#include <array>

namespace innergs {

/// Linear in the patch: thin sample = patch mean + deviation · (weights · patch).
struct PatchFilter {
  int phases = 0;
  float typical = 1;          // deviation of the patches that it was learned from, image units
  std::vector<float> weights; // [PatchFeatures::stride][outputStride(phases)]
  /// Instead of them where the patch reaches beyond the first slice (0: around that slice itself, 1, 2) and
  /// beyond the last (3, 4, 5). Empty: none of their own.
  static constexpr int reach = PatchFeatures::rows / 2;
  std::array<std::vector<float>, 2 * reach> ends;

  /// Which of `ends` slice `slice` of `slices` needs; −1: none.
  static int endOf(int slice, int slices) {
    const int first = std::max(slice, 0), last = std::max(slices - 1 - slice, 0);
    if (std::min(first, last) >= reach) return -1;
    return first <= last ? first : reach + last;
  }
};

/// Interpolation between the slices as a filter, by Keys' cubic or linearly.
PatchFilter interpolationFilter(const SliceSampling& sampling, bool cubic);

/// What is needed to draw pairs from planes.
struct PairShape {
  int slices = 0, columns = 0;
};
/// As many slices as the stack has and the planes allow, at most `most`. 0 where no plane allows any.
PairShape pairShape(const TrainingPlanes& planes, const SliceSampling& sampling, std::int64_t stackSlices,
                    PairShape most);
/// The random numbers of part `index` of a work, apart from those of all other parts.
Random randomOf(std::uint64_t seed, std::int64_t index);
/// A place with enough of the body, of `random`'s choice.
PairPlace randomPlace(const std::vector<TrainingPlane>& planes, const SliceSampling& sampling,
                      const PairShape& shape, Random& random);

/// Ridge regression on pairs, drawn towards interpolation where the pairs say little. `slices`: of the stack.
PatchFilter learnFilter(const TrainingPlanes& planes, const SliceSampling& sampling, const PairShape& shape,
                        double pairNoise, std::uint64_t seed, const MatrixKernels& kernels, ThreadPool& pool);

/// out[sample][outputStride] += weights · features: the thin samples' difference from the patch mean, by
/// its deviation.
void applyFilter(const PatchFilter& filter, const PatchFeatures& features, const MatrixKernels& kernels,
                 float* out);

} // namespace innergs
