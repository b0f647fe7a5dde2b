#pragma once
#include "Core/Image/Stack.h"

#include <span>
#include <stop_token>

namespace innergs {

struct BackProjectionSettings {
  int iterations = 12;     // maximum
  bool stopAtNoise = true; // also stops when the differences are well below the stacks' estimated noise
  int threads = 0;         // 0 = all cores
  std::stop_token stop;
};

/// Iterative back-projection (Irani and Peleg 1991) as a stand-alone method, starting from the average of the
/// cubically upsampled stacks. Throws Error(Cancelled) when stopped, and what upsample() throws.
Volume backProjectionBaseline(std::span<const Stack> stacks, const GridGeometry& grid,
                              const BackProjectionSettings& settings = {});

} // namespace innergs
