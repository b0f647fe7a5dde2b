#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Image/Stack.h"

namespace innergs {

/// The part of a scan's noise (standard deviation) that no other of its slices predicts: all of it, unless
/// the slices are smooth across.
double unpredictedNoise(const Stack& scan, double noise);

/// Takes noise out of `missed` (predicted − fitted, on the grid of `predicted`, its units) by
/// wienerFilter() in every plane, and out of `predicted` likewise. Each plane has its own noise, scanNoise
/// (standard deviation, the same units) at most. Throws Error(Cancelled).
void removePredictionNoise(Volume& missed, Stack& predicted, double scanNoise, ThreadPool& pool);

} // namespace innergs
