#pragma once
#include "Core/Image/CubicConvolution.h"

namespace innergs {

/// The plain reference of the SIMD ones.
CubicConvolution scalarCubicConvolution();

} // namespace innergs
