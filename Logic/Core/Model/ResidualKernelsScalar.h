#pragma once
#include "Core/Model/ResidualKernels.h"

namespace innergs {

/// The plain reference of the SIMD ones.
ResidualKernels scalarResidualKernels();

} // namespace innergs
