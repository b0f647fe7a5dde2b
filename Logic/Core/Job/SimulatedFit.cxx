#include "Core/Job/SimulatedFit.h"

#include "Core/Job/JobInput.h"
#include "Core/Uncertainty/SimulatedGrids.h"

#include <algorithm>
#include <cmath>

namespace innergs {

SimulatedFit simulatedFit(std::vector<Stack> stacks, const GridGeometry& grid, const GridGeometry& output,
                          const ReconstructionInput& input, const Settings& settings) {
  SimulatedFit fit{{}, settings};
  fit.input.heldOutFraction = std::max(heldOutFraction(input), kUsualFraction);
  fit.settings.align = false;
  fit.settings.biasField = BiasFieldKind::Off;
  fit.settings.n4 = false;
  fit.settings.sliceMotion = SliceMotionKind::Off;
  if (settings.gaussians) {
    const auto volumeOf = [](const GridGeometry& g) {
      const Vec3 extent = g.extent();
      return extent[0] * extent[1] * extent[2];
    };
    const double share = std::min(1.0, volumeOf(grid) / volumeOf(output));
    fit.settings.gaussians =
        std::max<std::int64_t>(1, std::llround(share * static_cast<double>(*settings.gaussians)));
  }
  fit.input.stacks = std::move(stacks);
  fit.input.outputGrid = grid;
  return fit;
}

SimulatedFit simulatedOutline(const ReconstructionInput& input, const Settings& settings) {
  const GridGeometry grid = simulationGrid(input.stacks, input.stacks.front().image.geometry.centre());
  return simulatedFit(simulatedGrids(input.stacks, grid), grid,
                      input.outputGrid ? *input.outputGrid : defaultOutputGrid(input.stacks), input,
                      settings);
}

} // namespace innergs
