#pragma once
#include "Core/Stack.h"

#include <stop_token>

namespace innergs {

struct BackProjectionSettings {
  int iterations = 12;     // at most
  bool stopAtNoise = true; // and until the differences are well below the stacks' estimated noise
  int threads = 0;         // 0 = all cores
  std::stop_token stop;
};

/// The volume as the stack's scanner would see it: integrated over the slice profile along the stack's
/// normal, at the stack's voxels. NaN where the profile lies outside the volume altogether.
std::vector<float> projectToStack(const Volume& volume, const Stack& stack, int threads = 0);

/// Iterative back-projection (Irani and Peleg 1991): starts from the average of the cubic upsampled stacks,
/// then adds the upsampled differences between each stack and the volume's projection onto it. Throws
/// Error(Cancelled) when stopped, and what upsample() throws.
Volume backProject(std::span<const Stack> stacks, const GridGeometry& grid,
                   const BackProjectionSettings& settings = {});

} // namespace innergs
