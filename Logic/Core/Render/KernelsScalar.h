#pragma once
#include "Core/Render/Kernels.h"

namespace innergs {

/// KernelSet "scalar": one voxel after the other, the oracle of all fast paths.
KernelSet scalarKernels(Selection selection);

} // namespace innergs
