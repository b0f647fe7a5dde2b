#pragma once
#include "Core/Fit/Trainer.h"

namespace innergs {

/// What the choices depend on, measured from the input.
struct DataTraits {
  double voxel = 1;     // finest in-plane spacing of all stacks, mm
  double gap = 1;       // largest distance between slices of a stack, mm
  double thickness = 0; // largest slice thickness that acts as a blur, mm (0: thin slices)
  double noise = 0;     // standard deviation, normalised intensity
  int stacks = 1;
  std::int64_t samples = 0; // finite observed voxels
  double volume = 0;   // of the finite voxels, observed or not, mm³; what several stacks see counts once
  double reached = 1;  // share of a start over all of it that matters to what is observed (reachedShare)
  bool region = false; // of larger scans
  bool posed = false;  // slices with poses
  bool cubes = false;  // one stack in one piece, thin slices, voxels that are nearly cubes
  /// One stack with slices clearly farther apart than its pixels: the fit must bridge the gaps.
  bool singleAnisotropic() const { return stacks == 1 && gap > 1.4 * voxel; }
  bool superResolution() const { return gap > 1.4 * voxel; }
};
/// Whether a fit of these data begins with a prediction of what lies between the slices: the field is then
/// fitted to an isotropic volume.
bool predicts(const Settings& settings, const DataTraits& traits);
/// What the lattices alone say: voxel, gap, thickness, stacks, volume (as if all were observed), posed,
/// cubes.
DataTraits geometryTraits(std::span<const Stack> stacks);
/// All but reached; the same whatever the order of the stacks.
DataTraits measureTraits(std::span<const Stack> stacks, const IntensityMap& map);

/// All numbers of a fit from settings and data; fills the optionals of `settings`. Super-resolution fits
/// several members: fields with shifted or redrawn starts, fitted independently and merged into one
/// normalised field, which is close to their average and so leaves out what each invents where the data say
/// nothing. settings.gaussians is the budget of one member. The measurements behind the constants are in
/// Docs/benchmarks.md. Throws Error(InvalidArgument) when the data do not allow what the settings ask for.
FitPlan makePlan(Settings& settings, const DataTraits& traits);

/// The normalised intensities of a fit: offset = smallest, scale = largest − smallest finite observed value,
/// outliers (0.01 % each side) left out.
IntensityMap chooseIntensityMap(std::span<const Stack> stacks);

} // namespace innergs
