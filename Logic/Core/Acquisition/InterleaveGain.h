#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Image/Stack.h"

#include <string>

namespace innergs {

/// How much brighter the odd slices (K) of a scan are than the even ones, as from cross-talk between slices
/// that were acquired in two interleaved passes: a ratio, the median over slices of the body's median ratio
/// to the mean of its neighbours. 1 where that is less than 1 % or four standard errors, or where fewer than
/// four fifths of the slices show it; with fewer than six slices to judge by, where values may be negative,
/// and for slices with poses. Uses observed voxels only. Throws Error(Cancelled).
double interleaveGain(const Stack& scan, ThreadPool& pool);

/// Makes slices equally bright whose odd ones are brighter by `gain`; their geometric mean stays.
void evenOutInterleaves(double gain, Stack& scan);

/// A sentence for the user; "" for a gain of 1.
std::string interleaveGainSentence(double gain, const std::string& name);

} // namespace innergs
