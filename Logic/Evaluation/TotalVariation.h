#pragma once
#include "Core/Image/Stack.h"

#include <span>
#include <stop_token>

namespace innergs {

struct TotalVariationSettings {
  /// λ relative to half the squared differences, with intensities in units of the stacks' range. Measured on
  /// ICBM152, studyforrest and an abdominal MR: the best is between 0.0005 and 0.002, and 80 iterations are
  /// within 0.1 dB of the limit, mostly above it.
  double weight = 0.001;
  int iterations = 80;
  int threads = 0; // 0 = all cores
  std::stop_token stop;
};

/// Total-variation super-resolution: the volume x that minimises ½ Σ (A x − slices)² + λ TV(x), where A
/// averages over the slice profile (Shi et al. 2015, with one or several stacks), by preconditioned
/// primal-dual steps (Pock and Chambolle 2011) starting from cubic B-splines. Throws Error(InvalidArgument)
/// unless every stack's pixels are the grid's and its slices lie along one of the grid's axes;
/// Error(Cancelled) when stopped.
Volume totalVariation(std::span<const Stack> stacks, const GridGeometry& grid,
                      const TotalVariationSettings& settings = {});

} // namespace innergs
