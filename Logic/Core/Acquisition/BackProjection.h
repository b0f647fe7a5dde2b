#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Image/Stack.h"

#include <limits>
#include <span>

namespace innergs {

/// Weights of neighbouring slices, from −n to n, with which differences are spread over them before they are
/// back-projected: {1}, but the slices' profile where thick boxes overlap so far that it inverts the finest
/// structure across them, which back-projection would amplify. thickness: in slice distances; `most`: up to
/// which there is nothing to spread.
std::vector<double> spreadingWeights(SliceProfile profile, double thickness, double most = 2);

struct BackProjectionPlan {
  int iterations = 12; // maximum
  double noise = 0;    // standard deviation, units of the stacks: left out of the first differences
  double stopAt = 0;   // root mean square of the differences, units of the stacks
  ValueRange range{-std::numeric_limits<float>::infinity(), // limits every voxel inside the stacks
                   std::numeric_limits<float>::infinity()};
};

/// Iterative back-projection (Irani and Peleg 1991) from the volume as it stands: the trilinearly
/// interpolated difference between each stack and the volume's projection onto it, spread over overlapping
/// slices and pixels (spreadingWeights()), is added, averaged over the stacks. What plan.noise explains of
/// the first differences is left out. Unobserved and non-finite samples count as met (difference 0). Between
/// posed slices the difference is the mean of those within a slice distance, by their nearness. Returns the
/// root mean square of the last differences from the stacks as they are, noise included.
double backProject(Volume& volume, std::span<const Stack> stacks, const BackProjectionPlan& plan,
                   ThreadPool& pool);

} // namespace innergs
