#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Prediction/Kriging.h"

#include <array>
#include <vector>

namespace innergs {

/// Interpolations along the slice axis.
enum class Candidate { Linear, Cubic /* B-spline through the samples */, Lanczos /* radius 4 */, Kriging };
constexpr int kCandidates = 4;
const char* candidateName(Candidate candidate);

/// A linear map from a scan's slices to samples between them: value[z] = Σ weight[z][t]·slice[first[z] + t].
struct SliceWeights {
  std::vector<std::int64_t> first;
  std::vector<std::vector<float>> weight;
};

/// Kriging between the slices of a stack, for a signal blurred by σ = blur mm.
Kriging krigingOf(const Stack& stack, double blur);

/// positions: in slices, from 0; beyond the outermost slices their values continue.
SliceWeights candidateWeights(Candidate candidate, const Kriging& kriging, std::int64_t slices,
                              std::span<const double> positions);
/// Σ share[c]·candidate c.
SliceWeights combinedWeights(const std::array<double, kCandidates>& share, const Kriging& kriging,
                             std::int64_t slices, std::span<const double> positions);

/// planes: [positions][samples] from slices [slices][samples].
void applyWeights(const SliceWeights& weights, std::span<const float> slices, std::int64_t samples,
                  std::span<float> planes, ThreadPool& pool);

/// Positions of a grid's planes, in slices of a stack. Throws Error(InvalidArgument) unless the two
/// grids agree in-plane.
std::vector<double> planePositions(const GridGeometry& stack, const GridGeometry& grid);

/// The stack's voxels with every unobserved or non-finite one replaced: by a cubic spline along its column if
/// there are known ones on both sides, else by the nearest in its column, else in its slice.
std::vector<float> completeSlices(const Stack& stack, ThreadPool& pool);

} // namespace innergs
