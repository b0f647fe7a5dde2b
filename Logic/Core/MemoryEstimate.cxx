#include "Core/JobInput.h"
#include "Core/Plan.h"
#include "Core/Projected.h"

#include <algorithm>
#include <cmath>

namespace innergs {

std::int64_t estimateMemory(const ReconstructionInput& input, const Settings& settings) {
  if (input.stacks.empty()) return 0;
  DataTraits traits;
  traits.stacks = static_cast<int>(input.stacks.size());
  traits.voxel = 1e300;
  for (const Stack& stack : input.stacks) {
    const Vec3& spacing = stack.image.geometry.spacing;
    traits.voxel = std::min({traits.voxel, spacing[0], spacing[1]});
    traits.gap = std::max(traits.gap, spacing[2]);
  }
  double largest = 0, samples = 0;
  for (const Stack& stack : input.stacks) {
    const GridGeometry& g = stack.image.geometry;
    const double padded = static_cast<double>((g.size[0] + 15) / 16 * 16) * static_cast<double>(g.size[1]) *
                          static_cast<double>(g.size[2]);
    const auto planes =
        profileQuadrature(stack.profile, effectiveThickness(stack), std::min(g.spacing[0], g.spacing[1]));
    samples += padded;
    largest = std::max(largest, padded * static_cast<double>(planes.offset.size()));
  }
  const Vec3 extent = input.stacks.front().image.geometry.extent();
  traits.volume = extent[0] * extent[1] * extent[2];
  const double proxy = traits.volume / std::pow(traits.voxel, 3);
  Settings filled = settings;
  makePlan(filled, traits);
  const double gaussians = static_cast<double>(*filled.gaussians);
  const GridGeometry grid = input.outputGrid ? *input.outputGrid : defaultOutputGrid(input.stacks);
  const double copies = samples * 5 /* the job's own stacks */ + samples * 5 /* targets and weights */;
  const double merged = gaussians * filled.members.value_or(1) * (2 * 64.0 + sizeof(Projected));
  const double fit = merged + largest * 8 /* W, N */ + gaussians * (4 * 64.0 + sizeof(Projected) + 32);
  const double start = proxy * 13 /* values, coverage, density and its smoothing */;
  const double output = static_cast<double>(grid.voxelCount()) * 4 + 64e6;
  const double domain = static_cast<double>(dataDomain(input.stacks).voxelCount());
  const double detail = traits.superResolution() && settings.consistency ? domain * 12 + samples * 4 : 0;
  return static_cast<std::int64_t>(copies + std::max({fit, start, detail}) + output);
}

} // namespace innergs
