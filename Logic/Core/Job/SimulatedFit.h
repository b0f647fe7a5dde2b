#pragma once
#include "Core/Job/ReconstructionJob.h"

namespace innergs {

/// The fit of simulated scans that the uncertainty of another fit needs, twice: to all slices, and without
/// some.
struct SimulatedFit {
  ReconstructionInput input;
  Settings settings;
};

/// Of the stacks on the grid, like the fit of `input` whose volume lies on `output`.
SimulatedFit simulatedFit(std::vector<Stack> stacks, const GridGeometry& grid, const GridGeometry& output,
                          const ReconstructionInput& input, const Settings& settings);

/// For estimates: without voxels, in the middle of the first stack.
SimulatedFit simulatedOutline(const ReconstructionInput& input, const Settings& settings);

} // namespace innergs
