#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Image/CubicConvolution.h"
#include "Core/Image/Stack.h"

namespace innergs {

/// The volume as the stack's scanner would see it: integrated over the slice profile along the stack's
/// normal, and over the pixels' width, at the stack's voxels, by cubic convolution with this parameter. NaN
/// where all of that lies outside the volume and where the stack is not observed.
std::vector<float> projectToStack(const Volume& volume, const Stack& stack, ThreadPool& pool,
                                  float keys = kKeys);

} // namespace innergs
