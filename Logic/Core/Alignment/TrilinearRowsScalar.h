#pragma once
#include "Core/Alignment/TrilinearRows.h"

namespace innergs {

/// The plain reference of the SIMD ones.
TrilinearRows scalarTrilinearRows();

} // namespace innergs
