#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Image/Stack.h"

namespace innergs {

/// Takes noise out of `missed` (predicted − fitted, on the lattice of `predicted`, its units) by wienerFilter()
/// in every plane, and out of `predicted` likewise. Each plane has its own noise, scanNoise (standard
/// deviation, the same units) at most. Throws Error(Cancelled).
void removePredictionNoise(Volume& missed, Stack& predicted, double scanNoise, ThreadPool& pool);

} // namespace innergs
