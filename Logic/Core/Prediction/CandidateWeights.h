#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Image/Stack.h"

#include <array>
#include <vector>

namespace innergs {

/// The classical interpolations along the slice axis.
enum class Candidate { Linear, Cubic /* B-spline through the samples */, Lanczos /* radius 4 */ };
constexpr int kCandidates = 3;
const char* candidateName(Candidate candidate);

/// A linear map from the slices of a scan to samples between them: value[z] = Σ weight[z][t]·slice[first[z] +
/// t].
struct SliceWeights {
  std::vector<std::int64_t> first;
  std::vector<std::vector<float>> weight;
};

/// positions: in slices, from 0; beyond the outermost slices their value continues.
SliceWeights candidateWeights(Candidate candidate, std::int64_t slices, std::span<const double> positions);
/// Σ share[c]·candidate c.
SliceWeights combinedWeights(const std::array<double, kCandidates>& share, std::int64_t slices,
                             std::span<const double> positions);

/// planes: [positions][samples] from slices [slices][samples].
void applyWeights(const SliceWeights& weights, std::span<const float> slices, std::int64_t samples,
                  std::span<float> planes, ThreadPool& pool);

/// Positions of a lattice's planes in the slices of a stack. Throws Error(InvalidArgument) unless the two
/// lattices are the same in-plane.
std::vector<double> planePositions(const GridGeometry& stack, const GridGeometry& grid);

/// The stack's voxels with every unobserved or non-finite one replaced: by a cubic spline along its column
/// where the column shows others on both sides, else by the nearest of its column, else of its slice.
std::vector<float> completeSlices(const Stack& stack, ThreadPool& pool);

} // namespace innergs
