#pragma once
#include "Core/Render/Kernels.h"

namespace innergs {

/// KernelSet "scalar": one voxel at a time, the reference for all fast paths.
KernelSet scalarKernels(Selection selection);

} // namespace innergs
