#pragma once
#include "Core/Job/ReconstructionJob.h"

namespace innergs {

/// Seconds that a job will take with its second fit, roughly: often within a factor of two where nothing else
/// runs, an upper bound where a stop rule may end the fit. On the CPU a job of the same kind on a few
/// thousand voxels is timed for that, some tens of milliseconds at the first call for given settings and
/// spacings; on another device the last fit there counts, and before the first one the time is unknown: 0. As
/// for the memory, the lattices of the stacks and of the output are enough: voxels and mask are not looked
/// at. Throws Error for settings and lattices that the job would refuse.
double estimateSeconds(const ReconstructionInput& input, const Settings& settings);

/// What a fit that ran to its end on another device than the CPU took, for estimates to come.
void rememberSpeed(const ReconstructionInput& input, const ReconstructionResult& result);

} // namespace innergs
