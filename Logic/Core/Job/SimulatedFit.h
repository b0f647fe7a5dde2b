#pragma once
#include "Core/Job/ReconstructionJob.h"

namespace innergs {

/// A fit of simulated scans for the uncertainty of another fit. It runs twice: on all slices, and without
/// some.
struct SimulatedFit {
  ReconstructionInput input;
  Settings settings;
};

/// The fit of simulated stacks on `grid`, set up like that of `input`, whose volume lies on `output`.
SimulatedFit simulatedFit(std::vector<Stack> stacks, const GridGeometry& grid, const GridGeometry& output,
                          const ReconstructionInput& input, const Settings& settings);

/// For estimates: without voxels, in the middle of the first stack.
SimulatedFit simulatedOutline(const ReconstructionInput& input, const Settings& settings);

} // namespace innergs
