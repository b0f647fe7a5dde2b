#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Image/Stack.h"

#include <string>

namespace innergs {

/// What a scan reveals about its slices.
struct ProfileEstimate {
  bool known = false;    // false: the scan does not show it, the sentence says why
  double thickness = 0;  // mm: width of the box, or FWHM for a stack of Gaussian profile
  double spacing = 0;    // mm: distance of the slices
  double confidence = 0; // 0…1
  std::string sentence; // "slices look 6 mm thick, 3 mm apart"
};

/// Compares the structure along and across the slices inside the body, with noise subtracted. Ignores
/// held-out and non-finite voxels. Throws Error(Cancelled) if the pool is stopped.
ProfileEstimate estimateProfile(const Stack& stack, ThreadPool& pool);

} // namespace innergs
