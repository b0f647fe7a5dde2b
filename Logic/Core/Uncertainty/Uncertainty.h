#pragma once
#include "Core/Uncertainty/ErrorTransfer.h"

#include <string>

namespace innergs {

/// How far a reconstructed volume may be from the tissue.
struct Uncertainty {
  Volume
      deviation; // standard deviation, scanner units: the truth lies within 1.645 of it in 90 % of the voxels
  std::vector<std::uint8_t> measured; // on the same grid: 0 where no slice measured anything
  double shading = 0;                 // of the values, for shading unknown to every scan; in the deviation
  double noise = 0;                   // of a single measured value beyond that, scanner units
  double coverage = 0;      // share of held-out voxels inside their 90 % intervals (NaN: unknown), in
  std::int64_t samples = 0; // that many voxels, of slices that the intervals were not learned from
};

struct UncertaintyInput {
  const Volume& result;          // fitted to all slices
  const Volume& second;          // fitted without the held-out ones, on any grid
  std::span<const Stack> stacks; // as they lie in the result
  bool moved;                    // whether their slices were moved there
  std::span<const HeldOutValue> seen;
  double noise = 0;      // standard deviation of the stacks' noise
  double shading = 0;    // standard deviation, of the values, of a smooth shading that all stacks may share
  const PairFitter& fit; // of simulated scans, in the same way
};

/// What the second fit misses of the held-out slices tells how far it is off for a given local detail; a
/// simulation (ErrorTransfer) tells what that means for the voxels of the result. Where no slice is near, the
/// deviation is that of all values. A shading that all stacks share shows in none of this, so its deviation
/// is added. Throws Error(NoData) where too few voxels were held out, Error(Cancelled).
Uncertainty estimateUncertainty(const UncertaintyInput& input, ThreadPool& pool);

/// A standard deviation on another grid: interpolated inside its own, the largest value outside. Throws
/// Error(Cancelled).
Volume deviationOn(const GridGeometry& grid, const Volume& deviation, ThreadPool& pool);

/// How often the intervals held and how much of the output was measured, as text for the user.
std::string uncertaintySentence(const Uncertainty& uncertainty);

} // namespace innergs
